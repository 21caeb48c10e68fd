//! The Galerkin operator of level 0: the reconstruction's matrix carried down the levels.

#[cfg(feature = "factor")]
use crate::laplacian::reciprocal_valences;
#[cfg(feature = "factor")]
use crate::mesh::SparseMatrix;
use crate::mesh::{Adjacency, Subdivision};

/// Which vertices of level 0 the Galerkin operator may couple: those at most three edges apart; two where nothing is subdivided. A vertex'
/// part of a finer level reaches less than one and a half edges under Loop's stencils, and LᵀL two edges of the finest level. Nearer ones come
/// first in a row.
pub(super) fn coupling(subdivision: &Subdivision) -> Adjacency {
    let reach = if subdivision.level_count() == 0 { 2 } else { 3 };
    let vertex_count = subdivision.vertex_count(0);
    let adjacency = Adjacency::new(vertex_count, subdivision.triangles(0));
    let mut rows = Adjacency { offsets: vec![0], neighbours: Vec::with_capacity(40 * vertex_count) };
    let mut seen_from = vec![u32::MAX; vertex_count];
    for k in 0..vertex_count as u32 {
        seen_from[k as usize] = k;
        let start = rows.neighbours.len();
        let mut ring = start..start;
        for step in 0..reach {
            for at in if step == 0 { 0..1 } else { ring.clone() } {
                let from = if step == 0 { k } else { rows.neighbours[at] };
                for &neighbour in adjacency.of(from as usize) {
                    if seen_from[neighbour as usize] != k {
                        seen_from[neighbour as usize] = k;
                        rows.neighbours.push(neighbour);
                    }
                }
            }
            ring = ring.end..rows.neighbours.len();
        }
        rows.offsets.push(rows.neighbours.len() as u32);
    }
    rows
}

/// The matrix of level 0.
///
/// On the finest level A = MᵀM with M the rows of L above √w_a times the rows of the anchors; a coarser level has PᵀAP with P the Loop
/// stencils. A's own pattern is the two-ring, too large to assemble when MP gives the next matrix at once.
#[cfg(feature = "factor")]
pub(super) fn coarsest_operator(subdivision: &Subdivision, anchors: &[u32], anchor_weight: f32) -> SparseMatrix {
    let rows = finest_rows(subdivision, anchors, anchor_weight);
    let Some(below_finest) = subdivision.level_count().checked_sub(1) else {
        return gram(&rows);
    };
    let below = gram(&rows.times(&subdivision.loop_stencils(below_finest).matrix()));
    (0..below_finest).rev().fold(below, |finer, level| {
        let stencils = subdivision.loop_stencils(level).matrix();
        stencils.transposed().times(&finer.times(&stencils))
    })
}

/// MᵀM.
#[cfg(feature = "factor")]
fn gram(rows: &SparseMatrix) -> SparseMatrix {
    rows.transposed().times(rows)
}

#[cfg(feature = "factor")]
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
