// One vertex of the figure: xyz are the bits of the position in metres, w an octahedral normal. Host twin: `SurfaceVertex`.
fn unpack_position(vertex: vec4u) -> vec3f {
    return bitcast<vec3f>(vertex.xyz);
}

fn unpack_normal(vertex: vec4u) -> vec3f {
    let xy = unpack2x16snorm(vertex.w);
    let z = 1.0 - abs(xy.x) - abs(xy.y);
    let fold = max(-z, 0.0);
    return normalize(vec3f(xy + select(vec2f(fold), vec2f(-fold), xy >= vec2f(0.0)), z));
}
