// The figure's depth as a light sees it.
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;

@vertex
fn vertex(@location(0) body_vertex: u32) -> @builtin(position) vec4f {
    return clip_from_world * vec4f(unpack_position(figure_vertex(body_vertex)), 1.0);
}
