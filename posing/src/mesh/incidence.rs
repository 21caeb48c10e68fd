//! Where each vertex stands in a list of triangles: one thread adds up triangle by triangle, several of a processor or of a GPU vertex by
//! vertex, each its own.

use super::Triangle;

/// Which corners of triangles vertices are, in compressed rows that ascend. Corner 3 t + i is the i-th of triangle t.
#[derive(Clone, Debug)]
pub struct Incidence {
    /// `offsets[k]..offsets[k + 1]` is the row of vertex k in `corners`; length V + 1.
    pub offsets: Vec<u32>,
    /// Corners.
    pub corners: Vec<u32>,
}

impl Incidence {
    /// Of `triangles` over `vertex_count` vertices.
    pub fn new(vertex_count: usize, triangles: &[Triangle]) -> Self {
        let mut offsets = vec![0u32; vertex_count + 1];
        for &vertex in triangles.as_flattened() {
            offsets[vertex as usize + 1] += 1;
        }
        for k in 0..vertex_count {
            offsets[k + 1] += offsets[k];
        }
        let mut corners = vec![0; 3 * triangles.len()];
        let mut ends = offsets.clone();
        for (corner, &vertex) in (0..).zip(triangles.as_flattened()) {
            let end = &mut ends[vertex as usize];
            corners[*end as usize] = corner;
            *end += 1;
        }
        Self { offsets, corners }
    }

    /// The corners that each vertex from `first` on is, ascending.
    pub fn of_vertices(&self, first: usize) -> impl Iterator<Item = &[u32]> {
        self.offsets[first..].windows(2).map(|range| &self.corners[range[0] as usize..range[1] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corner_is_found_at_its_vertex() {
        let incidence = Incidence::new(5, &[[0, 1, 2], [2, 1, 4], [4, 0, 4]]);
        let corners: Vec<&[u32]> = incidence.of_vertices(0).collect();
        assert_eq!(corners, [&[0, 7][..], &[1, 4], &[2, 3], &[], &[5, 6, 8]]);
        assert!(incidence.of_vertices(3).eq(corners[3..].iter().copied()));
    }
}
