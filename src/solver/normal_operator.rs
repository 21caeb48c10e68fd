//! A = c LᵀL + BᵀB on one level, without a matrix.
//!
//! With K = N − A_dj the graph Laplacian and N the valences, L = N⁻¹K and LᵀL = K N⁻² K: two passes over the neighbours. (K x)_k is the
//! sum of x_k − x_j over the neighbours j, so a row of fewer than six is filled up with the vertex itself at no change, and the loops
//! over six unroll. B has a row for each anchor.

use crate::mesh::Adjacency;
use crate::mesh::sparse::SparseMatrix;
use glam::Vec3A;

/// Neighbours in a row: what almost every vertex of a subdivided mesh has.
const WIDTH: usize = 6;

/// Topology, anchors and the space of one product.
#[derive(Clone, Debug)]
pub(crate) struct NormalOperator {
    /// The first six neighbours of each vertex.
    rings: Vec<[u32; WIDTH]>,
    /// (vertex, neighbour) beyond the first six.
    surplus: Vec<[u32; 2]>,
    /// 1/N of each vertex.
    pub reciprocal_valences: Vec<f32>,
    /// c
    pub scale: f32,
    /// B
    pub anchors: SparseMatrix,
    /// c N⁻² K x.
    middle: Vec<Vec3A>,
}

impl NormalOperator {
    pub fn new(adjacency: &Adjacency, scale: f32, anchors: SparseMatrix) -> Self {
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
            scale,
            anchors,
            middle: vec![Vec3A::ZERO; vertex_count],
        }
    }

    /// out = b − A x.
    pub fn residual(&mut self, x: &[Vec3A], b: &[Vec3A], out: &mut [Vec3A]) {
        self.halfway(x);
        let middle = &self.middle;
        for (((out, &b), ring), &own) in out.iter_mut().zip(b).zip(&self.rings).zip(middle) {
            *out = b - ring_sum(ring, own, middle);
        }
        for &[k, j] in &self.surplus {
            out[k as usize] -= middle[k as usize] - middle[j as usize];
        }
        self.add_anchors(x, -1.0, out);
    }

    /// out = A x.
    pub fn product(&mut self, x: &[Vec3A], out: &mut [Vec3A]) {
        self.halfway(x);
        self.graph_product(out);
        self.add_anchors(x, 1.0, out);
    }

    /// out += a (α N + β K) a r, a diagonal.
    pub fn add_smoothed(&mut self, a: &[f32], [alpha, beta]: [f32; 2], r: &[Vec3A], out: &mut [Vec3A]) {
        let Self { rings, surplus, reciprocal_valences, middle, .. } = self;
        for ((middle, &r), &a) in middle.iter_mut().zip(r).zip(a) {
            *middle = r * a;
        }
        let rows = out.iter_mut().zip(&*rings).zip(&*middle).zip(a).zip(&*reciprocal_valences);
        for ((((out, ring), &own), &a), &reciprocal) in rows {
            *out += own * (a * alpha / reciprocal) + ring_sum(ring, own, middle) * (a * beta);
        }
        for &[k, j] in &*surplus {
            let (k, j) = (k as usize, j as usize);
            out[k] += (middle[k] - middle[j]) * (a[k] * beta);
        }
    }

    /// out = Lᵀ r.
    pub fn right_side(&mut self, r: &[Vec3A], out: &mut [Vec3A]) {
        for ((middle, &r), reciprocal) in self.middle.iter_mut().zip(r).zip(&self.reciprocal_valences) {
            *middle = r * *reciprocal;
        }
        self.graph_product(out);
    }

    /// The diagonal of c LᵀL, and the sums of the rows of BᵀB, a diagonal that bounds it from above.
    pub fn diagonal_and_anchor_bound(&self) -> (Vec<f32>, Vec<f32>) {
        let square = |j: u32| self.scale * self.reciprocal_valences[j as usize].powi(2);
        let of_ring = |(k, ring): (u32, &[u32; WIDTH])| {
            self.scale + ring.iter().filter(|&&j| j != k).map(|&j| square(j)).sum::<f32>()
        };
        let mut diagonal: Vec<f32> = (0..).zip(&self.rings).map(of_ring).collect();
        for &[k, j] in &self.surplus {
            diagonal[k as usize] += square(j);
        }
        let mut of_anchors = vec![0.0; diagonal.len()];
        for i in 0..self.anchors.row_count() {
            let sum: f32 = self.anchors.row(i).map(|(_, value)| value).sum();
            self.anchors.row(i).for_each(|(k, value)| of_anchors[k as usize] += value * sum);
        }
        (diagonal, of_anchors)
    }

    /// middle = c N⁻² K x.
    fn halfway(&mut self, x: &[Vec3A]) {
        let Self { rings, surplus, reciprocal_valences, scale, middle, .. } = self;
        let weight = |reciprocal: f32| *scale * reciprocal * reciprocal;
        let rows = middle.iter_mut().zip(&*rings).zip(x).zip(&*reciprocal_valences);
        for (((middle, ring), &own), &reciprocal) in rows {
            *middle = ring_sum(ring, own, x) * weight(reciprocal);
        }
        for &[k, j] in &*surplus {
            let (k, j) = (k as usize, j as usize);
            middle[k] += (x[k] - x[j]) * weight(reciprocal_valences[k]);
        }
    }

    /// out = K middle.
    fn graph_product(&self, out: &mut [Vec3A]) {
        let middle = &self.middle;
        for ((out, ring), &own) in out.iter_mut().zip(&self.rings).zip(middle) {
            *out = ring_sum(ring, own, middle);
        }
        for &[k, j] in &self.surplus {
            out[k as usize] += middle[k as usize] - middle[j as usize];
        }
    }

    /// out += `factor` BᵀB x.
    fn add_anchors(&self, x: &[Vec3A], factor: f32, out: &mut [Vec3A]) {
        for i in 0..self.anchors.row_count() {
            let row = self.anchors.row(i);
            let value: Vec3A = row.clone().map(|(k, weight)| x[k as usize] * weight).sum();
            row.for_each(|(k, weight)| out[k as usize] += value * (factor * weight));
        }
    }
}

/// Σ_j (own − x_j).
#[inline(always)]
fn ring_sum(ring: &[u32; WIDTH], own: Vec3A, x: &[Vec3A]) -> Vec3A {
    let at = |i: usize| x[ring[i] as usize];
    own * WIDTH as f32 - ((at(0) + at(1)) + (at(2) + at(3)) + (at(4) + at(5)))
}
