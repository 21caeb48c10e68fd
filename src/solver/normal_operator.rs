//! A = LᵀL + w_a S on the finest level, without a matrix.
//!
//! With K = D − A_dj the graph Laplacian, L = D⁻¹K and LᵀL = K D⁻² K: two passes over the neighbours.

use crate::mesh::Adjacency;
use glam::Vec3A;

/// Topology, anchors and the space of one product.
#[derive(Clone, Debug)]
pub(super) struct NormalOperator {
    adjacency: Adjacency,
    /// N of each vertex.
    valences: Vec<f32>,
    /// w_a at anchors, zero elsewhere.
    anchor_weights: Vec<f32>,
    /// D⁻² K x.
    middle: Vec<Vec3A>,
}

impl NormalOperator {
    pub fn new(adjacency: Adjacency, anchors: &[u32], anchor_weight: f32) -> Self {
        let vertex_count = adjacency.vertex_count();
        let valences = (0..vertex_count)
            .map(|k| adjacency.valence(k) as f32)
            .collect();
        let mut anchor_weights = vec![0.0; vertex_count];
        for &anchor in anchors {
            anchor_weights[anchor as usize] = anchor_weight;
        }
        Self {
            adjacency,
            valences,
            anchor_weights,
            middle: vec![Vec3A::ZERO; vertex_count],
        }
    }

    /// out −= A x.
    pub fn subtract_product(&mut self, x: &[Vec3A], out: &mut [Vec3A]) {
        for (k, middle) in self.middle.iter_mut().enumerate() {
            let reciprocal = 1.0 / self.valences[k].max(1.0);
            *middle = graph_laplacian(&self.adjacency, k, x) * (reciprocal * reciprocal);
        }
        for (k, out) in out.iter_mut().enumerate() {
            *out -=
                graph_laplacian(&self.adjacency, k, &self.middle) + x[k] * self.anchor_weights[k];
        }
    }

    /// out = Lᵀ r.
    pub fn right_side(&mut self, r: &[Vec3A], out: &mut [Vec3A]) {
        for (k, middle) in self.middle.iter_mut().enumerate() {
            *middle = r[k] / self.valences[k].max(1.0);
        }
        for (k, out) in out.iter_mut().enumerate() {
            *out = graph_laplacian(&self.adjacency, k, &self.middle);
        }
    }

    /// The diagonal of A.
    pub fn diagonal(&self) -> Vec<f32> {
        let column = |k: usize| {
            let others = self
                .adjacency
                .of(k)
                .iter()
                .map(|&j| self.valences[j as usize].powi(-2));
            1.0 + others.sum::<f32>() + self.anchor_weights[k]
        };
        (0..self.valences.len()).map(column).collect()
    }
}

/// (K x)_k = N_k x_k − Σ_j x_j.
fn graph_laplacian(adjacency: &Adjacency, k: usize, x: &[Vec3A]) -> Vec3A {
    let own = x[k];
    adjacency.of(k).iter().map(|&j| own - x[j as usize]).sum()
}
