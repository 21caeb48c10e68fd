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
    /// Row i has an entry in each column on the ways up the elimination tree from the columns where the matrix has one in that row
    /// (Liu 1990). Taken row by row, the rows of a column come in order.
    pub fn new(coupling: &Adjacency, permutation: &[u32], step_of: &[u32]) -> Self {
        let parents = elimination_tree(coupling, permutation, step_of);
        let mut seen_in_row = vec![u32::MAX; permutation.len()];
        let mut for_each_entry = |visit: &mut dyn FnMut(u32, usize)| {
            seen_in_row.fill(u32::MAX);
            for (i, &vertex) in (0u32..).zip(permutation) {
                for &coupled in coupling.of(vertex as usize) {
                    let mut column = step_of[coupled as usize] as usize;
                    while column < i as usize && seen_in_row[column] != i {
                        seen_in_row[column] = i;
                        visit(i, column);
                        column = parents[column] as usize;
                    }
                }
            }
        };
        let mut offsets = vec![0u32; permutation.len() + 1];
        for_each_entry(&mut |_, column| offsets[column + 1] += 1);
        for j in 0..permutation.len() {
            offsets[j + 1] += offsets[j];
        }
        let mut next = offsets.clone();
        let mut rows = vec![0; offsets[permutation.len()] as usize];
        for_each_entry(&mut |row, column| {
            rows[next[column] as usize] = row;
            next[column] += 1;
        });
        Self { offsets, rows }
    }

    pub fn column(&self, j: usize) -> std::ops::Range<usize> {
        self.offsets[j] as usize..self.offsets[j + 1] as usize
    }
}

/// For each column the row of its first entry below the diagonal of L, its parent; `u32::MAX` for the last column of a connected part.
fn elimination_tree(coupling: &Adjacency, permutation: &[u32], step_of: &[u32]) -> Vec<u32> {
    let mut parents = vec![u32::MAX; permutation.len()];
    // As far up as is known; shortened by every walk.
    let mut ancestors = parents.clone();
    for (i, &vertex) in (0u32..).zip(permutation) {
        for &coupled in coupling.of(vertex as usize) {
            let mut column = step_of[coupled as usize];
            while column < i {
                let up = std::mem::replace(&mut ancestors[column as usize], i);
                if up == u32::MAX {
                    parents[column as usize] = i;
                }
                column = up;
            }
        }
    }
    parents
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
