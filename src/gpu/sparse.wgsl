// A sparse matrix in compressed rows times a field: subdivision, restriction, prolongation.
// Twin: `mesh::SparseMatrix::apply` and `add_product`.
@group(0) @binding(0) var<storage, read> offsets: array<u32>;
// (column, value's bits)
@group(0) @binding(1) var<storage, read> entries: array<vec2u>;
@group(0) @binding(2) var<storage, read> x: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> out: array<vec4f>;

fn row_product(row: u32) -> vec4f {
    var sum = vec4f();
    for (var i = offsets[row]; i < offsets[row + 1u]; i++) {
        let entry = entries[i];
        sum += bitcast<f32>(entry.y) * x[entry.x];
    }
    return sum;
}

@compute @workgroup_size(64)
fn apply(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] = row_product(id.x);
    }
}

@compute @workgroup_size(64)
fn add(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&out) {
        out[id.x] += row_product(id.x);
    }
}
