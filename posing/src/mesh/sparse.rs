//! Sparse matrices in compressed rows.

use crate::order::sort_few;
#[cfg(any(test, feature = "fixture"))]
use glam::Vec3A;

/// A number in a sparse matrix's row, as shaders read it, too.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Entry {
    /// Where in the row.
    pub column: u32,
    /// The number.
    pub value: f32,
}

/// A sparse matrix; columns ascend within a row.
#[derive(Clone, Debug, Default)]
pub struct SparseMatrix {
    /// `offsets[i]..offsets[i + 1]` is row i of `entries`.
    pub offsets: Vec<u32>,
    /// The entries, row by row.
    pub entries: Vec<Entry>,
    /// Number of columns.
    pub column_count: usize,
}

impl SparseMatrix {
    /// No rows yet, and room for so many.
    pub fn with_capacity(row_count: usize, entry_count: usize, column_count: usize) -> Self {
        let mut offsets = Vec::with_capacity(row_count + 1);
        offsets.push(0);
        Self { offsets, entries: Vec::with_capacity(entry_count), column_count }
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Appends a row; the entries are sorted here and must name each column once.
    pub fn push_row(&mut self, entries: &mut [(u32, f32)]) {
        // Rows come in order, or nearly.
        for end in 1..entries.len() {
            let mut at = end;
            while at > 0 && entries[at - 1].0 > entries[at].0 {
                entries.swap(at - 1, at);
                at -= 1;
            }
        }
        self.entries.extend(entries.iter().map(|&(column, value)| Entry { column, value }));
        self.offsets.push(self.entries.len() as u32);
    }

    /// (column, value) of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f32)> + Clone + '_ {
        let range = self.offsets[i] as usize..self.offsets[i + 1] as usize;
        self.entries[range].iter().map(|entry| (entry.column, entry.value))
    }

    /// out = M x.
    #[cfg(any(test, feature = "fixture"))]
    pub fn apply(&self, x: &[Vec3A], out: &mut [Vec3A]) {
        assert_eq!((x.len(), out.len()), (self.column_count, self.row_count()));
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.row(i).map(|(column, value)| x[column as usize] * value).sum();
        }
    }

    /// Mᵀ.
    pub fn transposed(&self) -> Self {
        let mut offsets = vec![0u32; self.column_count + 1];
        for entry in &self.entries {
            offsets[entry.column as usize + 1] += 1;
        }
        for i in 0..self.column_count {
            offsets[i + 1] += offsets[i];
        }
        let mut next = offsets.clone();
        let mut entries = vec![Entry::default(); self.entries.len()];
        for i in 0..self.row_count() {
            for (column, value) in self.row(i) {
                let at = &mut next[column as usize];
                entries[*at as usize] = Entry { column: i as u32, value };
                *at += 1;
            }
        }
        Self { offsets, entries, column_count: self.row_count() }
    }

    /// M R. Entries that cancel stay, so that the pattern depends on the patterns alone.
    pub fn times(&self, right: &Self) -> Self {
        assert_eq!(self.column_count, right.row_count());
        let mut product = Self::with_capacity(self.row_count(), 8 * self.row_count(), right.column_count);
        let mut sums = vec![0.0f32; right.column_count];
        let mut seen_in_row = vec![u32::MAX; right.column_count];
        let mut row_columns = Vec::new();
        for i in 0..self.row_count() {
            row_columns.clear();
            for (middle, left_value) in self.row(i) {
                for (column, value) in right.row(middle as usize) {
                    if seen_in_row[column as usize] != i as u32 {
                        seen_in_row[column as usize] = i as u32;
                        sums[column as usize] = 0.0;
                        row_columns.push(column);
                    }
                    sums[column as usize] += left_value * value;
                }
            }
            sort_few(&mut row_columns);
            let entry = |&column: &u32| Entry { column, value: sums[column as usize] };
            product.entries.extend(row_columns.iter().map(entry));
            product.offsets.push(product.entries.len() as u32);
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> SparseMatrix {
        // [1 0 2]
        // [0 3 0]
        let mut matrix = SparseMatrix::with_capacity(2, 3, 3);
        matrix.push_row(&mut [(2, 2.0), (0, 1.0)]);
        matrix.push_row(&mut [(1, 3.0)]);
        matrix
    }

    #[test]
    fn apply_and_transpose() {
        let (matrix, mut out) = (example(), [Vec3A::ZERO; 2]);
        matrix.apply(&[1.0, 10.0, 100.0].map(Vec3A::splat), &mut out);
        assert_eq!(out, [201.0, 30.0].map(Vec3A::splat));
        let mut out = [Vec3A::ZERO; 3];
        matrix.transposed().apply(&[1.0, 10.0].map(Vec3A::splat), &mut out);
        assert_eq!(out, [1.0, 30.0, 2.0].map(Vec3A::splat));
    }

    #[test]
    fn product_keeps_sorted_columns() {
        let gram = example().transposed().times(&example());
        assert_eq!(gram.offsets, [0, 2, 3, 5]);
        let expected = [(0, 1.0), (2, 2.0), (1, 9.0), (0, 2.0), (2, 4.0)];
        assert_eq!(gram.entries, expected.map(|(column, value)| Entry { column, value }));
    }
}
