//! Every vertex' neighbours in rows of six, for the loops that run every frame.
//!
//! Almost every vertex of a subdivided mesh has six neighbours. A row of fewer is filled up with the vertex itself, which adds nothing to
//! a sum of differences; neighbours beyond six stand in a list of their own. So the loops unroll and have no branch.

use super::{Adjacency, VertexValue};

/// Neighbours in a row.
const WIDTH: usize = 6;

/// The neighbours of all vertices.
#[derive(Clone, Debug)]
pub(crate) struct Rings {
    /// Below the number of rows, all of them: [`Rings::differences`] relies on it.
    rows: Vec<[u32; WIDTH]>,
    surplus: Vec<[u32; 2]>,
}

impl Rings {
    pub fn new(adjacency: &Adjacency) -> Self {
        let vertex_count = adjacency.vertex_count();
        assert!(adjacency.neighbours.iter().all(|&neighbour| (neighbour as usize) < vertex_count));
        let (mut rows, mut surplus) = (Vec::with_capacity(vertex_count), Vec::new());
        for k in 0..vertex_count {
            let (first, rest) = adjacency.of(k).split_at(adjacency.valence(k).min(WIDTH));
            rows.push(std::array::from_fn(|at| first.get(at).copied().unwrap_or(k as u32)));
            surplus.extend(rest.iter().map(|&neighbour| [k as u32, neighbour]));
        }
        Self { rows, surplus }
    }

    pub fn vertex_count(&self) -> usize {
        self.rows.len()
    }

    /// The first six neighbours of vertex `k`, filled up with `k`.
    pub fn row(&self, k: usize) -> &[u32; WIDTH] {
        &self.rows[k]
    }

    /// (vertex, neighbour) beyond the first six, vertices ascending.
    pub fn surplus(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.surplus.iter().map(|&[k, j]| (k as usize, j as usize))
    }

    /// Number of neighbours of each vertex.
    pub fn valences(&self) -> Vec<usize> {
        let in_row = |(k, row): (usize, &[u32; WIDTH])| row.iter().filter(|&&j| j as usize != k).count();
        let mut valences: Vec<usize> = self.rows.iter().enumerate().map(in_row).collect();
        for (k, _) in self.surplus() {
            valences[k] += 1;
        }
        valences
    }

    /// The neighbours of vertex `k`.
    pub fn of(&self, k: usize) -> impl Iterator<Item = u32> + '_ {
        let beyond = self.surplus.partition_point(|pair| (pair[0] as usize) < k);
        let surplus = self.surplus[beyond..].iter().take_while(move |pair| pair[0] as usize == k).map(|pair| pair[1]);
        self.rows[k].iter().copied().filter(move |&j| j as usize != k).chain(surplus)
    }

    /// Σ_j (x_k − x_j) over the first six neighbours j of each vertex k from `first` on; the caller adds what [`Self::surplus`] names.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn differences<'a, T: VertexValue>(&'a self, first: usize, x: &'a [T]) -> impl Iterator<Item = T> + 'a {
        assert_eq!(x.len(), self.rows.len());
        self.rows[first..].iter().zip(&x[first..]).map(move |(row, &own)| {
            // SAFETY: `new` has seen that every entry is below `rows.len()`, which is `x.len()`; rows never change. The seven checks
            // would be a sixth of a frame's time.
            let at = |i: usize| unsafe { *x.get_unchecked(row[i] as usize) };
            own * WIDTH as f32 - ((at(0) + at(1)) + (at(2) + at(3)) + (at(4) + at(5)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{cube, grid, noise_vectors};

    /// Nine triangles around vertex 0, and a vertex of no triangle.
    fn fan() -> Adjacency {
        let triangles: Vec<[u32; 3]> = (1..=9).map(|k| [0, k, k % 9 + 1]).collect();
        Adjacency::new(11, &triangles)
    }

    #[test]
    fn differences_and_surplus_are_the_graph_laplacian() {
        let sheet = grid(4, 3);
        let of_cube = Adjacency::new(8, &cube().triangles);
        for adjacency in [fan(), of_cube, Adjacency::new(sheet.positions.len(), &sheet.triangles)] {
            let rings = Rings::new(&adjacency);
            let x = noise_vectors(adjacency.vertex_count(), 11);
            let mut sums: Vec<_> = rings.differences(0, &x).collect();
            assert!(rings.differences(3, &x).eq(sums[3..].iter().copied()));
            for (k, j) in rings.surplus() {
                sums[k] += x[k] - x[j];
            }
            for (k, sum) in sums.iter().enumerate() {
                let expected: glam::Vec3A = adjacency.of(k).iter().map(|&j| x[k] - x[j as usize]).sum();
                assert!((*sum - expected).length() < 1e-4, "{k}");
                assert_eq!(rings.valences()[k], adjacency.valence(k));
                assert!(rings.of(k).eq(adjacency.of(k).iter().copied()));
            }
        }
        assert_eq!(Rings::new(&fan()).surplus().count(), 3, "nine neighbours are three more than six");
    }

    #[test]
    #[should_panic]
    fn a_vector_of_another_length_is_refused() {
        let _ = Rings::new(&fan()).differences(0, &[1.0f32; 10]).count();
    }

    #[test]
    #[should_panic]
    fn a_neighbour_that_does_not_exist_is_refused() {
        Rings::new(&Adjacency { offsets: vec![0, 1], neighbours: vec![1] });
    }
}
