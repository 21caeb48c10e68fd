//! The pattern of an LDLᵀ factor, and solving with it.

use super::{CoarseFactor, FactorError};
use crate::mesh::sparse::SparseMatrix;
use glam::Vec3A;

/// The entries below the diagonal of L in P A Pᵀ = L D Lᵀ, by columns; rows ascend within a column.
#[derive(Clone, Debug)]
pub(crate) struct FactorPattern {
    /// `offsets[j]..offsets[j + 1]` is column j of `rows`.
    pub offsets: Vec<u32>,
    pub rows: Vec<u32>,
}

impl FactorPattern {
    /// The pattern that elimination in the order `permutation` leaves, `matrix` symmetric; `step_of` is the permutation's inverse.
    ///
    /// Column j holds what the matrix has there and what the columns hold whose first entry is in row j (their children in the
    /// elimination tree; Liu 1990).
    pub fn new(matrix: &SparseMatrix, permutation: &[u32], step_of: &[u32]) -> Self {
        let count = permutation.len();
        let mut offsets = Vec::with_capacity(count + 1);
        offsets.push(0u32);
        let mut rows: Vec<u32> = Vec::new();
        let mut seen_in_column = vec![u32::MAX; count];
        let mut first_child = vec![u32::MAX; count];
        let mut next_sibling = vec![u32::MAX; count];
        for j in 0..count {
            let start = rows.len();
            seen_in_column[j] = j as u32;
            let mut add = |row: u32, rows: &mut Vec<u32>| {
                if row as usize > j && seen_in_column[row as usize] != j as u32 {
                    seen_in_column[row as usize] = j as u32;
                    rows.push(row);
                }
            };
            for (column, _) in matrix.row(permutation[j] as usize) {
                add(step_of[column as usize], &mut rows);
            }
            let mut child = first_child[j];
            while child != u32::MAX {
                for at in offsets[child as usize]..offsets[child as usize + 1] {
                    let row = rows[at as usize];
                    add(row, &mut rows);
                }
                child = next_sibling[child as usize];
            }
            rows[start..].sort_unstable();
            if let Some(&parent) = rows.get(start) {
                next_sibling[j] = first_child[parent as usize];
                first_child[parent as usize] = j as u32;
            }
            offsets.push(rows.len() as u32);
        }
        Self { offsets, rows }
    }

    pub fn column(&self, j: usize) -> std::ops::Range<usize> {
        self.offsets[j] as usize..self.offsets[j + 1] as usize
    }
}

/// The inverse of `permutation`; none where it is no permutation.
pub(super) fn inverse_permutation(permutation: &[u32]) -> Option<Vec<u32>> {
    let mut inverse = vec![u32::MAX; permutation.len()];
    for (step, &vertex) in permutation.iter().enumerate() {
        let slot = inverse.get_mut(vertex as usize)?;
        if *slot != u32::MAX {
            return None;
        }
        *slot = step as u32;
    }
    Some(inverse)
}

/// A factor ready to solve with.
#[derive(Clone, Debug)]
pub(super) struct DirectSolver {
    pub permutation: Vec<u32>,
    pub pattern: FactorPattern,
    /// Of L, in the pattern's order.
    pub values: Vec<f32>,
    pub reciprocal_diagonal: Vec<f32>,
    /// The right side and then the solution, in elimination order.
    permuted: Vec<Vec3A>,
}

impl DirectSolver {
    /// Checks `factor` against the pattern that `matrix` and its permutation have.
    pub fn new(matrix: &SparseMatrix, factor: &CoarseFactor) -> Result<Self, FactorError> {
        let count = matrix.row_count();
        check_length("permutation", count, factor.permutation.len())?;
        check_length("diagonal", count, factor.diagonal.len())?;
        let step_of =
            inverse_permutation(&factor.permutation).ok_or(FactorError::NotAPermutation { expected: count })?;
        let pattern = FactorPattern::new(matrix, &factor.permutation, &step_of);
        check_length("values", pattern.rows.len(), factor.values.len())?;
        let values: Vec<f32> = factor.values.iter().map(|value| value.to_f32()).collect();
        check_each("diagonal", "positive and finite", &factor.diagonal, |d| d > 0.0 && d.is_finite())?;
        check_each("values", "finite", &values, f32::is_finite)?;
        Ok(Self {
            permutation: factor.permutation.clone(),
            pattern,
            values,
            reciprocal_diagonal: factor.diagonal.iter().map(|d| d.recip()).collect(),
            permuted: vec![Vec3A::ZERO; count],
        })
    }

    /// x = Pᵀ L⁻ᵀ D⁻¹ L⁻¹ P b.
    pub fn solve(&mut self, b: &[Vec3A], x: &mut [Vec3A]) {
        let Self { permutation, pattern, values, reciprocal_diagonal, permuted } = self;
        for (y, &vertex) in permuted.iter_mut().zip(&*permutation) {
            *y = b[vertex as usize];
        }
        for j in 0..permuted.len() {
            let own = permuted[j];
            for (&row, &value) in pattern.rows[pattern.column(j)].iter().zip(&values[pattern.column(j)]) {
                permuted[row as usize] -= own * value;
            }
        }
        for j in (0..permuted.len()).rev() {
            let mut sum = permuted[j] * reciprocal_diagonal[j];
            for (&row, &value) in pattern.rows[pattern.column(j)].iter().zip(&values[pattern.column(j)]) {
                sum -= permuted[row as usize] * value;
            }
            permuted[j] = sum;
        }
        for (y, &vertex) in permuted.iter().zip(&*permutation) {
            x[vertex as usize] = *y;
        }
    }
}

fn check_length(field: &'static str, expected: usize, found: usize) -> Result<(), FactorError> {
    if expected == found { Ok(()) } else { Err(FactorError::Length { field, expected, found }) }
}

fn check_each(
    field: &'static str,
    expected: &'static str,
    values: &[f32],
    is_fine: impl Fn(f32) -> bool,
) -> Result<(), FactorError> {
    match values.iter().position(|&value| !is_fine(value)) {
        Some(index) => Err(FactorError::Value { field, index, expected, found: values[index] }),
        None => Ok(()),
    }
}
