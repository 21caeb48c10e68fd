//! A number for each edge of a mesh, and what one subdivision makes of its triangles.

use super::{Adjacency, Triangle};

/// Edges numbered in ascending order of their (smaller, larger) vertex pair.
pub struct EdgeIndex {
    adjacency: Adjacency,
    /// The first edge from each vertex to a larger one; those edges follow each other.
    first: Vec<u32>,
}

impl EdgeIndex {
    /// Of `triangles`, whose indices must be below `vertex_count`.
    pub fn new(vertex_count: usize, triangles: &[Triangle]) -> Self {
        let adjacency = Adjacency::new(vertex_count, triangles);
        let mut first = Vec::with_capacity(vertex_count);
        let mut next = 0;
        for k in 0..vertex_count {
            first.push(next);
            next += adjacency.of(k).iter().filter(|&&j| j as usize > k).count() as u32;
        }
        Self { adjacency, first }
    }

    /// Who is whose neighbour.
    pub fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }

    /// All edges, as (smaller, larger).
    pub fn edges(&self) -> Vec<[u32; 2]> {
        self.adjacency.edges()
    }

    /// Number of the edge between `a` and `b`, which must be there.
    pub fn of(&self, a: u32, b: u32) -> u32 {
        let (smaller, larger) = (a.min(b), a.max(b));
        let row = self.adjacency.of(smaller as usize);
        let is_before = |bound: u32| row.partition_point(|&j| j < bound) as u32;
        self.first[smaller as usize] + is_before(larger) - is_before(smaller)
    }

    /// The triangles of the next level, where edge e has vertex `vertex_count + e`: triangle t = \[a, b, c\] becomes, at 4t .. 4t + 4 and in
    /// the same orientation, its corners \[a, ab, ca\], \[b, bc, ab\], \[c, ca, bc\] and its middle \[ab, bc, ca\].
    pub fn split(&self, triangles: &[Triangle]) -> Vec<Triangle> {
        let vertex_count = self.adjacency.vertex_count() as u32;
        let mut split = Vec::with_capacity(4 * triangles.len());
        for &[a, b, c] in triangles {
            // A triangle that names a vertex twice has no such edge; its pieces stay degenerate.
            let middle = |a: u32, b: u32| if a == b { a } else { vertex_count + self.of(a, b) };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        split
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_have_their_place_in_the_list() {
        let triangles = [[0, 1, 2], [2, 1, 3]];
        let index = EdgeIndex::new(4, &triangles);
        let edges = index.edges();
        assert_eq!(edges, [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]);
        for (number, &[a, b]) in edges.iter().enumerate() {
            assert_eq!([index.of(a, b), index.of(b, a)], [number as u32; 2]);
        }
        assert_eq!(index.split(&triangles)[4..], [[2, 6, 8], [1, 7, 6], [3, 8, 7], [6, 7, 8]]);
        assert_eq!(index.split(&[[1, 1, 3]]), [[1, 1, 7], [1, 7, 1], [3, 7, 7], [1, 7, 7]]);
    }
}
