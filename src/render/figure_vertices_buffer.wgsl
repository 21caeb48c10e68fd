// The figure's vertices of this frame, by body vertex.
@group(1) @binding(0) var<storage, read> figure_vertices: array<vec4u>;

fn figure_vertex(body_vertex: u32) -> vec4u {
    return figure_vertices[body_vertex];
}
