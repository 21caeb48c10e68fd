//! Who is whose neighbour.

use super::Triangle;
use crate::order::sort_few;

/// Neighbours of each vertex in compressed rows; those of a mesh ascend within a row.
#[derive(Clone, Debug)]
pub struct Adjacency {
    /// `offsets[k]..offsets[k + 1]` is the row of vertex k in `neighbours`; length V + 1.
    pub offsets: Vec<u32>,
    /// Neighbour indices.
    pub neighbours: Vec<u32>,
}

impl Adjacency {
    /// Adjacency of `vertex_count` vertices under `triangles`, which may be closed or open. A vertex of no triangle has an empty row.
    pub fn new(vertex_count: usize, triangles: &[Triangle]) -> Self {
        // Each triangle gives each corner two neighbours; an inner edge arrives twice and is merged after sorting.
        let mut starts = vec![0u32; vertex_count + 1];
        for &corner in triangles.as_flattened() {
            starts[corner as usize + 1] += 2;
        }
        for k in 0..vertex_count {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut candidates = vec![0u32; 6 * triangles.len()];
        for &[a, b, c] in triangles {
            for (corner, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let at = next[corner as usize] as usize;
                candidates[at..at + 2].copy_from_slice(&others);
                next[corner as usize] += 2;
            }
        }

        // Rows move together in their own place: this is the largest list of setting up a solver.
        let (mut neighbours, mut length) = (candidates, 0);
        let mut offsets = Vec::with_capacity(vertex_count + 1);
        offsets.push(0);
        for k in 0..vertex_count {
            let row = starts[k] as usize..starts[k + 1] as usize;
            sort_few(&mut neighbours[row.clone()]);
            let mut last = None;
            for at in row {
                let neighbour = neighbours[at];
                // A triangle that names a vertex twice makes no vertex its own neighbour.
                if Some(neighbour) != last && neighbour as usize != k {
                    neighbours[length] = neighbour;
                    length += 1;
                }
                last = Some(neighbour);
            }
            offsets.push(length as u32);
        }
        neighbours.truncate(length);
        neighbours.shrink_to_fit();
        Self { offsets, neighbours }
    }

    /// Rows whose neighbours ascend, of rows that may be in any order.
    #[cfg(feature = "factor")]
    pub(crate) fn sorted(mut self) -> Self {
        for row in self.offsets.windows(2) {
            sort_few(&mut self.neighbours[row[0] as usize..row[1] as usize]);
        }
        self
    }

    /// Neighbours of vertex `k`.
    pub fn of(&self, k: usize) -> &[u32] {
        &self.neighbours[self.offsets[k] as usize..self.offsets[k + 1] as usize]
    }

    /// Number of neighbours of vertex `k`.
    pub fn valence(&self, k: usize) -> usize {
        (self.offsets[k + 1] - self.offsets[k]) as usize
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Each edge once, as (smaller, larger), in ascending order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.neighbours.len() / 2);
        for k in 0..self.vertex_count() {
            edges.extend(self.of(k).iter().filter(|&&j| j as usize > k).map(|&j| [k as u32, j]));
        }
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{grid, icosahedron, torus};

    #[test]
    fn closed_mesh_has_known_valences_and_euler_count() {
        let (ico, ring) = (icosahedron(), torus(12, 8));
        let adjacency = Adjacency::new(12, &ico.triangles);
        assert!((0..12).all(|k| adjacency.valence(k) == 5));
        assert_eq!(12 + ico.triangles.len() - adjacency.edges().len(), 2);

        let adjacency = Adjacency::new(ring.positions.len(), &ring.triangles);
        assert!((0..96).all(|k| adjacency.valence(k) == 6));
        assert_eq!(96 + ring.triangles.len(), adjacency.edges().len());
    }

    #[test]
    fn open_mesh_keeps_its_boundary_edges_once() {
        let sheet = grid(3, 2);
        let adjacency = Adjacency::new(sheet.positions.len(), &sheet.triangles);
        assert_eq!(adjacency.of(0), [1, 4, 5]);
        assert_eq!(adjacency.edges().len(), sheet.positions.len() + sheet.triangles.len() - 1);
    }

    #[test]
    fn rows_ascend_and_are_symmetric() {
        let ring = torus(9, 5);
        let adjacency = Adjacency::new(ring.positions.len(), &ring.triangles);
        for k in 0..adjacency.vertex_count() {
            assert!(adjacency.of(k).is_sorted_by(|a, b| a < b));
            assert!(adjacency.of(k).iter().all(|&j| adjacency.of(j as usize).contains(&(k as u32))));
        }
    }

    #[test]
    fn a_vertex_of_no_triangle_and_a_degenerate_triangle_are_harmless() {
        let adjacency = Adjacency::new(5, &[[0, 1, 2], [3, 3, 1]]);
        assert_eq!(adjacency.of(4), [0u32; 0]);
        assert_eq!(adjacency.of(3), [1]);
        assert_eq!(adjacency.edges(), [[0, 1], [0, 2], [1, 2], [1, 3]]);
    }
}
