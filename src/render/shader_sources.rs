//! WGSL of all passes.

use crate::wgsl::wgsl;

macro_rules! joined {
    ($($file:literal)*) => { wgsl!($(include_str!($file)),*) };
}

/// Sky and floor.
pub const BACKDROP: &str = joined!("globals.wgsl" "backdrop.wgsl");
/// The lit figure.
pub const FIGURE: &str = joined!("globals.wgsl" "figure_vertices_buffer.wgsl" "surface_vertex.wgsl" "figure.wgsl");
/// The figure's depth as a light sees it.
pub const DEPTH_MAP: &str = joined!("figure_vertices_buffer.wgsl" "surface_vertex.wgsl" "depth_map.wgsl");
/// Halving a texture.
pub const MIPMAP: &str = joined!("mipmap.wgsl");
