//! What each row of the reconstruction lacks, in metres: row scales times δ, less the base's own Laplacian in the absolute form.

use super::kernel::{Dispatch, Shader, numbered};
use super::topology::{GpuCorners, GpuRings};
use wgpu::{Buffer, Device};

/// WGSL of the pass.
pub(super) const SOURCE: &str = concat!(include_str!("frame.wgsl"), include_str!("residual.wgsl"));

/// r from base mesh and posed δ, all on the finest level with its `vertex_count` vertices.
pub(super) fn row_residual(
    device: &Device,
    frame: &Buffer,
    [base, deltas, residual]: [&Buffer; 3],
    corners: &GpuCorners,
    rings: &GpuRings,
    vertex_count: usize,
) -> Dispatch {
    let buffers =
        [frame, base, deltas, &corners.offsets, &corners.corners, &rings.offsets, &rings.neighbours, residual];
    Shader::new(device, "residual", SOURCE).kernel("row_residual").over(vertex_count, &numbered(buffers))
}
