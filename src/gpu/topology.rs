//! Who is whose neighbour on a level, in GPU buffers.

use super::kernel::{Gpu, storage_of};
use crate::mesh::{Adjacency, Triangle};
use wgpu::Buffer;

/// Neighbours of each vertex in compressed rows.
#[derive(Clone)]
pub(super) struct GpuRings {
    pub offsets: Buffer,
    pub neighbours: Buffer,
}

/// The other two vertices of each triangle at a vertex, counter-clockwise, in compressed rows.
pub(super) struct GpuCorners {
    pub offsets: Buffer,
    pub corners: Buffer,
}

impl GpuRings {
    pub fn new(gpu: &Gpu, adjacency: &Adjacency) -> Self {
        Self {
            offsets: storage_of(gpu, "rings: offsets", &adjacency.offsets),
            neighbours: storage_of(gpu, "rings: neighbours", &adjacency.neighbours),
        }
    }
}

impl GpuCorners {
    pub fn new(gpu: &Gpu, vertex_count: usize, triangles: &[Triangle]) -> Self {
        let mut offsets = vec![0u32; vertex_count + 1];
        for &corner in triangles.as_flattened() {
            offsets[corner as usize + 1] += 1;
        }
        for k in 0..vertex_count {
            offsets[k + 1] += offsets[k];
        }
        let mut next = offsets.clone();
        let mut corners = vec![[0u32; 2]; 3 * triangles.len()];
        for &[a, b, c] in triangles {
            for (corner, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let at = &mut next[corner as usize];
                corners[*at as usize] = others;
                *at += 1;
            }
        }
        Self { offsets: storage_of(gpu, "corners: offsets", &offsets), corners: storage_of(gpu, "corners", &corners) }
    }
}
