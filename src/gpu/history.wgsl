// A first guess from the last two solutions. Twin: `solver::History`.
//
// Five inner products are left as 64 partial sums each; every workgroup that needs them adds them up, in the same order.
struct Products {
    // In the basis u (the latest) and v (the last change).
    uau: vec4f,
    uav: vec4f,
    vav: vec4f,
    ub: vec4f,
    vb: vec4f,
}

@group(0) @binding(0) var<storage, read> side: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> latest: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> latest_product: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> before_product: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> partial: array<Products, 64>;
@group(0) @binding(6) var<storage, read_write> x: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> residual: array<vec4f>;

var<workgroup> sums: array<Products, 64>;

fn plus(a: Products, b: Products) -> Products {
    return Products(a.uau + b.uau, a.uav + b.uav, a.vav + b.vav, a.ub + b.ub, a.vb + b.vb);
}

// Leaves the sum over all lanes in the first one.
fn add_up(lane: u32) {
    for (var half = 32u; half > 0u; half >>= 1u) {
        workgroupBarrier();
        if lane < half {
            sums[lane] = plus(sums[lane], sums[lane + half]);
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(64)
fn products(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    var sum = Products();
    for (var k = 64u * group.x + lane; k < arrayLength(&side); k += 64u * 64u) {
        let u = latest[k];
        let au = latest_product[k];
        let v = u - before[k];
        let av = au - before_product[k];
        let b = side[k];
        sum = plus(sum, Products(u * au, u * av, v * av, u * b, v * b));
    }
    sums[lane] = sum;
    add_up(lane);
    if lane == 0u {
        partial[group.x] = sums[0];
    }
}

// upper / lower by coordinate; zero where lower is not positive.
fn divide(upper: vec4f, lower: vec4f) -> vec4f {
    let positive = lower > vec4f();
    return select(vec4f(), upper / select(vec4f(1.0), lower, positive), positive);
}

// The change counts where it has at least this part of its energy outside the latest one's direction …
const LEAST_INDEPENDENCE = 1e-4;
// … and no more than this many times: of a figure that stands nearly still it is rounding.
const GREATEST_CHANGE = vec4f(2.0);

// x = the guess.
@compute @workgroup_size(64)
fn guess(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = partial[lane];
    add_up(lane);
    let sum = sums[0];
    let share = divide(sum.uav, sum.uau);
    let independent = sum.vav - sum.uav * share;
    let counts = independent > sum.vav * LEAST_INDEPENDENCE;
    let new_change = divide(sum.vb - sum.ub * share, select(vec4f(), independent, counts));
    let of_change = clamp(new_change, -GREATEST_CHANGE, GREATEST_CHANGE);
    let of_latest = divide(sum.ub - sum.uav * of_change, sum.uau) + of_change;
    let k = id.x;
    if k < arrayLength(&x) {
        x[k] = latest[k] * of_latest - before[k] * of_change;
    }
}

// Zero where a number is none: a solution that failed in a coordinate failed there at every vertex, and is no guess for the next.
fn finite(value: vec4f) -> vec4f {
    let is_finite = (bitcast<vec4u>(value) & vec4u(0x7f800000u)) != vec4u(0x7f800000u);
    return select(vec4f(), value, is_finite);
}

@compute @workgroup_size(64)
fn remember(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&x) {
        return;
    }
    before[k] = latest[k];
    before_product[k] = latest_product[k];
    latest[k] = finite(x[k]);
    latest_product[k] = finite(side[k] - residual[k]);
}
