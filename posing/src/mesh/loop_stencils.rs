//! Loop's subdivision stencils (Loop 1987), from the vertices of one level to those of the next.

use super::edge_index::EdgeIndex;
use super::rings::Rings;
use super::sparse::SparseMatrix;
use super::{Triangle, VertexValue};
use crate::order::places_by;
use crate::threads::for_rows;
use glam::Vec3A;
use std::f32::consts::TAU;
use std::sync::Arc;

/// The stencils of one refinement. Fine vertices are the old ones, then one for each edge.
///
/// Inner: an old vertex of valence n keeps 1 − n β and takes β = (5/8 − (3/8 + cos(2π/n)/4)²)/n of each neighbour; an edge vertex takes
/// 3/8 of its ends and 1/8 of the two corners across. Boundary (an edge of one triangle, or of more than two): the cubic spline's
/// 1/8, 3/4, 1/8 and 1/2, 1/2. A vertex where the boundary does not simply pass through, and one of no triangle, stays.
#[derive(Clone, Debug)]
pub(crate) struct LoopStencils {
    /// Neighbours on the coarse level.
    rings: Arc<Rings>,
    /// β of each old vertex; 0 where the inner rule does not hold.
    beta: Vec<f32>,
    /// Old vertices on a boundary, and their neighbours there.
    creases: Vec<[u32; 3]>,
    /// The ends of each edge and the corners across; the ends once more on a boundary, which makes 1/2, 1/2.
    edges: Vec<[u32; 4]>,
}

const OF_END: f32 = 0.375;
const OF_CORNER: f32 = 0.125;
const OF_CREASE: f32 = 0.125;

impl LoopStencils {
    /// `edges` are those of `index`, which is of `triangles`.
    pub fn new(index: &EdgeIndex, edges: &[[u32; 2]], triangles: &[Triangle]) -> Self {
        let adjacency = index.adjacency();
        let across = corners_across(index, edges.len(), triangles);
        // At most two are needed, and more than two count as none.
        let mut boundary: Vec<(u32, [u32; 2])> = vec![(0, [0; 2]); adjacency.vertex_count()];
        let boundary_edges = edges.iter().zip(&across).filter(|(_, across)| across.count != 2);
        for (&[a, b], _) in boundary_edges {
            for (from, to) in [(a, b), (b, a)] {
                let (count, neighbours) = &mut boundary[from as usize];
                if let Some(slot) = neighbours.get_mut(*count as usize) {
                    *slot = to;
                }
                *count += 1;
            }
        }
        let beta = |(k, (boundary_count, _)): (usize, &(u32, [u32; 2]))| match adjacency.valence(k) {
            valence @ 1.. if *boundary_count == 0 => beta(valence),
            _ => 0.0,
        };
        let crease = |(k, &(count, [before, after])): (usize, &(u32, [u32; 2]))| {
            (count == 2).then_some([k as u32, before, after])
        };
        let edge = |(&[a, b], across): (&[u32; 2], &Across)| {
            let [c, d] = if across.count == 2 { across.corners } else { [a, b] };
            [a, b, c, d]
        };
        Self {
            rings: Arc::new(Rings::new(adjacency)),
            beta: boundary.iter().enumerate().map(beta).collect(),
            creases: boundary.iter().enumerate().filter_map(crease).collect(),
            edges: edges.iter().zip(&across).map(edge).collect(),
        }
    }

    /// Neighbours on the coarse level.
    pub fn rings(&self) -> &Arc<Rings> {
        &self.rings
    }

    pub fn coarse_count(&self) -> usize {
        self.beta.len()
    }

    pub fn fine_count(&self) -> usize {
        self.beta.len() + self.edges.len()
    }

    /// fine = P coarse.
    pub fn apply<T: VertexValue>(&self, coarse: &[T], fine: &mut [T]) {
        self.put(coarse, fine, |_, value| value);
    }

    /// fine += P coarse.
    pub fn add_product(&self, coarse: &[Vec3A], fine: &mut [Vec3A]) {
        self.put(coarse, fine, |before, value| before + value);
    }

    /// Writes `combine(what was there, P coarse)` to `fine`.
    #[inline(always)]
    fn put<T: VertexValue>(&self, coarse: &[T], fine: &mut [T], combine: impl Fn(T, T) -> T + Sync) {
        assert_eq!((coarse.len(), fine.len()), (self.coarse_count(), self.fine_count()));
        let (old, new) = fine.split_at_mut(coarse.len());
        for_rows(old, |first, old| {
            let betas = &self.beta[first..];
            let rows = old.iter_mut().zip(self.rings.differences(first, coarse)).zip(&coarse[first..]).zip(betas);
            for (((old, difference), &own), &beta) in rows {
                *old = combine(*old, own - difference * beta);
            }
        });
        for (k, j) in self.rings.surplus() {
            old[k] = old[k] - (coarse[k] - coarse[j]) * self.beta[k];
        }
        for &[k, before, after] in &self.creases {
            let [own, before, after] = [k, before, after].map(|v| coarse[v as usize]);
            old[k as usize] = old[k as usize] + (before + after - own * 2.0) * OF_CREASE;
        }
        for_rows(new, |first, new| {
            for (new, edge) in new.iter_mut().zip(&self.edges[first..]) {
                let [a, b, c, d] = edge.map(|v| coarse[v as usize]);
                *new = combine(*new, (a + b) * OF_END + (c + d) * OF_CORNER);
            }
        });
    }

    /// coarse = Pᵀ fine.
    pub fn apply_transposed(&self, fine: &[Vec3A], coarse: &mut [Vec3A]) {
        assert_eq!((coarse.len(), fine.len()), (self.coarse_count(), self.fine_count()));
        let (old, new) = fine.split_at(coarse.len());
        let weighted = |k: usize| old[k] * self.beta[k];
        for_rows(coarse, |first, coarse| {
            for (k, coarse) in (first..).zip(coarse) {
                *coarse = old[k] + self.rings.row(k).iter().map(|&j| weighted(j as usize)).sum::<Vec3A>()
                    - weighted(k) * self.rings.row(k).len() as f32;
            }
        });
        for (k, j) in self.rings.surplus() {
            coarse[k] += weighted(j) - weighted(k);
        }
        for &[k, before, after] in &self.creases {
            let share = old[k as usize] * OF_CREASE;
            coarse[k as usize] -= share * 2.0;
            coarse[before as usize] += share;
            coarse[after as usize] += share;
        }
        for (&value, &[a, b, c, d]) in new.iter().zip(&self.edges) {
            let (of_end, of_corner) = (value * OF_END, value * OF_CORNER);
            coarse[a as usize] += of_end;
            coarse[b as usize] += of_end;
            coarse[c as usize] += of_corner;
            coarse[d as usize] += of_corner;
        }
    }

    /// Row `fine` of P: coarse vertices and their weights; a vertex may come more than once.
    fn row(&self, fine: usize) -> Vec<(u32, f32)> {
        let k = fine as u32;
        if let Some(edge) = fine.checked_sub(self.coarse_count()) {
            let [a, b, c, d] = self.edges[edge];
            return vec![(a, OF_END), (b, OF_END), (c, OF_CORNER), (d, OF_CORNER)];
        }
        if let Ok(at) = self.creases.binary_search_by_key(&k, |crease| crease[0]) {
            let [_, before, after] = self.creases[at];
            return vec![(k, 1.0 - 2.0 * OF_CREASE), (before, OF_CREASE), (after, OF_CREASE)];
        }
        let mut row = vec![(k, 1.0)];
        if self.beta[fine] > 0.0 {
            row.extend(self.rings.of(fine).map(|j| (j, self.beta[fine])));
            row[0].1 -= (row.len() - 1) as f32 * self.beta[fine];
        }
        row
    }

    /// P as a matrix, fine × coarse.
    pub fn matrix(&self) -> SparseMatrix {
        let entry_count = 7 * self.coarse_count() + 4 * self.edges.len();
        let mut matrix = SparseMatrix::with_capacity(self.fine_count(), entry_count, self.coarse_count());
        for fine in 0..self.fine_count() {
            matrix.push_row(&mut merged(&self.row(fine)));
        }
        matrix
    }

    /// B P for a matrix B of few rows over the fine vertices.
    pub fn times_from_left(&self, few: &SparseMatrix) -> SparseMatrix {
        let mut product = SparseMatrix::with_capacity(few.row_count(), 8 * few.row_count(), self.coarse_count());
        for i in 0..few.row_count() {
            let scaled = |(fine, value): (u32, f32)| {
                self.row(fine as usize).into_iter().map(move |(coarse, weight)| (coarse, weight * value))
            };
            product.push_row(&mut merged(&few.row(i).flat_map(scaled).collect::<Vec<_>>()));
        }
        product
    }
}

/// The entries with each column once, ascending.
fn merged(entries: &[(u32, f32)]) -> Vec<(u32, f32)> {
    let mut merged: Vec<(u32, f32)> = Vec::with_capacity(entries.len());
    for place in places_by(entries.iter().map(|&(column, _)| column)) {
        let (column, value) = entries[place];
        match merged.last_mut() {
            Some(last) if last.0 == column => last.1 += value,
            _ => merged.push((column, value)),
        }
    }
    merged
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

fn corners_across(index: &EdgeIndex, edge_count: usize, triangles: &[Triangle]) -> Vec<Across> {
    let mut across = vec![Across::default(); edge_count];
    for &[a, b, c] in triangles {
        for (from, to, corner) in [(a, b, c), (b, c, a), (c, a, b)] {
            if from != to {
                let across = &mut across[index.of(from, to) as usize];
                if let Some(slot) = across.corners.get_mut(across.count as usize) {
                    *slot = corner;
                }
                across.count += 1;
            }
        }
    }
    across
}

#[cfg(test)]
mod tests {
    use crate::mesh::Subdivision;
    use crate::mesh::test_meshes::{cube, grid, noise_vectors, torus};
    use glam::Vec3A;

    fn largest(a: &[Vec3A], b: &[Vec3A]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }

    #[test]
    fn stencils_and_their_matrix_say_the_same() {
        let fan: Vec<[u32; 3]> = (1..=9).map(|k| [0, k, k % 9 + 1]).collect();
        let cases = [(8, cube().triangles), (20, grid(4, 3).triangles), (48, torus(8, 6).triangles), (11, fan)];
        for (count, triangles) in cases {
            let subdivision = Subdivision::new(count, &triangles, 1);
            let stencils = subdivision.loop_stencils(0);
            let matrix = stencils.matrix();
            let (x, y) = (noise_vectors(count, 1), noise_vectors(stencils.fine_count(), 90));
            let (mut by_stencils, mut by_matrix) = (y.clone(), y.clone());
            stencils.apply(&x, &mut by_stencils);
            matrix.apply(&x, &mut by_matrix);
            assert!(largest(&by_stencils, &by_matrix) < 1e-5);

            let mut added = y.clone();
            stencils.add_product(&x, &mut added);
            let sum: Vec<Vec3A> = y.iter().zip(&by_matrix).map(|(a, b)| *a + *b).collect();
            assert!(largest(&added, &sum) < 1e-5);

            let (mut by_stencils, mut by_matrix) = (x.clone(), x.clone());
            stencils.apply_transposed(&y, &mut by_stencils);
            matrix.transposed().apply(&y, &mut by_matrix);
            assert!(largest(&by_stencils, &by_matrix) < 1e-5);
            assert!(largest(&by_matrix, &x) > 0.1, "there is something to compare");

            let few = matrix.transposed().times(&matrix);
            let product = stencils.times_from_left(&matrix.transposed());
            assert_eq!((&product.offsets, product.entries.len()), (&few.offsets, few.entries.len()));
            let mut pairs = product.entries.iter().zip(&few.entries);
            assert!(pairs.all(|(a, b)| a.column == b.column && (a.value - b.value).abs() < 1e-5));
        }
    }
}
