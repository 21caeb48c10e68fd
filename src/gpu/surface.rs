//! The last pass: positions and normals, as the renderer's vertex buffer has them.

use super::kernel::{Dispatch, Gpu, Kernel, Shader, front, whole};
use super::topology::GpuCorners;
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("frame.wgsl"), include_str!("surface.wgsl"));

/// Bytes of a drawn vertex: see `SurfaceVertex`.
const VERTEX_BYTES: u64 = 16;

/// Makes drawn vertices of base mesh and displacement.
pub(super) struct SurfaceKernel(Kernel);

impl SurfaceKernel {
    pub fn new(gpu: &Gpu) -> Self {
        Self(Shader::new(gpu, "surface", SOURCE).kernel("surface"))
    }

    /// Writes the first `vertex_count` of `vertices`, and to `nowhere` how many of them have no place.
    pub fn dispatch(
        &self,
        frame: &Buffer,
        [base, displacement, vertices, nowhere]: [&Buffer; 4],
        corners: &GpuCorners,
        vertex_count: usize,
    ) -> Dispatch {
        let bindings = [
            (0, whole(frame)),
            (1, whole(base)),
            (2, whole(displacement)),
            (3, whole(&corners.offsets)),
            (4, whole(&corners.corners)),
            (5, front(vertices, vertex_count as u64 * VERTEX_BYTES)),
            (6, whole(nowhere)),
        ];
        self.0.over_ranges(vertex_count, &bindings)
    }
}
