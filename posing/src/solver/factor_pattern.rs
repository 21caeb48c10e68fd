//! The pattern of an LDLᵀ factor.

use crate::mesh::Adjacency;

/// The entries below the diagonal of L in P A Pᵀ = L D Lᵀ, by columns; rows ascend within a column.
#[derive(Clone, Debug)]
pub struct FactorPattern {
    /// `offsets[j]..offsets[j + 1]` is column j of `rows`.
    pub offsets: Vec<u32>,
    pub rows: Vec<u32>,
}

impl FactorPattern {
    /// The pattern that elimination in the order `permutation` leaves of a symmetric matrix that couples each vertex with those of its row
    /// in `coupling`; `step_of` is the permutation's inverse.
    ///
    /// Column j holds what the matrix has there and what the columns hold whose first entry is in row j (their children in the
    /// elimination tree; Liu 1990).
    pub fn new(coupling: &Adjacency, permutation: &[u32], step_of: &[u32]) -> Self {
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
            for &vertex in coupling.of(permutation[j] as usize) {
                add(step_of[vertex as usize], &mut rows);
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
