//! WGSL of the passes as WebGL2 can have them: the figure's vertices are in a texture. The task runner reads this very file and
//! translates it to GLSL.

macro_rules! joined {
    ($($file:literal)*) => { concat!($(include_str!($file)),*) };
}

/// Sky and floor.
pub const BACKDROP: &str = joined!("globals.wgsl" "backdrop.wgsl");
/// The lit figure.
pub const FIGURE: &str = joined!("globals.wgsl" "figure_vertices_texture.wgsl" "surface_vertex.wgsl" "figure.wgsl");
/// The figure's depth as a light sees it.
pub const DEPTH_MAP: &str = joined!("figure_vertices_texture.wgsl" "surface_vertex.wgsl" "depth_map.wgsl");
