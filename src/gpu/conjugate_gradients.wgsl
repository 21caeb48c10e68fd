// Inner products, and the step lengths that follow from them. Twin: `solver::Solver::solve`.
//
// An inner product is left as 64 partial sums; every thread that needs it adds them up for itself, in the same order.
@group(0) @binding(0) var<storage, read> a: array<vec4f>;
@group(0) @binding(1) var<storage, read> b: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> partial: array<vec4f, 64>;

@group(0) @binding(3) var<storage, read> upper: array<vec4f, 64>;
@group(0) @binding(4) var<storage, read> lower: array<vec4f, 64>;
@group(0) @binding(5) var<storage, read> direction: array<vec4f>;
@group(0) @binding(6) var<storage, read> product: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> x: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> residual: array<vec4f>;

var<workgroup> sums: array<vec4f, 256>;

@compute @workgroup_size(256)
fn inner_product(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    var sum = vec4f();
    for (var k = 256u * group.x + lane; k < arrayLength(&a); k += 256u * 64u) {
        sum += a[k] * b[k];
    }
    sums[lane] = sum;
    for (var half = 128u; half > 0u; half >>= 1u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] += sums[lane + half];
        }
    }
    if lane == 0u {
        partial[group.x] = sums[0];
    }
}

// upper / lower by coordinate; zero where lower is not positive, as when that coordinate is solved exactly.
fn ratio() -> vec4f {
    var dividend = vec4f();
    var divisor = vec4f();
    for (var i = 0u; i < 64u; i++) {
        dividend += upper[i];
        divisor += lower[i];
    }
    let positive = divisor > vec4f();
    return select(vec4f(), dividend / select(vec4f(1.0), divisor, positive), positive);
}

// x = direction + x times the ratio of energies
@compute @workgroup_size(64)
fn turn(@builtin(global_invocation_id) id: vec3u) {
    let share = ratio();
    if id.x < arrayLength(&x) {
        // Before the first iteration x may hold anything.
        x[id.x] = direction[id.x] + select(vec4f(), share * x[id.x], share != vec4f());
    }
}

// x += length direction, residual -= length product
@compute @workgroup_size(64)
fn advance(@builtin(global_invocation_id) id: vec3u) {
    let length = ratio();
    if id.x < arrayLength(&x) {
        x[id.x] += length * direction[id.x];
        residual[id.x] -= length * product[id.x];
    }
}
