//! The coarse level's LDLᵀ factor: made once for an avatar, stored in its file in half precision.

#[cfg(feature = "factor")]
use super::factor_pattern::FactorPattern;
#[cfg(feature = "factor")]
use super::galerkin;
#[cfg(feature = "factor")]
use crate::mesh::{Adjacency, SparseMatrix, Subdivision};
use half::f16;

/// P A₀ Pᵀ = L D Lᵀ of the Galerkin operator on level 0.
///
/// As a preconditioner it may be coarse: half precision is enough, and L D Lᵀ stays positive definite whatever the rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseFactor {
    /// `permutation[i]` is the vertex that elimination step i removes.
    pub permutation: Vec<u32>,
    /// D, one entry a column.
    pub diagonal: Vec<f32>,
    /// Entries of L below the diagonal, column by column, rows ascending; the pattern follows from topology and permutation alone.
    pub values: Vec<f16>,
}

/// Why a factor cannot serve a topology.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FactorError {
    /// An array of another length.
    #[error("solver factor: {field} has {found} entries, expected {expected}")]
    Length {
        /// The array.
        field: &'static str,
        /// What topology and permutation ask for.
        expected: usize,
        /// What is there.
        found: usize,
    },
    /// `permutation` names a vertex twice, or one that does not exist.
    #[error("solver factor: permutation is expected to name each of {expected} vertices once")]
    NotAPermutation {
        /// Vertices of level 0.
        expected: usize,
    },
    /// D has an entry that is not positive, or L one that is not finite.
    #[error("solver factor: {field}[{index}] is {found}, expected {expected}")]
    Value {
        /// The array.
        field: &'static str,
        /// Where in it.
        index: usize,
        /// What is allowed.
        expected: &'static str,
        /// What is there.
        found: f32,
    },
}

impl CoarseFactor {
    /// Orders and factors. `anchors` are vertices of the finest level.
    #[cfg(feature = "factor")]
    pub fn new(subdivision: &Subdivision, anchors: &[u32], anchor_weight: f32) -> Self {
        let matrix = &galerkin::coarsest_operator(subdivision, anchors, anchor_weight);
        let coupling = galerkin::coupling(subdivision).sorted();
        let (permutation, step_of) = minimum_degree_order(&coupling);
        let pattern = FactorPattern::new(&coupling, &permutation, &step_of);
        let (values, diagonal) = numeric_factor(matrix, &permutation, &step_of, &pattern);
        Self {
            permutation,
            diagonal: diagonal.iter().map(|&d| d as f32).collect(),
            values: values.iter().map(|&value| f16::from_f64(value)).collect(),
        }
    }
}

/// The fill-reducing order (approximate minimum degree) and its inverse.
#[cfg(feature = "factor")]
fn minimum_degree_order(coupling: &Adjacency) -> (Vec<u32>, Vec<u32>) {
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::sparse::SymbolicSparseColMatRef;
    use faer::sparse::linalg::amd;

    let count = coupling.vertex_count();
    let (mut order, mut inverse) = (vec![0u32; count], vec![0u32; count]);
    if count > 0 {
        let symbolic =
            SymbolicSparseColMatRef::new_checked(count, count, &coupling.offsets, None, &coupling.neighbours);
        let mut memory = MemBuffer::new(amd::order_maybe_unsorted_scratch::<u32>(count, coupling.neighbours.len()));
        amd::order_maybe_unsorted(&mut order, &mut inverse, symbolic, Default::default(), MemStack::new(&mut memory))
            .expect("u32 holds the size of every mesh that u32 indices can name");
    }
    (order, inverse)
}

/// L's values and D, column by column from the left, in double precision.
#[cfg(feature = "factor")]
fn numeric_factor(
    matrix: &SparseMatrix,
    permutation: &[u32],
    step_of: &[u32],
    pattern: &FactorPattern,
) -> (Vec<f64>, Vec<f64>) {
    let count = permutation.len();
    let mut values = vec![0.0f64; pattern.rows.len()];
    let mut diagonal = vec![0.0f64; count];
    let mut column = vec![0.0f64; count];
    // Columns wait in a list at the row of their next entry; `next_entry` is where that is.
    let mut waiting = vec![Vec::<u32>::new(); count];
    let mut next_entry: Vec<usize> = (0..count).map(|j| pattern.column(j).start).collect();
    for j in 0..count {
        for (neighbour, value) in matrix.row(permutation[j] as usize) {
            let row = step_of[neighbour as usize] as usize;
            if row >= j {
                column[row] = f64::from(value);
            }
        }
        for k in std::mem::take(&mut waiting[j]) {
            let k = k as usize;
            let start = next_entry[k];
            let scale = values[start] * diagonal[k];
            for at in start..pattern.column(k).end {
                column[pattern.rows[at] as usize] -= values[at] * scale;
            }
            next_entry[k] = start + 1;
            if start + 1 < pattern.column(k).end {
                waiting[pattern.rows[start + 1] as usize].push(k as u32);
            }
        }
        // Positive in exact arithmetic when each connected part has an anchor; the floor serves parts that have none.
        diagonal[j] = column[j].max(1e-7);
        for at in pattern.column(j) {
            values[at] = std::mem::take(&mut column[pattern.rows[at] as usize]) / diagonal[j];
        }
        if let Some(&row) = pattern.rows[pattern.column(j)].first() {
            waiting[row as usize].push(j as u32);
        }
    }
    (values, diagonal)
}
