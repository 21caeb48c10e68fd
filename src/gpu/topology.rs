//! Who is whose neighbour on a level, in GPU buffers.

use super::kernel::{Gpu, storage_of};
use crate::mesh::Triangle;
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
    /// From the neighbours of each vertex.
    pub fn new(gpu: &Gpu, rings: impl ExactSizeIterator<Item: Iterator<Item = u32>>) -> Self {
        let mut offsets = Vec::with_capacity(rings.len() + 1);
        // Six is the mean on closed meshes, nearly.
        let mut neighbours = Vec::with_capacity(6 * rings.len());
        offsets.push(0);
        for ring in rings {
            neighbours.extend(ring);
            offsets.push(neighbours.len() as u32);
        }
        Self {
            offsets: storage_of(gpu, "rings: offsets", &offsets),
            neighbours: storage_of(gpu, "rings: neighbours", &neighbours),
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
