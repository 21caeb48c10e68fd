// A multilayer perceptron on a batch of vertices. Twin: `network::Mlp::evaluate`.
//
// Activations lie feature after feature, a vertex each within, so that neighbouring threads read neighbouring numbers. `real` is f16
// where the adapter has it; sums over more than sixteen products are f32 always.
struct Layer {
    // Rounded up to 16, and the rows of the weight.
    input_count: u32,
    // Rounded up to 64, and the columns of the weight.
    output_count: u32,
    // Vertices of a batch, a multiple of 128.
    row_count: u32,
    // Of the first layer's inputs, how many are coordinates, and then angles.
    encoded_count: u32,
    frequency_count: u32,
    output_scale: f32,
}

@group(0) @binding(1) var<uniform> layer: Layer;

// theta's share of the first layer, for each mask: bias + W theta.
@group(0) @binding(2) var<storage, read> distinct_masks: array<u32>;
@group(0) @binding(3) var<storage, read> pose_weight: array<f32>;
@group(0) @binding(4) var<storage, read> first_bias: array<f32>;
@group(0) @binding(5) var<storage, read_write> pose_bias: array<f32>;

@compute @workgroup_size(64)
fn pose_biases(@builtin(global_invocation_id) id: vec3u) {
    let output = id.x;
    var sum = first_bias[output];
    for (var mask = distinct_masks[id.y]; mask != 0u; mask &= mask - 1u) {
        let joint = firstTrailingBit(mask);
        for (var axis = 0u; axis < 3u; axis++) {
            sum += pose_weight[(3u * joint + axis) * layer.output_count + output] * frame.joints[joint].angles[axis];
        }
    }
    pose_bias[id.y * layer.output_count + output] = sum;
}

@group(0) @binding(6) var<storage, read> canonical: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> encoded: array<real>;

// sin(pi t), t of any size, within 1e-7 (Taylor's series after folding): WGSL promises no more than 5e-4 of its own sine.
fn sine(t: vec3f) -> vec3f {
    let turned = t - 2.0 * round(0.5 * t);
    let folded = 0.5 - abs(0.5 - abs(turned));
    let square = folded * folded;
    let series = 3.14159265 + square * (-5.16771278 + square * (2.55016404
        + square * (-0.599264529 + square * (0.0821458866 - 0.00737043095 * square))));
    return sign(turned) * folded * series;
}

@compute @workgroup_size(64)
fn encode(@builtin(global_invocation_id) id: vec3u) {
    let point = canonical[id.x].xyz;
    for (var axis = 0u; axis < 3u; axis++) {
        encoded[axis * layer.row_count + id.x] = real(point[axis]);
    }
    for (var i = 0u; i < layer.frequency_count; i++) {
        let turned = point * exp2(f32(i));
        let sines = sine(turned);
        let cosines = sine(turned + 0.5);
        for (var axis = 0u; axis < 3u; axis++) {
            encoded[(3u + 6u * i + axis) * layer.row_count + id.x] = real(sines[axis]);
            encoded[(6u + 6u * i + axis) * layer.row_count + id.x] = real(cosines[axis]);
        }
    }
    for (var i = layer.encoded_count; i < layer.input_count; i++) {
        encoded[i * layer.row_count + id.x] = real(0.0);
    }
}

@group(0) @binding(8) var<storage, read> weight: array<vec4<real>>;
// A row for each mask; a single one after the first layer.
@group(0) @binding(9) var<storage, read> bias: array<f32>;
@group(0) @binding(10) var<storage, read> bias_rows: array<u32>;
@group(0) @binding(11) var<storage, read> input: array<vec4<real>>;
@group(0) @binding(12) var<storage, read_write> output: array<vec4<real>>;

// Sixteen inputs of 128 vertices, and their weights for 64 outputs; four numbers each.
var<workgroup> input_tile: array<vec4<real>, 512>;
var<workgroup> weight_tile: array<vec4<real>, 256>;

// Four outputs of four vertices, twice: sums[2 output + half], a vertex a lane.
fn tile_sums(group: vec3u, lane: u32) -> array<vec4f, 8> {
    let input_stride = layer.row_count / 4u;
    let weight_stride = layer.output_count / 4u;
    let vertex = lane % 16u;
    let output = lane / 16u;
    var sums = array<vec4f, 8>();
    for (var first = 0u; first < layer.input_count; first += 16u) {
        for (var i = lane; i < 512u; i += 256u) {
            input_tile[i] = input[(first + i / 32u) * input_stride + 32u * group.x + i % 32u];
        }
        weight_tile[lane] = weight[(first + lane / 16u) * weight_stride + 16u * group.y + lane % 16u];
        workgroupBarrier();
        var x0 = vec4<real>();
        var x1 = vec4<real>();
        var y0 = vec4<real>();
        var y1 = vec4<real>();
        var z0 = vec4<real>();
        var z1 = vec4<real>();
        var w0 = vec4<real>();
        var w1 = vec4<real>();
        for (var i = 0u; i < 16u; i++) {
            let a0 = input_tile[32u * i + vertex];
            let a1 = input_tile[32u * i + 16u + vertex];
            let b = weight_tile[16u * i + output];
            x0 += b.x * a0;
            x1 += b.x * a1;
            y0 += b.y * a0;
            y1 += b.y * a1;
            z0 += b.z * a0;
            z1 += b.z * a1;
            w0 += b.w * a0;
            w1 += b.w * a1;
        }
        sums[0] += vec4f(x0);
        sums[1] += vec4f(x1);
        sums[2] += vec4f(y0);
        sums[3] += vec4f(y1);
        sums[4] += vec4f(z0);
        sums[5] += vec4f(z1);
        sums[6] += vec4f(w0);
        sums[7] += vec4f(w1);
        workgroupBarrier();
    }
    return sums;
}

// A hidden layer: a workgroup for 128 vertices and 64 outputs.
@compute @workgroup_size(256)
fn hidden(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    var sums = tile_sums(group, lane);
    for (var half = 0u; half < 2u; half++) {
        let four = 32u * group.x + 16u * half + lane % 16u;
        let rows = layer.output_count
            * vec4u(bias_rows[4u * four], bias_rows[4u * four + 1u], bias_rows[4u * four + 2u], bias_rows[4u * four + 3u]);
        for (var i = 0u; i < 4u; i++) {
            let at = 64u * group.y + 4u * (lane / 16u) + i;
            let biases = vec4f(bias[rows.x + at], bias[rows.y + at], bias[rows.z + at], bias[rows.w + at]);
            output[at * (layer.row_count / 4u) + four] = vec4<real>(max(sums[2u * i + half] + biases, vec4f()));
        }
    }
}

@group(0) @binding(13) var<storage, read> last_input: array<real>;
// Three outputs and nothing.
@group(0) @binding(14) var<storage, read> last_weight: array<vec4f>;
@group(0) @binding(15) var<storage, read_write> values: array<vec4f>;

@compute @workgroup_size(64)
fn last(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&values) {
        return;
    }
    let row = layer.output_count * bias_rows[id.x];
    var sum = vec4f(bias[row], bias[row + 1u], bias[row + 2u], 0.0);
    for (var i = 0u; i < layer.input_count; i++) {
        sum += f32(last_input[i * layer.row_count + id.x]) * last_weight[i];
    }
    values[id.x] = layer.output_scale * sum;
}
