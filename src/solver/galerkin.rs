//! The least-squares matrix of the reconstruction, on the finest level and carried to the coarser ones.

use crate::laplacian::reciprocal_valences;
use crate::mesh::sparse::SparseMatrix;
use crate::mesh::{Adjacency, Subdivision};

/// For each level, coarsest first, M with A = MᵀM: on the finest level the rows of L above √w_a times the rows of the anchors, on the
/// coarser ones that times the Loop stencils, so that A is the Galerkin operator there.
pub(super) fn least_squares_rows(
    subdivision: &Subdivision,
    anchors: &[u32],
    anchor_weight: f32,
) -> Vec<SparseMatrix> {
    let finest = subdivision.level_count();
    let mut rows = finest_rows(subdivision, anchors, anchor_weight);
    let mut levels = Vec::with_capacity(finest + 1);
    for level in (0..finest).rev() {
        let coarser = rows.times(subdivision.loop_stencils(level)[0]);
        levels.push(std::mem::replace(&mut rows, coarser));
    }
    levels.push(rows);
    levels.reverse();
    levels
}

/// MᵀM.
pub(super) fn gram(rows: &SparseMatrix) -> SparseMatrix {
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
