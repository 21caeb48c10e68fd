// A = c LᵀL + BᵀB without a matrix, and the smoother: with K = N - A_dj, LᵀL = K N⁻² K.
// Twin: `solver::NormalOperator`.
struct Level {
    // c
    scale: f32,
    // Smoother a (alpha N + beta K) a.
    alpha: f32,
    beta: f32,
}

@group(0) @binding(0) var<uniform> level: Level;
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
@group(0) @binding(2) var<storage, read> neighbours: array<u32>;
@group(0) @binding(3) var<storage, read> x: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> out: array<vec4f>;
// Rows of BᵀB: (column, value's bits).
@group(0) @binding(5) var<storage, read> anchor_offsets: array<u32>;
@group(0) @binding(6) var<storage, read> anchor_entries: array<vec2u>;
// c N⁻² K x, by `halfway`.
@group(0) @binding(7) var<storage, read> middle: array<vec4f>;
@group(0) @binding(8) var<storage, read> side: array<vec4f>;
// a
@group(0) @binding(9) var<storage, read> scaling: array<f32>;

fn valence(k: u32) -> f32 {
    return f32(max(offsets[k + 1u] - offsets[k], 1u));
}

@compute @workgroup_size(64)
fn halfway(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&out) {
        return;
    }
    let own = x[k];
    var sum = vec4f();
    for (var i = offsets[k]; i < offsets[k + 1u]; i++) {
        sum += own - x[neighbours[i]];
    }
    out[k] = level.scale / (valence(k) * valence(k)) * sum;
}

fn other_half(k: u32) -> vec4f {
    let own = middle[k];
    var sum = vec4f();
    for (var i = offsets[k]; i < offsets[k + 1u]; i++) {
        sum += own - middle[neighbours[i]];
    }
    for (var i = anchor_offsets[k]; i < anchor_offsets[k + 1u]; i++) {
        let entry = anchor_entries[i];
        sum += bitcast<f32>(entry.y) * x[entry.x];
    }
    return sum;
}

// out = A x
@compute @workgroup_size(64)
fn product(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] = other_half(id.x);
    }
}

// out = side - A x
@compute @workgroup_size(64)
fn residual(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] = side[id.x] - other_half(id.x);
    }
}

// out = c Lᵀ x
@compute @workgroup_size(64)
fn right_side(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&out) {
        return;
    }
    let own = x[k] / valence(k);
    var sum = vec4f();
    for (var i = offsets[k]; i < offsets[k + 1u]; i++) {
        let j = neighbours[i];
        sum += own - x[j] / valence(j);
    }
    out[k] = level.scale * sum;
}

fn smoothed(k: u32) -> vec4f {
    let own = scaling[k] * x[k];
    var sum = vec4f();
    for (var i = offsets[k]; i < offsets[k + 1u]; i++) {
        let j = neighbours[i];
        sum += own - scaling[j] * x[j];
    }
    return scaling[k] * (level.alpha * valence(k) * own + level.beta * sum);
}

// out = Q x
@compute @workgroup_size(64)
fn smooth_first(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] = smoothed(id.x);
    }
}

// out += Q x
@compute @workgroup_size(64)
fn smooth_more(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] += smoothed(id.x);
    }
}
