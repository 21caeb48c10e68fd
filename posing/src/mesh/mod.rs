//! Triangle meshes: topology, normals, vertex areas, subdivision.

mod area;
mod edge_index;
mod incidence;
pub(crate) mod loop_stencils;
mod normals;
pub(crate) mod rings;
mod sparse;
mod subdivision;
#[cfg(any(test, feature = "fixture"))]
pub mod test_meshes;
mod topology;

pub use area::{VertexAreas, mixed_voronoi_areas};
pub use edge_index::EdgeIndex;
pub use incidence::Incidence;
pub use normals::vertex_normals;
pub use sparse::{Entry, SparseMatrix};
pub use subdivision::{Scheme, Subdivision};
pub use topology::Adjacency;

use crate::threads::for_rows;
use glam::Vec3A;
use std::ops::{Add, Mul, Sub};

/// What a vertex may carry from level to level: anything that can be averaged.
pub trait VertexValue: Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> {}

impl<T: Copy + Send + Sync + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>> VertexValue for T {}

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

/// sum = a + b, as far as all three reach.
pub fn put_sum(a: &[Vec3A], b: &[Vec3A], sum: &mut [Vec3A]) {
    let count = sum.len().min(a.len()).min(b.len());
    for_rows(&mut sum[..count], |first, sum| {
        for ((sum, a), b) in sum.iter_mut().zip(&a[first..]).zip(&b[first..]) {
            *sum = *a + *b;
        }
    });
}
