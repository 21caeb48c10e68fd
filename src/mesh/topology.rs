//! Who is whose neighbour.

use super::Triangle;

/// Neighbours of each vertex in compressed rows; neighbours ascend within a row.
#[derive(Clone, Debug)]
pub struct Adjacency {
    /// `offsets[k]..offsets[k + 1]` is the row of vertex k in `neighbours`; length V + 1.
    pub offsets: Vec<u32>,
    /// Neighbour indices.
    pub neighbours: Vec<u32>,
}

impl Adjacency {
    /// Adjacency of `vertex_count` vertices under `triangles`.
    pub fn new(vertex_count: usize, triangles: &[Triangle]) -> Self {
        let _ = (vertex_count, triangles);
        todo!()
    }

    /// Neighbours of vertex `k`.
    pub fn of(&self, k: usize) -> &[u32] {
        &self.neighbours[self.offsets[k] as usize..self.offsets[k + 1] as usize]
    }
}
