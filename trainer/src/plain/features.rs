//! Inputs of the networks: γ(Q), then θ̄ as masked axis-angle numbers.

use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::pose_feature::PoseMask;
use crease::rotation::axis_angle_from_quat;
use glam::Vec3A;

/// How inputs are laid out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Features {
    encoding: PositionalEncoding,
    joint_count: usize,
}

impl Features {
    pub(super) fn new(encoding: PositionalEncoding, joint_count: usize) -> Self {
        Self { encoding, joint_count }
    }

    /// Numbers a point.
    pub(super) fn length(self) -> usize {
        self.encoding.length() + 3 * self.joint_count
    }

    /// θ: three numbers a joint, radians.
    pub(super) fn axis_angles(pose: &Pose) -> Vec<[f32; 3]> {
        pose.rotations.iter().map(|&rotation| axis_angle_from_quat(rotation).to_array()).collect()
    }

    /// Fills one row; joints outside the mask are zero.
    pub(super) fn fill(self, canonical: Vec3A, mask: PoseMask, axis_angles: &[[f32; 3]], row: &mut [f32]) {
        let (encoded, masked) = row.split_at_mut(self.encoding.length());
        self.encoding.encode(canonical, encoded);
        masked.fill(0.0);
        for joint in mask.joints().take_while(|&joint| joint < self.joint_count) {
            masked[3 * joint..3 * joint + 3].copy_from_slice(&axis_angles[joint]);
        }
    }
}
