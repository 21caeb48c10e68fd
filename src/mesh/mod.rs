//! Triangle meshes: topology, normals, vertex areas, subdivision.

mod area;
mod loop_stencils;
mod normals;
pub(crate) mod sparse;
mod subdivision;
#[cfg(test)]
pub(crate) mod test_meshes;
mod topology;

pub use area::mixed_voronoi_areas;
pub use normals::vertex_normals;
pub use subdivision::{Scheme, Subdivision};
pub use topology::Adjacency;

use glam::Vec3A;

/// A triangle: three vertex indices, counter-clockwise seen from outside.
pub type Triangle = [u32; 3];

/// Positions and triangles.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3A>,
    /// Triangles over `positions`.
    pub triangles: Vec<Triangle>,
}
