// The coarsest level: x = Pᵀ Wᵀ D⁻¹ W P b with W = L⁻¹ in half precision.
// Twin: `solver::DirectSolver::solve`.
//
// Steps are in postorder of the elimination tree, so row i of W fills the columns of the subtree of i, which end with i itself, and
// column j fills the rows on the way from j to its root.
struct Row {
    // Where column 0 would be.
    origin: u32,
    first_column: u32,
    reciprocal_diagonal: f32,
    // The way to the root goes on step by step up to here, and then there; none is 0xffffffff.
    run_end: u32,
    next_run: u32,
}

@group(0) @binding(0) var<storage, read> rows: array<Row>;
// Two values of W a word.
@group(0) @binding(1) var<storage, read> values: array<u32>;
@group(0) @binding(2) var<storage, read> side: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> out: array<vec4f>;
// P: the vertex of each step.
@group(0) @binding(4) var<storage, read> vertices: array<u32>;

fn value(at: u32) -> f32 {
    return unpack2x16float(values[at >> 1u])[at & 1u];
}

var<workgroup> sums: array<vec4f, 256>;

// y = D⁻¹ W P b, a workgroup for each row.
@compute @workgroup_size(64)
fn forward(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = group.y * groups.x + group.x;
    var sum = vec4f();
    if i < arrayLength(&rows) {
        let row = rows[i];
        for (var j = row.first_column + lane; j <= i; j += 64u) {
            sum += value(row.origin + j) * side[vertices[j]];
        }
    }
    sums[lane] = sum;
    for (var half = 32u; half > 0u; half >>= 1u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    if lane == 0u && i < arrayLength(&rows) {
        out[i] = rows[i].reciprocal_diagonal * sums[0];
    }
}

// x = Pᵀ Wᵀ y, a workgroup for sixteen columns, sixteen lanes to each.
@compute @workgroup_size(256)
fn backward(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let count = arrayLength(&rows);
    let j = 16u * group.x + lane % 16u;
    var sum = vec4f();
    if j < count {
        var first = j;
        while first != 0xffffffffu {
            let last = rows[first].run_end;
            for (var i = first + lane / 16u; i <= last; i += 16u) {
                sum += value(rows[i].origin + j) * side[i];
            }
            first = rows[first].next_run;
        }
    }
    sums[lane] = sum;
    for (var half = 128u; half >= 16u; half >>= 1u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    if lane < 16u && j < count {
        out[vertices[j]] = sums[lane];
    }
}
