//! ×4 triangle subdivision by edge midpoints or Loop stencils, with one stable vertex numbering for both.
//!
//! Level 0 is the given mesh. Level l + 1 keeps the vertices of level l under their indices and appends one vertex for each edge, in
//! ascending order of the edge's (smaller, larger) vertex pair.

use super::Triangle;
use glam::Vec3A;
use std::ops::{Add, Mul};

/// Where new vertices go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Edge midpoints; old vertices stay (the paper's).
    Midpoint,
    /// Loop's stencils (Loop 1987, boundary rules included); old vertices move.
    Loop,
}

/// The topology of a mesh and of its subdivisions.
#[derive(Clone, Debug)]
pub struct Subdivision {
    levels: Vec<()>,
}

impl Subdivision {
    /// Subdivides `level_count` times (0 is allowed).
    pub fn new(vertex_count: usize, triangles: &[Triangle], level_count: usize) -> Self {
        let _ = (vertex_count, triangles, level_count);
        todo!()
    }

    /// How often the mesh is subdivided.
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Vertices of `level` (0 ..= level_count).
    pub fn vertex_count(&self, level: usize) -> usize {
        let _ = level;
        todo!()
    }

    /// Triangles of `level`.
    pub fn triangles(&self, level: usize) -> &[Triangle] {
        let _ = level;
        todo!()
    }

    /// The two vertices of `level` whose edge made vertex `vertex_count(level) + e` of `level + 1`, for each e.
    pub fn edges(&self, level: usize) -> &[[u32; 2]] {
        let _ = level;
        todo!()
    }

    /// Values on the vertices of `level` carried to `level + 1`; `fine` has `vertex_count(level + 1)` entries.
    pub fn refine<T>(&self, scheme: Scheme, level: usize, coarse: &[T], fine: &mut [T])
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        let _ = (scheme, level, coarse, fine);
        todo!()
    }

    /// Transpose of the Loop refinement: `coarse = Pᵀ fine`, the restriction of the multigrid solver.
    pub fn restrict_loop(&self, level: usize, fine: &[Vec3A], coarse: &mut [Vec3A]) {
        let _ = (level, fine, coarse);
        todo!()
    }
}
