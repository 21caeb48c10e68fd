// Turns vectors of the rest pose's frame into the posed frame by the blended matrices, in place.
// Twin: `animate::PosedSurface::rotations`, whose midpoints blend as the mean of the weights of both ends does.
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
// (joint, weight's bits); those of vertex k are offsets[k] .. offsets[k + 1].
@group(0) @binding(2) var<storage, read> influences: array<vec2u>;
@group(0) @binding(3) var<storage, read_write> vectors: array<vec4f>;

@compute @workgroup_size(64)
fn rotate(@builtin(global_invocation_id) id: vec3u) {
    let k = id.x;
    if k >= arrayLength(&vectors) {
        return;
    }
    let vector = vec4f(vectors[k].xyz, 0.0);
    var turned = vec3f();
    for (var i = offsets[k]; i < offsets[k + 1u]; i++) {
        let influence = influences[i];
        turned += bitcast<f32>(influence.y) * (vector * frame.joints[influence.x].posed_from_rest);
    }
    vectors[k] = vec4f(turned, 0.0);
}
