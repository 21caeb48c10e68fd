//! Weighted sums of rows: barycentric points, neighbour means, subdivided vertices.

use burn::tensor::{Device, Int, Tensor, TensorData};

/// Sparse weights in padded rows: row r of the result is Σ_i weight[r, i] · value[index[r, i]].
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    /// Entries a row; missing ones have weight 0.
    width: usize,
    indices: Vec<i32>,
    weights: Vec<f32>,
}

impl Rows {
    /// From (index, weight) pairs, row by row.
    pub(super) fn new(rows: &[Vec<(u32, f32)>]) -> Self {
        let width = rows.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut padded = Self { width, indices: Vec::new(), weights: Vec::new() };
        for row in rows {
            for i in 0..width {
                let (index, weight) = row.get(i).copied().unwrap_or((0, 0.0));
                padded.indices.push(index as i32);
                padded.weights.push(weight);
            }
        }
        padded
    }

    /// Rows of one entry of weight 1: the identity over `count` values.
    pub(super) fn identity(count: usize) -> Self {
        Self { width: 1, indices: (0..count as i32).collect(), weights: vec![1.0; count] }
    }

    /// Three corners a row.
    pub(super) fn push_triangle(&mut self, corners: [u32; 3], barycentric: [f32; 3]) {
        self.width = 3;
        self.indices.extend(corners.map(|corner| corner as i32));
        self.weights.extend(barycentric);
    }

    pub(super) fn count(&self) -> usize {
        self.indices.len() / self.width.max(1)
    }

    /// Appends `other`, its indices moved by `offset`. Both have one width.
    pub(super) fn append(&mut self, other: &Self, offset: usize) {
        debug_assert!(self.indices.is_empty() || self.width == other.width, "rows of one width");
        self.width = other.width;
        self.indices.extend(other.indices.iter().map(|&index| index + offset as i32));
        self.weights.extend_from_slice(&other.weights);
    }

    /// The sums of `values` (N, 3): (rows, 3).
    pub(super) fn apply(&self, values: Tensor<2>, device: &Device) -> Tensor<2> {
        let count = self.count();
        let indices = Tensor::<1, Int>::from_data(TensorData::new(self.indices.clone(), [self.indices.len()]), device);
        let weights = Tensor::<2>::from_data(TensorData::new(self.weights.clone(), [self.weights.len(), 1]), device);
        let gathered = values.select(0, indices) * weights;
        gathered.reshape([count, self.width, 3]).sum_dim(1).reshape([count, 3])
    }

    /// [`Self::apply`] on the CPU.
    pub(super) fn apply_slice(&self, values: &[glam::Vec3A]) -> Vec<glam::Vec3A> {
        let rows = self.indices.chunks_exact(self.width).zip(self.weights.chunks_exact(self.width));
        rows.map(|(indices, weights)| indices.iter().zip(weights).map(|(&i, &w)| values[i as usize] * w).sum())
            .collect()
    }
}
