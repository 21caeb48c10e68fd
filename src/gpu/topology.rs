//! Who is whose neighbour on a level, in GPU buffers.

use super::kernel::{Gpu, storage_of};
use crate::mesh::{Incidence, Triangle};
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
        let Incidence { offsets, corners } = Incidence::new(vertex_count, triangles);
        let others = |&corner: &u32| {
            let [a, b, c] = triangles[corner as usize / 3];
            [[b, c], [c, a], [a, b]][corner as usize % 3]
        };
        let corners: Vec<[u32; 2]> = corners.iter().map(others).collect();
        Self { offsets: storage_of(gpu, "corners: offsets", &offsets), corners: storage_of(gpu, "corners", &corners) }
    }
}
