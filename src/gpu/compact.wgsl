// A compact surface function: coefficients of each region, then tables on vertices.
// Twin: `network::Compact::evaluate`.
struct Region {
    mask: u32,
    kernel_length: f32,
    basis_count: u32,
    first_coefficient: u32,
    // In numbers, a multiple of four.
    first_factor: u32,
    centre_count: u32,
    // The first ones, which poses far from training recall.
    recalled_count: u32,
    joint_count: u32,
    // Greatest kernel up to which nothing counts that was learnt, and from which on it counts in full; 0 and 0 where it always counts.
    fade_nothing: f32,
    fade_full: f32,
}

@group(0) @binding(1) var<storage, read> regions: array<Region>;
// Six numbers a joint: the first two columns of its rotation.
@group(0) @binding(2) var<storage, read> centres: array<f32>;
// Of each region (K, centres) coefficients from kernel, then (K, recalled centres) coefficients at training poses; all times the size of a
// step of the basis.
@group(0) @binding(3) var<storage, read> coefficient_from_kernel: array<f32>;
@group(0) @binding(4) var<storage, read_write> new_factors: array<f32>;

var<workgroup> kernel: array<f32, 64>;

fn matern_kernel(region: Region, centre: u32) -> f32 {
    var squared = 0.0;
    for (var mask = region.mask; mask != 0u; mask &= mask - 1u) {
        let joint = firstTrailingBit(mask);
        let rotation = frame.joints[joint].rotation;
        let at = 6u * (centre * region.joint_count + joint);
        let x = rotation[0] - vec3f(centres[at], centres[at + 1u], centres[at + 2u]);
        let y = rotation[1] - vec3f(centres[at + 3u], centres[at + 4u], centres[at + 5u]);
        squared += dot(x, x) + dot(y, y);
    }
    let ratio = sqrt(3.0 * squared) / region.kernel_length;
    return (1.0 + ratio) * exp(-ratio);
}

// Power of the kernel in the weights over the kernel's length, where what was learnt fades.
const RECALL_POWER = 4.6;
// Poses whose sum of weights is no more than this recall little.
const LEAST_RECALL = 1e-30;

// A workgroup for each region.
@compute @workgroup_size(64)
fn coefficients(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let region = regions[group.x];
    let first_recalled = region.first_coefficient + region.basis_count * region.centre_count;
    for (var first_k = 0u; first_k < region.basis_count; first_k += 64u) {
        let k = first_k + lane;
        var sum = 0.0;
        var recalled = 0.0;
        var weights = 0.0;
        let power = select(2.0, RECALL_POWER * region.kernel_length, region.fade_full > 0.0);
        var largest = 0.0;
        for (var first = 0u; first < region.centre_count; first += 64u) {
            let count = min(64u, region.centre_count - first);
            if lane < count {
                kernel[lane] = matern_kernel(region, first + lane);
            }
            workgroupBarrier();
            if k < region.basis_count {
                let row = region.first_coefficient + k * region.centre_count + first;
                for (var i = 0u; i < count; i++) {
                    sum += coefficient_from_kernel[row + i] * kernel[i];
                }
                for (var i = 0u; i < count && first + i < region.recalled_count; i++) {
                    let weight = pow(kernel[i], power);
                    weights += weight;
                    largest = max(largest, kernel[i]);
                    recalled += coefficient_from_kernel[first_recalled + k * region.recalled_count + first + i] * weight;
                }
            }
            workgroupBarrier();
        }
        if k < region.basis_count {
            var learnt = 1.0;
            var share = (1.0 - largest) * (1.0 - largest);
            if region.fade_full > 0.0 {
                learnt = smoothstep(region.fade_nothing, region.fade_full, largest);
                share = 1.0 - learnt;
            }
            new_factors[region.first_factor + k] =
                learnt * sum + frame.liveliness * share * recalled / (weights + LEAST_RECALL);
        }
    }
}

struct Row {
    mean: vec3f,
    // Three words for every four basis vectors: four x, four y, four z, a byte each.
    first_word: u32,
    first_quad: u32,
    quad_count: u32,
}

// Rows of vertex k: row_offsets[k] .. row_offsets[k + 1].
@group(0) @binding(5) var<storage, read> row_offsets: array<u32>;
@group(0) @binding(6) var<storage, read> rows: array<Row>;
@group(0) @binding(7) var<storage, read> basis: array<u32>;
@group(0) @binding(8) var<storage, read> factors: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> values: array<vec4f>;

fn signed_bytes(word: u32) -> vec4f {
    return vec4f((vec4i(i32(word)) << vec4u(24u, 16u, 8u, 0u)) >> vec4u(24u));
}

@compute @workgroup_size(64)
fn tables(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&values) {
        return;
    }
    var value = vec3f();
    for (var i = row_offsets[k]; i < row_offsets[k + 1u]; i++) {
        let row = rows[i];
        value += row.mean;
        for (var quad = 0u; quad < row.quad_count; quad++) {
            let word = row.first_word + 3u * quad;
            let factor = factors[row.first_quad + quad];
            value += vec3f(
                dot(signed_bytes(basis[word]), factor),
                dot(signed_bytes(basis[word + 1u]), factor),
                dot(signed_bytes(basis[word + 2u]), factor),
            );
        }
    }
    values[k] = vec4f(value, 0.0);
}
