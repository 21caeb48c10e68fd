// The figure's vertices of this frame, by body vertex, row by row: WebGL2 has no storage buffers.
@group(1) @binding(0) var figure_vertices: texture_2d<u32>;

fn figure_vertex(body_vertex: u32) -> vec4u {
    let width = textureDimensions(figure_vertices).x;
    return textureLoad(figure_vertices, vec2u(body_vertex % width, body_vertex / width), 0);
}
