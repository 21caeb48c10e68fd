//! What each row of the reconstruction lacks, in metres: row scales times δ, less the base's own Laplacian in the absolute form.

use super::kernel::{Dispatch, Gpu, Kernel, Shader, numbered};
use super::topology::{GpuCorners, GpuRings};
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("frame.wgsl"), include_str!("residual.wgsl"));

/// Makes r of base mesh and posed δ.
pub(super) struct ResidualKernel(Kernel);

impl ResidualKernel {
    pub fn new(gpu: &Gpu) -> Self {
        Self(Shader::new(gpu, "residual", SOURCE).kernel("row_residual"))
    }

    /// r from base mesh and posed δ, all on one level with its `vertex_count` vertices.
    pub fn dispatch(
        &self,
        frame: &Buffer,
        [base, deltas, residual]: [&Buffer; 3],
        corners: &GpuCorners,
        rings: &GpuRings,
        vertex_count: usize,
    ) -> Dispatch {
        let buffers =
            [frame, base, deltas, &corners.offsets, &corners.corners, &rings.offsets, &rings.neighbours, residual];
        self.0.over(vertex_count, &numbered(buffers))
    }
}
