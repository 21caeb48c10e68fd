// Positions and normals as they are drawn. Twins: `mesh::vertex_normals`, `render::SurfaceVertex`.
@group(0) @binding(1) var<storage, read> base: array<vec4f>;
@group(0) @binding(2) var<storage, read> displacement: array<vec4f>;
@group(0) @binding(3) var<storage, read> corner_offsets: array<u32>;
// The other two vertices of each triangle at a vertex, counter-clockwise.
@group(0) @binding(4) var<storage, read> corners: array<vec2u>;
// xyz are the bits of the position, w an octahedral normal.
@group(0) @binding(5) var<storage, read_write> vertices: array<vec4u>;
// Vertices whose place is no number.
@group(0) @binding(6) var<storage, read_write> nowhere: atomic<u32>;

fn position(k: u32) -> vec3f {
    // What a failed solve has left must not spoil the base.
    return select(base[k].xyz, base[k].xyz + displacement[k].xyz, frame.displacement_share != 0.0);
}

// By its bits: WGSL lets compilers take for granted that numbers are finite.
fn is_finite(v: vec3f) -> bool {
    return all((bitcast<vec3u>(v) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}

fn pack_normal(direction: vec3f) -> u32 {
    let size = dot(abs(direction), vec3f(1.0));
    if !(size > 0.0) {
        return pack2x16snorm(vec2f(0.0, 1.0));
    }
    let projected = direction / size;
    let folded = (1.0 - abs(projected.yx)) * select(vec2f(-1.0), vec2f(1.0), projected.xy >= vec2f());
    return pack2x16snorm(select(projected.xy, folded, projected.z < 0.0));
}

@compute @workgroup_size(64)
fn surface(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&vertices) {
        return;
    }
    let own = position(k);
    var normal = vec3f();
    for (var i = corner_offsets[k]; i < corner_offsets[k + 1u]; i++) {
        let corner = corners[i];
        normal += cross(position(corner.x) - own, position(corner.y) - own);
    }
    // A vertex that is nowhere, or next to one, keeps its last place.
    if !is_finite(own) {
        atomicAdd(&nowhere, 1u);
    } else if is_finite(normal) {
        vertices[k] = vec4u(bitcast<vec3u>(own), pack_normal(normal));
    }
}
