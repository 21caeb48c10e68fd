//! Level 0 of the base: rest pose, offsets and pose blend shapes, skinned.

use super::kernel::{Dispatch, Gpu, Shader, storage_of};
use crate::body::Rig;
use crate::wgsl::wgsl;
use glam::Vec3A;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("frame.wgsl"), include_str!("skinning.wgsl"));

/// Host twin of `Vertex` in skinning.wgsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    rest: [f32; 3],
    joints: u32,
    weights: [f32; 4],
}

/// Poses the vertices of level 0 into `positions`; `offsets` has one vector for each.
pub(super) fn pose(gpu: &Gpu, rig: &Rig, frame: &Buffer, offsets: &Buffer, positions: &Buffer) -> Dispatch {
    let vertices: Vec<Vertex> = (rig.rest.iter().zip(&rig.skin.joints).zip(&rig.skin.weights))
        .map(|((rest, &joints), &weights)| Vertex {
            rest: rest.to_array(),
            joints: u32::from_le_bytes(joints),
            weights,
        })
        .collect();
    let directions: Vec<[f32; 3]> =
        rig.pose_directions.iter().flatten().flatten().map(|direction: &Vec3A| direction.to_array()).collect();
    Shader::new(gpu, "skinning", SOURCE).kernel("skin").over(
        vertices.len(),
        &[
            (0, frame),
            (1, &storage_of(gpu, "skinning: vertices", &vertices)),
            (2, offsets),
            (3, &storage_of(gpu, "skinning: pose directions", &directions)),
            (4, positions),
        ],
    )
}
