//! The last pass: positions and normals, as the renderer's vertex buffer has them.

use super::kernel::{Dispatch, Shader, numbered};
use super::topology::GpuCorners;
use wgpu::{Buffer, Device};

/// WGSL of the pass.
pub(super) const SOURCE: &str = concat!(include_str!("frame.wgsl"), include_str!("surface.wgsl"));

/// Writes `vertices` (16 bytes each, see `SurfaceVertex`) from base mesh and displacement.
pub(super) fn surface(
    device: &Device,
    frame: &Buffer,
    [base, displacement, vertices]: [&Buffer; 3],
    corners: &GpuCorners,
    vertex_count: usize,
) -> Dispatch {
    let buffers = [frame, base, displacement, &corners.offsets, &corners.corners, vertices];
    Shader::new(device, "surface", SOURCE).kernel("surface").over(vertex_count, &numbered(buffers))
}
