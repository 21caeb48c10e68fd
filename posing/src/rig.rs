//! A shaped body that can be posed: linear blend skinning (paper Eq. lbs).

use crate::rotation;
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};

/// Four influences a vertex; unused ones have weight 0; weights sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Joint indices.
    pub joints: Vec<[u8; 4]>,
    /// Weights.
    pub weights: Vec<[f32; 4]>,
}

/// A body of one shape: what posing needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// Rest vertices, T-pose, metres.
    pub rest: Vec<Vec3A>,
    /// Rest joint positions, metres.
    pub rest_joints: Vec<Vec3A>,
    /// Parent of each joint; parents come before children; joint 0 is the root.
    pub parents: Vec<Option<usize>>,
    /// Joint names.
    pub joint_names: Vec<String>,
    /// Skinning weights.
    pub skin: Skin,
    /// Pose blend shapes, if the model has them (see `Body::pose_directions`).
    pub pose_directions: Option<Vec<Vec<Vec3A>>>,
}

/// Joint rotations relative to the parent, and the root's translation in metres.
#[derive(Debug, PartialEq)]
pub struct Pose {
    /// One unit quaternion per joint; joint 0 is the root's orientation.
    pub rotations: Vec<Quat>,
    /// Added to every posed vertex.
    pub translation: Vec3,
}

impl Clone for Pose {
    fn clone(&self) -> Self {
        Self { rotations: self.rotations.clone(), translation: self.translation }
    }

    /// Allocates nothing where the joints are as many.
    fn clone_from(&mut self, source: &Self) {
        self.rotations.clone_from(&source.rotations);
        self.translation = source.translation;
    }
}

impl Pose {
    /// Becomes what lies between itself (`weight` 0) and `other` (1), a pose of the same skeleton; each joint takes the shorter way round.
    pub fn blend(&mut self, other: &Pose, weight: f32) {
        for (rotation, other) in self.rotations.iter_mut().zip(&other.rotations) {
            *rotation = rotation.slerp(*other, weight);
        }
        self.translation = self.translation.lerp(other.translation, weight);
    }

    /// The rest pose (T-pose at the origin).
    pub fn rest(joint_count: usize) -> Self {
        Self { rotations: vec![Quat::IDENTITY; joint_count], translation: Vec3::ZERO }
    }

    /// From SMPL's axis-angle numbers: three per joint, radians.
    pub fn from_axis_angle(numbers: &[f32], translation: Vec3) -> Self {
        let rotations =
            numbers.chunks_exact(3).map(|n| rotation::quat_from_axis_angle(Vec3::new(n[0], n[1], n[2]))).collect();
        Self { rotations, translation }
    }
}

impl Rig {
    /// Where the root joint is in `pose`, metres.
    pub fn root(&self, pose: &Pose) -> Vec3 {
        Vec3::from(self.rest_joints[0]) + pose.translation
    }
}

/// Rigid transform of each joint from the rest pose to `pose`, translation included.
pub fn posed_from_rest(rig: &Rig, pose: &Pose) -> Vec<Affine3A> {
    let mut transforms = Vec::new();
    put_posed_from_rest(rig, pose, &mut transforms);
    transforms
}

/// [`posed_from_rest`] into memory that is there already.
pub fn put_posed_from_rest(rig: &Rig, pose: &Pose, world_from_joint: &mut Vec<Affine3A>) {
    world_from_joint.clear();
    for (joint, parent) in rig.parents.iter().enumerate() {
        let rotation = pose.rotations[joint];
        let transform = match parent {
            None => {
                Affine3A::from_rotation_translation(rotation, Vec3::from(rig.rest_joints[joint]) + pose.translation)
            }
            Some(parent) => {
                let offset = rig.rest_joints[joint] - rig.rest_joints[*parent];
                world_from_joint[*parent] * Affine3A::from_rotation_translation(rotation, offset.into())
            }
        };
        world_from_joint.push(transform);
    }
    for (transform, &joint) in world_from_joint.iter_mut().zip(&rig.rest_joints) {
        *transform *= Affine3A::from_translation(-Vec3::from(joint));
    }
}

impl Rig {
    /// Every vertex of the body in `pose`, metres: pose blend shapes, then skinning by the pose's [`posed_from_rest`].
    pub fn posed(&self, pose: &Pose, posed_from_rest: &[Affine3A]) -> Vec<Vec3A> {
        let mut positions = self.rest.clone();
        self.add_pose_blend_shapes(pose, &mut positions);
        for (vertex, position) in positions.iter_mut().enumerate() {
            *position = self.skin.blend(vertex, posed_from_rest).transform_point3a(*position);
        }
        positions
    }

    /// Adds Σ_n (R_j − I)_n D_n over the pose blend shapes D, joints 1.., row-major; nothing where the model has none.
    pub fn add_pose_blend_shapes(&self, pose: &Pose, positions: &mut [Vec3A]) {
        let directions = self.pose_directions.as_deref().unwrap_or_default();
        for (joint_directions, &rotation) in directions.chunks_exact(9).zip(&pose.rotations[1..]) {
            let difference = (Mat3A::from_quat(rotation) - Mat3A::IDENTITY).transpose().to_cols_array();
            for (direction, factor) in joint_directions.iter().zip(difference) {
                if factor != 0.0 {
                    for (position, offset) in positions.iter_mut().zip(direction) {
                        *position += factor * *offset;
                    }
                }
            }
        }
    }
}

impl Skin {
    /// Blended transform of vertex `vertex`.
    pub fn blend(&self, vertex: usize, posed_from_rest: &[Affine3A]) -> Affine3A {
        let mut matrix = Mat3A::ZERO;
        let mut translation = Vec3A::ZERO;
        for (&joint, &weight) in self.joints[vertex].iter().zip(&self.weights[vertex]) {
            if weight != 0.0 {
                let transform = &posed_from_rest[joint as usize];
                matrix += transform.matrix3 * weight;
                translation += transform.translation * weight;
            }
        }
        Affine3A { matrix3: matrix, translation }
    }
}
