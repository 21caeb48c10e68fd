//! ×4 triangle subdivision by edge midpoints or Loop stencils, with one stable vertex numbering for both.
//!
//! Level 0 is the given mesh. Level l + 1 keeps the vertices of level l under their indices and appends one vertex for each edge, in
//! the order of [`EdgeIndex`].

use super::edge_index::EdgeIndex;
use super::loop_stencils::LoopStencils;
use super::sparse::SparseMatrix;
use super::{Triangle, VertexValue};
use crate::threads::for_rows;
use glam::Vec3A;
use std::sync::Arc;

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
    /// The given mesh's size and triangles.
    vertex_count: usize,
    triangles: Vec<Triangle>,
    /// One for each subdivision, coarsest first.
    refinements: Vec<Refinement>,
}

/// The step from one level to the next.
#[derive(Clone, Debug)]
struct Refinement {
    /// Edges of the coarse level.
    edges: Vec<[u32; 2]>,
    /// Triangles of the fine level.
    triangles: Vec<Triangle>,
    stencils: Arc<LoopStencils>,
}

impl Subdivision {
    /// Subdivides `level_count` times (0 is allowed). The indices of `triangles` must be below `vertex_count`.
    pub fn new(vertex_count: usize, triangles: &[Triangle], level_count: usize) -> Self {
        let mut subdivision = Self { vertex_count, triangles: triangles.to_vec(), refinements: Vec::new() };
        for level in 0..level_count {
            let refinement = Refinement::new(subdivision.vertex_count(level), subdivision.triangles(level));
            subdivision.refinements.push(refinement);
        }
        subdivision
    }

    /// How often the mesh is subdivided.
    pub fn level_count(&self) -> usize {
        self.refinements.len()
    }

    /// Vertices of `level` (0 ..= level_count).
    pub fn vertex_count(&self, level: usize) -> usize {
        match level {
            0 => self.vertex_count,
            _ => self.refinements[level - 1].stencils.fine_count(),
        }
    }

    /// Triangles of `level` (0 ..= level_count).
    pub fn triangles(&self, level: usize) -> &[Triangle] {
        match level {
            0 => &self.triangles,
            _ => &self.refinements[level - 1].triangles,
        }
    }

    /// The two vertices of `level` (below level_count) whose edge made vertex `vertex_count(level) + e` of `level + 1`, for each e.
    pub fn edges(&self, level: usize) -> &[[u32; 2]] {
        &self.refinements[level].edges
    }

    /// Values on the vertices of `level` carried to `level + 1`; `fine` has `vertex_count(level + 1)` entries.
    pub fn refine<T: VertexValue>(&self, scheme: Scheme, level: usize, coarse: &[T], fine: &mut [T]) {
        let Refinement { edges, stencils, .. } = &self.refinements[level];
        match scheme {
            Scheme::Loop => stencils.apply(coarse, fine),
            Scheme::Midpoint => {
                let (old, new) = fine.split_at_mut(self.vertex_count(level));
                old.copy_from_slice(coarse);
                for_rows(new, |first, new| {
                    for (new, &[a, b]) in new.iter_mut().zip(&edges[first..]) {
                        *new = (coarse[a as usize] + coarse[b as usize]) * 0.5;
                    }
                });
            }
        }
    }

    /// Points carried up level by level, from the first of `levels`, which stands on the vertices of `first`, to the last.
    pub fn refine_upwards(&self, scheme: Scheme, first: usize, levels: &mut [Vec<Vec3A>]) {
        for at in 1..levels.len() {
            let (coarser, finer) = levels.split_at_mut(at);
            self.refine(scheme, first + at - 1, &coarser[at - 1], &mut finer[0]);
        }
    }

    /// Transpose of [`Self::refine`]: `coarse = Pᵀ fine`.
    pub fn restrict(&self, scheme: Scheme, level: usize, fine: &[Vec3A], coarse: &mut [Vec3A]) {
        let Refinement { edges, stencils, .. } = &self.refinements[level];
        match scheme {
            Scheme::Loop => stencils.apply_transposed(fine, coarse),
            Scheme::Midpoint => {
                let (old, new) = fine.split_at(coarse.len());
                coarse.copy_from_slice(old);
                for (&new, &[a, b]) in new.iter().zip(edges) {
                    coarse[a as usize] += new * 0.5;
                    coarse[b as usize] += new * 0.5;
                }
            }
        }
    }

    /// What [`Self::refine`] applies by Loop's stencils, as a matrix.
    pub fn loop_matrix(&self, level: usize) -> SparseMatrix {
        self.loop_stencils(level).matrix()
    }

    /// Loop's stencils from `level` to `level + 1`.
    pub(crate) fn loop_stencils(&self, level: usize) -> &Arc<LoopStencils> {
        &self.refinements[level].stencils
    }
}

impl Refinement {
    fn new(vertex_count: usize, coarse_triangles: &[Triangle]) -> Self {
        let index = EdgeIndex::new(vertex_count, coarse_triangles);
        let edges = index.edges();
        let stencils = Arc::new(LoopStencils::new(&index, &edges, coarse_triangles));
        Self { edges, triangles: index.split(coarse_triangles), stencils }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{cube, grid, icosahedron, noise_vectors, subdivided, torus};
    use crate::mesh::{Adjacency, Mesh, vertex_normals};
    use glam::vec3a;

    #[test]
    fn counts_follow_euler() {
        let mesh = torus(6, 5);
        let subdivision = Subdivision::new(30, &mesh.triangles, 3);
        for level in 0..=3 {
            assert_eq!(subdivision.vertex_count(level), 30 << (2 * level));
            assert_eq!(subdivision.triangles(level).len(), 60 << (2 * level));
        }
        let sphere = icosahedron();
        let subdivision = Subdivision::new(12, &sphere.triangles, 2);
        assert_eq!([0, 1, 2].map(|level| subdivision.vertex_count(level)), [12, 42, 162]);
        assert_eq!(subdivision.edges(0).len(), 30);
        assert_eq!(Subdivision::new(12, &sphere.triangles, 0).vertex_count(0), 12);
    }

    #[test]
    fn edges_ascend_and_midpoints_lie_on_them() {
        let sheet = grid(3, 2);
        let subdivision = Subdivision::new(12, &sheet.triangles, 1);
        let edges = subdivision.edges(0);
        assert!(edges.is_sorted_by(|a, b| a < b) && edges.iter().all(|[a, b]| a < b));
        let fine = subdivided(&sheet, Scheme::Midpoint);
        assert_eq!(fine.positions[..12], sheet.positions);
        for (&[a, b], &p) in edges.iter().zip(&fine.positions[12..]) {
            assert_eq!(p, (sheet.positions[a as usize] + sheet.positions[b as usize]) * 0.5);
        }
    }

    #[test]
    fn sub_triangles_keep_the_orientation_and_cover_the_triangle() {
        let fine = subdivided(&grid(2, 2), Scheme::Midpoint);
        for &[a, b, c] in &fine.triangles {
            let [p, q, r] = [a, b, c].map(|i| fine.positions[i as usize]);
            assert_eq!((q - p).cross(r - p), vec3a(0.0, 0.0, 0.25));
        }
    }

    #[test]
    fn loop_stencils_of_valences_three_five_and_six() {
        // A tetrahedron's vertices (n = 3) have β = 3/16, an icosahedron's (n = 5) 0.0840932, a torus grid's (n = 6) 1/16.
        let tetrahedron = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let ring = torus(5, 5).triangles;
        for (vertex_count, triangles, own, beta) in [
            (4, &tetrahedron[..], 7.0 / 16.0, 3.0 / 16.0),
            (12, &icosahedron().triangles, 0.579534, 0.084093),
            (25, &ring, 5.0 / 8.0, 1.0 / 16.0),
        ] {
            let subdivision = Subdivision::new(vertex_count, triangles, 1);
            let (mut impulse, mut fine) = (vec![0.0f32; vertex_count], vec![0.0; subdivision.vertex_count(1)]);
            impulse[0] = 1.0;
            subdivision.refine(Scheme::Loop, 0, &impulse, &mut fine);
            assert!((fine[0] - own).abs() < 1e-5, "{} against {own}", fine[0]);
            let adjacency = Adjacency::new(vertex_count, triangles);
            assert!(adjacency.of(0).iter().all(|&j| (fine[j as usize] - beta).abs() < 1e-5));
            for (edge, value) in subdivision.edges(0).iter().zip(&fine[vertex_count..]) {
                let across = triangles
                    .iter()
                    .filter(|t| t.contains(&0) && edge.iter().all(|e| t.contains(e)) && !edge.contains(&0))
                    .count();
                let expected = if edge.contains(&0) { 0.375 } else { 0.125 * across as f32 };
                assert_eq!(*value, expected);
            }
        }
    }

    #[test]
    fn loop_boundary_is_a_cubic_spline_of_its_own() {
        let mut sheet = grid(4, 1);
        let fine = subdivided(&sheet, Scheme::Loop);
        assert_eq!(fine.positions[2], sheet.positions[2]);
        // The corners have two boundary edges as well and are rounded: (3/4) (0,0) + (1/8) (1,0) + (1/8) (0,1).
        assert_eq!(fine.positions[0], vec3a(0.125, 0.125, 0.0));
        // Lifting an inner row does not move the boundary's edge vertices.
        sheet = grid(4, 2);
        let flat = subdivided(&sheet, Scheme::Loop);
        sheet.positions[7].z = 1.0;
        let lifted = subdivided(&sheet, Scheme::Loop);
        let moved = |edge: [u32; 2]| {
            let at = 15 + Subdivision::new(15, &sheet.triangles, 1).edges(0).iter().position(|e| *e == edge).unwrap();
            lifted.positions[at] != flat.positions[at]
        };
        assert!(!moved([1, 2]) && moved([2, 7]) && moved([1, 7]));
    }

    #[test]
    fn loop_keeps_constants_and_straight_lines_on_a_regular_mesh() {
        let sheet = grid(6, 6);
        let fine = subdivided(&sheet, Scheme::Loop);
        // Vertex 24 is inner; Loop reproduces linear functions there.
        assert!((fine.positions[24] - sheet.positions[24]).length() < 1e-6);
        let subdivision = Subdivision::new(49, &sheet.triangles, 1);
        let mut ones = vec![0.0; subdivision.vertex_count(1)];
        subdivision.refine(Scheme::Loop, 0, &[1.0f32; 49], &mut ones);
        assert!(ones.iter().all(|x| (x - 1.0).abs() < 1e-6));
    }

    #[test]
    fn loop_limit_is_smooth_where_midpoints_keep_the_crease() {
        let widest_angle = |scheme| {
            let mut mesh: Mesh = cube();
            for _ in 0..4 {
                mesh = subdivided(&mesh, scheme);
            }
            let mut normals = vec![Vec3A::ZERO; mesh.positions.len()];
            vertex_normals(&mesh.positions, &mesh.triangles, &mut normals);
            let edges = Adjacency::new(mesh.positions.len(), &mesh.triangles).edges();
            let cosine = |[a, b]: &[u32; 2]| normals[*a as usize].dot(normals[*b as usize]);
            edges.iter().map(cosine).fold(1.0, f32::min).acos().to_degrees()
        };
        let (smooth, creased) = (widest_angle(Scheme::Loop), widest_angle(Scheme::Midpoint));
        assert!(smooth < 15.0 && creased > 40.0, "{smooth} and {creased} degrees");
    }

    #[test]
    fn restriction_is_the_transpose_of_the_refinement() {
        for (mesh, scheme) in [(cube(), Scheme::Loop), (grid(3, 2), Scheme::Loop), (grid(3, 2), Scheme::Midpoint)] {
            let subdivision = Subdivision::new(mesh.positions.len(), &mesh.triangles, 2);
            let x = noise_vectors(subdivision.vertex_count(1), 5);
            let y = noise_vectors(subdivision.vertex_count(2), 900);
            let (mut refined, mut restricted) = (y.clone(), x.clone());
            subdivision.refine(scheme, 1, &x, &mut refined);
            subdivision.restrict(scheme, 1, &y, &mut restricted);
            let left: f32 = refined.iter().zip(&y).map(|(a, b)| a.dot(*b)).sum();
            let right: f32 = x.iter().zip(&restricted).map(|(a, b)| a.dot(*b)).sum();
            assert!((left - right).abs() < 1e-4, "{left} against {right}");
        }
    }
}
