//! A = c LᵀL + BᵀB on one level, without a matrix.
//!
//! With K = N − A_dj the graph Laplacian and N the valences, L = N⁻¹K and LᵀL = K N⁻² K: two passes over the neighbours. B has a row for
//! each anchor.

use crate::laplacian::reciprocal_valence;
use crate::mesh::SparseMatrix;
use crate::mesh::rings::Rings;
use crate::threads::for_rows;
use glam::Vec3A;
use std::sync::Arc;

/// Topology, anchors and the space of one product.
#[derive(Clone, Debug)]
pub struct NormalOperator {
    rings: Arc<Rings>,
    /// 1/N of each vertex.
    pub reciprocal_valences: Vec<f32>,
    /// c
    pub scale: f32,
    /// B
    pub anchors: SparseMatrix,
    /// What the second pass reads; made by the first product.
    middle: Vec<Vec3A>,
}

impl NormalOperator {
    pub(crate) fn new(rings: Arc<Rings>, scale: f32, anchors: SparseMatrix) -> Self {
        let reciprocal_valences: Vec<f32> = rings.valences().into_iter().map(reciprocal_valence).collect();
        Self { middle: Vec::new(), rings, reciprocal_valences, scale, anchors }
    }

    /// Frees what products work in; the next one makes it again.
    pub(super) fn give_room_back(&mut self) {
        self.middle = Vec::new();
    }

    pub fn vertex_count(&self) -> usize {
        self.reciprocal_valences.len()
    }

    /// Who is whose neighbour.
    pub(super) fn rings(&self) -> &Rings {
        &self.rings
    }

    /// Number of neighbours of each vertex.
    pub fn valences(&self) -> Vec<usize> {
        self.rings.valences()
    }

    /// out = L x.
    pub fn laplacian(&self, x: &[Vec3A], out: &mut [Vec3A]) {
        for_rows(out, |first, out| {
            let reciprocals = &self.reciprocal_valences[first..];
            for ((out, sum), &reciprocal) in out.iter_mut().zip(self.rings.differences(first, x)).zip(reciprocals) {
                *out = sum * reciprocal;
            }
        });
        for (k, j) in self.rings.surplus() {
            out[k] += (x[k] - x[j]) * self.reciprocal_valences[k];
        }
    }

    /// out = b − A x.
    pub fn residual(&mut self, x: &[Vec3A], b: &[Vec3A], out: &mut [Vec3A]) {
        self.halfway(x);
        for_rows(out, |first, out| {
            for ((out, &b), sum) in out.iter_mut().zip(&b[first..]).zip(self.rings.differences(first, &self.middle)) {
                *out = b - sum;
            }
        });
        for (k, j) in self.rings.surplus() {
            out[k] -= self.middle[k] - self.middle[j];
        }
        self.add_anchors(x, -1.0, out);
    }

    /// out = A x.
    pub fn product(&mut self, x: &[Vec3A], out: &mut [Vec3A]) {
        self.halfway(x);
        self.graph_product(out);
        self.add_anchors(x, 1.0, out);
    }

    /// out = a (α N + β K) a r, a diagonal.
    pub fn smoothed(&mut self, a: &[f32], weights: [f32; 2], r: &[Vec3A], out: &mut [Vec3A]) {
        self.put_smoothed(a, weights, r, out, |_, value| value);
    }

    /// out += a (α N + β K) a r, a diagonal.
    pub fn add_smoothed(&mut self, a: &[f32], weights: [f32; 2], r: &[Vec3A], out: &mut [Vec3A]) {
        self.put_smoothed(a, weights, r, out, |before, value| before + value);
    }

    #[inline(always)]
    fn put_smoothed(
        &mut self,
        a: &[f32],
        [alpha, beta]: [f32; 2],
        r: &[Vec3A],
        out: &mut [Vec3A],
        combine: impl Fn(Vec3A, Vec3A) -> Vec3A + Sync,
    ) {
        let Self { rings, reciprocal_valences, middle, .. } = self;
        middle.resize(reciprocal_valences.len(), Vec3A::ZERO);
        for_rows(middle, |first, middle| {
            for ((middle, &r), &a) in middle.iter_mut().zip(&r[first..]).zip(&a[first..]) {
                *middle = r * a;
            }
        });
        for_rows(out, |first, out| {
            let diagonals = a[first..].iter().zip(&reciprocal_valences[first..]);
            let rows = out.iter_mut().zip(rings.differences(first, middle)).zip(&middle[first..]).zip(diagonals);
            for (((out, sum), &own), (&a, &reciprocal)) in rows {
                *out = combine(*out, own * (a * alpha / reciprocal) + sum * (a * beta));
            }
        });
        for (k, j) in rings.surplus() {
            out[k] += (middle[k] - middle[j]) * (a[k] * beta);
        }
    }

    /// out = c Lᵀ r.
    pub fn right_side(&mut self, r: &[Vec3A], out: &mut [Vec3A]) {
        self.middle.resize(self.reciprocal_valences.len(), Vec3A::ZERO);
        let Self { reciprocal_valences, scale, middle, .. } = self;
        for_rows(middle, |first, middle| {
            for ((middle, &r), &reciprocal) in middle.iter_mut().zip(&r[first..]).zip(&reciprocal_valences[first..]) {
                *middle = r * (*scale * reciprocal);
            }
        });
        self.graph_product(out);
    }

    /// The diagonal of c LᵀL, and the sums of the rows of BᵀB, a diagonal that bounds it from above.
    pub fn diagonal_and_anchor_bound(&self) -> (Vec<f32>, Vec<f32>) {
        let square = |j: usize| self.scale * self.reciprocal_valences[j].powi(2);
        let of_row = |k: usize| {
            let neighbours = self.rings.row(k).iter().filter(|&&j| j as usize != k);
            self.scale + neighbours.map(|&j| square(j as usize)).sum::<f32>()
        };
        let mut diagonal: Vec<f32> = (0..self.vertex_count()).map(of_row).collect();
        for (k, j) in self.rings.surplus() {
            diagonal[k] += square(j);
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
        let Self { rings, reciprocal_valences, scale, middle, .. } = self;
        middle.resize(reciprocal_valences.len(), Vec3A::ZERO);
        let weight = |reciprocal: f32| *scale * reciprocal * reciprocal;
        for_rows(middle, |first, middle| {
            let reciprocals = &reciprocal_valences[first..];
            for ((middle, sum), &reciprocal) in middle.iter_mut().zip(rings.differences(first, x)).zip(reciprocals) {
                *middle = sum * weight(reciprocal);
            }
        });
        for (k, j) in rings.surplus() {
            middle[k] += (x[k] - x[j]) * weight(reciprocal_valences[k]);
        }
    }

    /// out = K middle.
    fn graph_product(&self, out: &mut [Vec3A]) {
        let middle = &self.middle;
        for_rows(out, |first, out| {
            for (out, sum) in out.iter_mut().zip(self.rings.differences(first, middle)) {
                *out = sum;
            }
        });
        for (k, j) in self.rings.surplus() {
            out[k] += middle[k] - middle[j];
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
