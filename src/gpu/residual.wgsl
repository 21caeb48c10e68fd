// What each row lacks, metres: r = detail (s delta - L u), or detail s delta in the relative form.
// Twins: `mesh::mixed_voronoi_areas`, `laplacian::scale_per_area`, `laplacian::apply_topological`.
@group(0) @binding(1) var<storage, read> base: array<vec4f>;
@group(0) @binding(2) var<storage, read> deltas: array<vec4f>;
@group(0) @binding(3) var<storage, read> corner_offsets: array<u32>;
// The other two vertices of each triangle at a vertex, counter-clockwise.
@group(0) @binding(4) var<storage, read> corners: array<vec2u>;
@group(0) @binding(5) var<storage, read> ring_offsets: array<u32>;
@group(0) @binding(6) var<storage, read> ring: array<u32>;
@group(0) @binding(7) var<storage, read_write> residual: array<vec4f>;

// The part of the triangle p, q, r that belongs to p.
fn corner_share(p: vec3f, q: vec3f, r: vec3f) -> f32 {
    let pq = q - p;
    let qr = r - q;
    let rp = p - r;
    let twice_area = length(cross(pq, qr));
    if twice_area <= 1.1754944e-38 {
        return 0.0;
    }
    let dots = -vec3f(dot(pq, rp), dot(qr, pq), dot(rp, qr));
    if any(dots < vec3f()) {
        return twice_area * select(0.125, 0.25, dots.x < 0.0);
    }
    return (dots.y * dot(rp, rp) + dots.z * dot(pq, pq)) / (8.0 * twice_area);
}

@compute @workgroup_size(64)
fn row_residual(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&residual) {
        return;
    }
    let own = base[k].xyz;
    var area = 0.0;
    for (var i = corner_offsets[k]; i < corner_offsets[k + 1u]; i++) {
        let corner = corners[i];
        area += corner_share(own, base[corner.x].xyz, base[corner.y].xyz);
    }
    let valence = f32(ring_offsets[k + 1u] - ring_offsets[k]);
    var scale = 0.0;
    if valence >= 3.0 {
        scale = area / (tan(3.14159265 / valence) * valence);
    }
    var wanted = scale * deltas[k].xyz;
    if frame.base_share != 0.0 && valence > 0.0 {
        var sum = vec3f();
        for (var i = ring_offsets[k]; i < ring_offsets[k + 1u]; i++) {
            sum += base[ring[i]].xyz;
        }
        wanted -= frame.base_share * (own - sum / valence);
    }
    residual[k] = vec4f(frame.detail * wanted, 0.0);
}
