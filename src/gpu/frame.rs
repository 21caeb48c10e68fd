//! What one frame asks for: the pose and the options, in one upload. The skeleton's few matrices are multiplied here.

use crate::animate::{Options, Stage};
use crate::avatar::{Avatar, Form};
use crate::body::{Pose, posed_from_rest};
use crate::rotation::axis_angle_from_quat;
use glam::{Affine3A, Mat3, Quat, Vec3};

/// Joints that a frame has room for: as many as a pose mask has bits.
const JOINT_LIMIT: usize = 32;

/// Host twin of `Joint` in frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Joint {
    pub posed_from_rest: [[f32; 4]; 3],
    pub rotation: [[f32; 4]; 3],
    pub angles: [f32; 4],
}

/// Host twin of `Frame` in frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Frame {
    pub joints: [Joint; JOINT_LIMIT],
    pub detail: f32,
    pub offset_share: f32,
    pub base_share: f32,
    pub displacement_share: f32,
    pub liveliness: f32,
    pub padding: [f32; 3],
}

impl Frame {
    pub fn new(avatar: &Avatar, pose: &Pose, options: &Options) -> Self {
        let mut joints = [Joint::default(); JOINT_LIMIT];
        let transforms = posed_from_rest(&avatar.rig, pose);
        for ((joint, transform), &rotation) in joints.iter_mut().zip(&transforms).zip(&pose.rotations) {
            *joint = Joint::new(transform, rotation);
        }
        Self {
            joints,
            detail: options.detail,
            offset_share: if options.stage == Stage::Body { 0.0 } else { 1.0 },
            base_share: if avatar.form == Form::Absolute { 1.0 } else { 0.0 },
            displacement_share: if is_detailed(options) { 1.0 } else { 0.0 },
            liveliness: options.liveliness,
            padding: [0.0; 3],
        }
    }
}

/// Whether there is anything to solve.
pub(super) fn is_detailed(options: &Options) -> bool {
    options.stage == Stage::Detailed && options.detail != 0.0
}

impl Joint {
    fn new(posed_from_rest: &Affine3A, rotation: Quat) -> Self {
        let rows = glam::Mat4::from(*posed_from_rest).transpose().to_cols_array_2d();
        let columns = Mat3::from_quat(rotation).to_cols_array_2d();
        let padded = |v: Vec3| v.extend(0.0).to_array();
        Self {
            posed_from_rest: [rows[0], rows[1], rows[2]],
            rotation: columns.map(|column| padded(Vec3::from_array(column))),
            angles: padded(axis_angle_from_quat(rotation)),
        }
    }
}
