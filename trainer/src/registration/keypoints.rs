//! Joints that someone found: in space, or in a camera's picture.

use super::articulated::Posed;
use super::system::System;
use crate::sequence::Camera;
use glam::Vec3A;

/// Weight of all points in space together, against the scan's mean square.
const SPACE_WEIGHT: f64 = 0.2;
/// Weight of all points of a picture together; their gaps are metres at the joint's depth.
const PICTURE_WEIGHT: f64 = 0.05;
/// Gap at which a joint of a picture begins to count less, metres: detectors mix up sides.
const REACH: f64 = 0.15;

/// Joints of one frame.
#[derive(Clone, Debug, Default)]
pub struct Keypoints {
    /// (joint, position in the world, metres).
    pub space: Vec<(usize, Vec3A)>,
    /// (joint, pixel, confidence from 0 to 1).
    pub picture: Vec<(usize, [f32; 2], f32)>,
    /// The camera of the picture.
    pub camera: Option<Camera>,
}

/// Adds the gaps of all joints and returns their energy.
pub fn add_keypoints(posed: &Posed, keypoints: &Keypoints, system: &mut System) -> f64 {
    let mut energy = 0.0;
    let weight = SPACE_WEIGHT / keypoints.space.len().max(1) as f64;
    for &(joint, wanted) in &keypoints.space {
        let position = posed.joints[joint];
        let motion = posed.rigid_motion(joint, position);
        for axis in [Vec3A::X, Vec3A::Y, Vec3A::Z] {
            let gap = f64::from(axis.dot(position - wanted));
            system.add(&posed.row(&motion, axis), gap, weight);
            energy += weight * gap * gap;
        }
    }
    let Some(camera) = &keypoints.camera else { return energy };
    let weight = PICTURE_WEIGHT / keypoints.picture.len().max(1) as f64;
    for &(joint, pixel, confidence) in &keypoints.picture {
        let position = posed.joints[joint];
        let motion = posed.rigid_motion(joint, position);
        let seen = camera.camera_from_world.transform_point3a(position);
        for axis in 0..2 {
            // The gap in the plane of the joint: linear in the joint's position.
            let slope = (pixel[axis] - camera.centre[axis]) / camera.focal[axis];
            let gap = f64::from(seen[axis] - slope * seen.z);
            let mut direction = Vec3A::ZERO;
            direction[axis] = 1.0;
            direction.z = -slope;
            let direction = camera.world_from_camera.transform_vector3a(direction);
            let weight = weight * f64::from(confidence) / (1.0 + gap * gap / (REACH * REACH)).powi(2);
            system.add(&posed.row(&motion, direction), gap, weight);
            energy += weight * gap * gap;
        }
    }
    energy
}
