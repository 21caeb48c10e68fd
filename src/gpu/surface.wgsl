// Positions and normals as they are drawn. Twins: `mesh::vertex_normals`, `render::SurfaceVertex`.
@group(0) @binding(1) var<storage, read> base: array<vec4f>;
@group(0) @binding(2) var<storage, read> displacement: array<vec4f>;
@group(0) @binding(3) var<storage, read> corner_offsets: array<u32>;
// The other two vertices of each triangle at a vertex, counter-clockwise.
@group(0) @binding(4) var<storage, read> corners: array<vec2u>;
// xyz are the bits of the position, w an octahedral normal.
@group(0) @binding(5) var<storage, read_write> vertices: array<vec4u>;

fn position(k: u32) -> vec3f {
    return base[k].xyz + frame.displacement_share * displacement[k].xyz;
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
    vertices[k] = vec4u(bitcast<vec3u>(own), pack_normal(normal));
}
