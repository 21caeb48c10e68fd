// Linear blend skinning of level 0: v' = LBS(v + offset + pose blend shapes).
// Twin: `animate::PosedSurface::pose`, level 0.
struct Vertex {
    rest: vec3f,
    // Four joints, a byte each.
    joints: u32,
    weights: vec4f,
}

@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(2) var<storage, read> offsets: array<vec4f>;
// For the entries of R - I, joints 1 .., row by row: three numbers a vertex. Shorter than one entry where there are none.
@group(0) @binding(3) var<storage, read> pose_directions: array<f32>;
@group(0) @binding(4) var<storage, read_write> positions: array<vec4f>;

@compute @workgroup_size(64)
fn skin(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    let count = arrayLength(&vertices);
    if k >= count {
        return;
    }
    let vertex = vertices[k];
    var place = vertex.rest + frame.offset_share * offsets[k].xyz;
    for (var entry = 0u; entry < arrayLength(&pose_directions) / (3u * count); entry++) {
        let row = entry % 9u / 3u;
        let column = entry % 3u;
        let difference = frame.joints[entry / 9u + 1u].rotation[column][row] - select(0.0, 1.0, row == column);
        let at = 3u * (entry * count + k);
        place += difference * vec3f(pose_directions[at], pose_directions[at + 1u], pose_directions[at + 2u]);
    }
    var posed = vec3f();
    for (var i = 0u; i < 4u; i++) {
        let joint = (vertex.joints >> (8u * i)) & 255u;
        posed += vertex.weights[i] * (vec4f(place, 1.0) * frame.joints[joint].posed_from_rest);
    }
    positions[k] = vec4f(posed, 0.0);
}
