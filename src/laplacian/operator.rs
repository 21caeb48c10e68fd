//! L = I − D⁻¹A and the row scale s that turns δ (1/m) into metres: (L u)_k = s_k δ_k.

use crate::mesh::Adjacency;
use glam::Vec3A;

/// out = L u, u_k minus the mean of its neighbours.
pub fn apply_topological(adjacency: &Adjacency, u: &[Vec3A], out: &mut [Vec3A]) {
    let _ = (adjacency, u, out);
    todo!()
}

/// s_k = a_k tan α_k / N_k with α_k = π/2 − π/N_k, from the mixed Voronoi areas `areas` (m²). Unit m².
pub fn row_scales(adjacency: &Adjacency, areas: &[f32], scales: &mut [f32]) {
    let _ = (adjacency, areas, scales);
    todo!()
}
