//! A = LᵀL + w_a S on the finest level, without a matrix.
//!
//! With K = D − A_dj the graph Laplacian, L = D⁻¹K and LᵀL = K D⁻² K: two passes over the neighbours. (K x)_k is the sum of x_k − x_j
//! over the neighbours j, so a row of fewer than six is filled up with the vertex itself at no change, and the loops over six unroll.

use crate::mesh::Adjacency;
use glam::Vec3A;

/// Neighbours in a row: what almost every vertex of a subdivided mesh has.
const WIDTH: usize = 6;

/// Topology, anchors and the space of one product.
#[derive(Clone, Debug)]
pub(super) struct NormalOperator {
    /// The first six neighbours of each vertex.
    rings: Vec<[u32; WIDTH]>,
    /// (vertex, neighbour) beyond the first six.
    surplus: Vec<[u32; 2]>,
    /// 1/N of each vertex.
    reciprocal_valences: Vec<f32>,
    /// (vertex, w_a)
    anchors: Vec<(u32, f32)>,
    /// D⁻² K x.
    middle: Vec<Vec3A>,
}

impl NormalOperator {
    pub fn new(adjacency: &Adjacency, anchors: &[u32], anchor_weight: f32) -> Self {
        let vertex_count = adjacency.vertex_count();
        let (mut rings, mut surplus) = (Vec::with_capacity(vertex_count), Vec::new());
        for k in 0..vertex_count {
            let (first, rest) = adjacency.of(k).split_at(adjacency.valence(k).min(WIDTH));
            rings.push(std::array::from_fn(|at| first.get(at).copied().unwrap_or(k as u32)));
            surplus.extend(rest.iter().map(|&neighbour| [k as u32, neighbour]));
        }
        Self {
            rings,
            surplus,
            reciprocal_valences: crate::laplacian::reciprocal_valences(adjacency),
            anchors: anchors.iter().map(|&anchor| (anchor, anchor_weight)).collect(),
            middle: vec![Vec3A::ZERO; vertex_count],
        }
    }

    /// out −= A x.
    pub fn subtract_product(&mut self, x: &[Vec3A], out: &mut [Vec3A]) {
        let Self { rings, surplus, reciprocal_valences, anchors, middle } = self;
        let rows = middle.iter_mut().zip(&*rings).zip(x).zip(&*reciprocal_valences);
        for (((middle, ring), &own), reciprocal) in rows {
            *middle = ring_sum(ring, own, x) * (reciprocal * reciprocal);
        }
        for &[k, j] in &*surplus {
            let (k, j) = (k as usize, j as usize);
            middle[k] += (x[k] - x[j]) * (reciprocal_valences[k] * reciprocal_valences[k]);
        }
        for ((out, ring), &own) in out.iter_mut().zip(&*rings).zip(&*middle) {
            *out -= ring_sum(ring, own, middle);
        }
        for &[k, j] in &*surplus {
            out[k as usize] -= middle[k as usize] - middle[j as usize];
        }
        for &(anchor, weight) in &*anchors {
            out[anchor as usize] -= x[anchor as usize] * weight;
        }
    }

    /// out = Lᵀ r.
    pub fn right_side(&mut self, r: &[Vec3A], out: &mut [Vec3A]) {
        let Self { rings, surplus, reciprocal_valences, middle, .. } = self;
        for ((middle, &r), reciprocal) in middle.iter_mut().zip(r).zip(&*reciprocal_valences) {
            *middle = r * *reciprocal;
        }
        for ((out, ring), &own) in out.iter_mut().zip(&*rings).zip(&*middle) {
            *out = ring_sum(ring, own, middle);
        }
        for &[k, j] in &*surplus {
            out[k as usize] += middle[k as usize] - middle[j as usize];
        }
    }

    /// The diagonal of A.
    pub fn diagonal(&self) -> Vec<f32> {
        let square = |j: u32| self.reciprocal_valences[j as usize].powi(2);
        let mut diagonal: Vec<f32> = (0..)
            .zip(&self.rings)
            .map(|(k, ring)| 1.0 + ring.iter().filter(|&&j| j != k).map(|&j| square(j)).sum::<f32>())
            .collect();
        for &[k, j] in &self.surplus {
            diagonal[k as usize] += square(j);
        }
        for &(anchor, weight) in &self.anchors {
            diagonal[anchor as usize] += weight;
        }
        diagonal
    }
}

/// Σ_j (own − x_j).
#[inline(always)]
fn ring_sum(ring: &[u32; WIDTH], own: Vec3A, x: &[Vec3A]) -> Vec3A {
    let at = |i: usize| x[ring[i] as usize];
    own * WIDTH as f32 - ((at(0) + at(1)) + (at(2) + at(3)) + (at(4) + at(5)))
}
