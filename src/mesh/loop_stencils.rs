//! Loop's subdivision stencils (Loop 1987), as a matrix from the vertices of one level to those of the next.

use super::sparse::SparseMatrix;
use super::{Adjacency, Triangle};
use std::f32::consts::TAU;

/// The stencils of one refinement: rows are the old vertices, then one for each of `edges`.
///
/// Inner: an old vertex of valence n keeps 1 − n β and takes β = (5/8 − (3/8 + cos(2π/n)/4)²)/n of each neighbour; an edge vertex takes
/// 3/8 of its ends and 1/8 of the two corners across. Boundary (an edge of one triangle, or of more than two): the cubic spline's
/// 1/8, 3/4, 1/8 and 1/2, 1/2. A vertex where the boundary does not simply pass through, and one of no triangle, stays.
pub(super) fn loop_stencils(
    adjacency: &Adjacency,
    edges: &[[u32; 2]],
    triangles: &[Triangle],
    edge_of: impl Fn(u32, u32) -> u32,
) -> SparseMatrix {
    let vertex_count = adjacency.vertex_count();
    let across = corners_across(edges.len(), triangles, edge_of);
    let mut boundary_neighbours = vec![Vec::new(); vertex_count];
    for (&[a, b], across) in edges.iter().zip(&across) {
        if across.count != 2 {
            boundary_neighbours[a as usize].push(b);
            boundary_neighbours[b as usize].push(a);
        }
    }

    let mut stencils =
        SparseMatrix::with_capacity(vertex_count + edges.len(), 7 * vertex_count + 4 * edges.len(), vertex_count);
    let mut row = Vec::new();
    for (k, boundary) in boundary_neighbours.iter().enumerate() {
        row.clear();
        let neighbours = adjacency.of(k);
        match boundary[..] {
            [] if !neighbours.is_empty() => {
                let beta = beta(neighbours.len());
                row.push((k as u32, 1.0 - neighbours.len() as f32 * beta));
                row.extend(neighbours.iter().map(|&j| (j, beta)));
            }
            [before, after] => row.extend([(before, 0.125), (k as u32, 0.75), (after, 0.125)]),
            _ => row.push((k as u32, 1.0)),
        }
        stencils.push_row(&mut row);
    }
    for (&[a, b], across) in edges.iter().zip(&across) {
        match (across.count, across.corners) {
            (2, [c, d]) if c != d => stencils.push_row(&mut [(a, 0.375), (b, 0.375), (c, 0.125), (d, 0.125)]),
            (2, [c, _]) => stencils.push_row(&mut [(a, 0.375), (b, 0.375), (c, 0.25)]),
            _ => stencils.push_row(&mut [(a, 0.5), (b, 0.5)]),
        }
    }
    stencils
}

/// Loop's weight of one neighbour of an inner vertex.
fn beta(valence: usize) -> f32 {
    let n = valence as f32;
    let root = 0.375 + 0.25 * (TAU / n).cos();
    (0.625 - root * root) / n
}

/// The corners opposite to an edge; the first two are kept.
#[derive(Clone, Copy, Default)]
struct Across {
    count: u32,
    corners: [u32; 2],
}

fn corners_across(edge_count: usize, triangles: &[Triangle], edge_of: impl Fn(u32, u32) -> u32) -> Vec<Across> {
    let mut across = vec![Across::default(); edge_count];
    for &[a, b, c] in triangles {
        for (from, to, corner) in [(a, b, c), (b, c, a), (c, a, b)] {
            if from != to {
                let across = &mut across[edge_of(from, to) as usize];
                if let Some(slot) = across.corners.get_mut(across.count as usize) {
                    *slot = corner;
                }
                across.count += 1;
            }
        }
    }
    across
}
