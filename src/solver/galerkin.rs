//! The Galerkin operator of level 0: the reconstruction's matrix carried down the levels.

use crate::laplacian::reciprocal_valences;
use crate::mesh::sparse::SparseMatrix;
use crate::mesh::{Adjacency, Subdivision};

/// The matrix of level 0.
///
/// On the finest level A = MᵀM with M the rows of L above √w_a times the rows of the anchors; a coarser level has PᵀAP with P the Loop
/// stencils. A's own pattern is the two-ring, too large to assemble when MP gives the next matrix at once.
pub(super) fn coarsest_operator(subdivision: &Subdivision, anchors: &[u32], anchor_weight: f32) -> SparseMatrix {
    let rows = finest_rows(subdivision, anchors, anchor_weight);
    let Some(below_finest) = subdivision.level_count().checked_sub(1) else {
        return gram(&rows);
    };
    let below = gram(&rows.times(subdivision.loop_stencils(below_finest)));
    (0..below_finest).rev().fold(below, |finer, level| {
        let stencils = subdivision.loop_stencils(level);
        subdivision.loop_stencils_transposed(level).times(&finer.times(stencils))
    })
}

/// MᵀM.
fn gram(rows: &SparseMatrix) -> SparseMatrix {
    rows.transposed().times(rows)
}

fn finest_rows(subdivision: &Subdivision, anchors: &[u32], anchor_weight: f32) -> SparseMatrix {
    let finest = subdivision.level_count();
    let vertex_count = subdivision.vertex_count(finest);
    let adjacency = Adjacency::new(vertex_count, subdivision.triangles(finest));
    let reciprocals = reciprocal_valences(&adjacency);
    let mut rows = SparseMatrix::with_capacity(
        vertex_count + anchors.len(),
        adjacency.neighbours.len() + vertex_count + anchors.len(),
        vertex_count,
    );
    let mut row = Vec::new();
    for (k, &reciprocal) in reciprocals.iter().enumerate() {
        row.clear();
        row.push((k as u32, 1.0));
        row.extend(adjacency.of(k).iter().map(|&j| (j, -reciprocal)));
        rows.push_row(&mut row);
    }
    for &anchor in anchors {
        rows.push_row(&mut [(anchor, anchor_weight.sqrt())]);
    }
    rows
}
