//! What is known before any scan: how joints of people bend, which shapes are common, how little changes from frame to frame.

use super::articulated::{ArticulatedBody, State, difference, left_jacobian_inverse};
use super::system::System;
use crease::rotation::axis_angle_from_quat;
use glam::{Quat, Vec3};

/// How one joint usually bends: axis-angle numbers in the parent's frame, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointPrior {
    /// Where it rests.
    pub mean: Vec3,
    /// Usual deviation about each axis.
    pub spread: Vec3,
    /// Least and greatest number about each axis.
    pub limits: [Vec3; 2],
}

const fn prior(mean: [f32; 3], spread: [f32; 3], least: [f32; 3], greatest: [f32; 3]) -> JointPrior {
    JointPrior {
        mean: Vec3::from_array(mean),
        spread: Vec3::from_array(spread),
        limits: [Vec3::from_array(least), Vec3::from_array(greatest)],
    }
}

const fn symmetric(spread: [f32; 3], limit: [f32; 3]) -> JointPrior {
    prior([0.0; 3], spread, [-limit[0], -limit[1], -limit[2]], limit)
}

/// Joints of SMPL by name. T-pose rest: the left arm points along +x, legs along −y, the face looks along +z; so knees bend by +x, hips by −x,
/// a left elbow by −y, and a left arm hangs at −z.
pub fn joint_prior(name: &str) -> JointPrior {
    const FREE: JointPrior = symmetric([10.0; 3], [10.0; 3]);
    const RIGID: JointPrior = symmetric([0.1; 3], [0.3; 3]);
    let (side, part) = match name.split_once('_') {
        Some(("left", part)) => (1.0, part),
        Some(("right", part)) => (-1.0, part),
        _ => (1.0, name),
    };
    let left = match part {
        "pelvis" => FREE,
        "hip" => prior([0.0; 3], [0.7, 0.4, 0.4], [-2.4, -1.1, -0.7], [0.9, 1.1, 1.1]),
        "knee" => prior([0.2, 0.0, 0.0], [0.8, 0.15, 0.1], [-0.05, -0.5, -0.3], [2.6, 0.5, 0.3]),
        "ankle" => symmetric([0.35, 0.25, 0.25], [1.0, 0.7, 0.6]),
        "spine1" | "spine2" | "spine3" => symmetric([0.25, 0.2, 0.15], [0.8, 0.6, 0.5]),
        "neck" | "head" => symmetric([0.3, 0.3, 0.2], [0.9, 0.9, 0.6]),
        "collar" => symmetric([0.15, 0.2, 0.2], [0.5, 0.6, 0.6]),
        "shoulder" => prior([0.0, 0.0, -0.8], [0.7, 0.7, 0.7], [-1.8, -2.2, -2.0], [1.8, 1.4, 1.6]),
        "elbow" => prior([0.0, -0.3, 0.0], [0.5, 0.8, 0.3], [-1.6, -2.6, -1.2], [1.6, 0.1, 1.2]),
        "wrist" => symmetric([0.3, 0.25, 0.3], [1.0, 0.8, 1.0]),
        _ => RIGID,
    };
    // Mirroring x turns rotations about y and z round.
    let mirrored = |v: Vec3| Vec3::new(v.x, side * v.y, side * v.z);
    let ends = left.limits.map(mirrored);
    JointPrior { mean: mirrored(left.mean), spread: left.spread, limits: [ends[0].min(ends[1]), ends[0].max(ends[1])] }
}

/// Weights against the scan's terms, which are mean squares in m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorWeights {
    /// Of one joint at its usual deviation, m².
    pub pose: f64,
    /// Of a radian beyond a joint's limit, squared, m².
    pub limits: f64,
    /// Of β at one standard deviation, m².
    pub shape: f64,
}

impl Default for PriorWeights {
    fn default() -> Self {
        Self { pose: 1.5e-6, limits: 2e-3, shape: 2e-6 }
    }
}

/// Adds the pose prior and joint limits, and returns their energy.
pub fn add_pose_prior(body: &ArticulatedBody, state: &State, weights: &PriorWeights, system: &mut System) -> f64 {
    let mut energy = 0.0;
    for (joint, name) in body.body.joint_names.iter().enumerate() {
        let JointPrior { mean, spread, limits } = joint_prior(name);
        let angles = axis_angle_from_quat(state.pose.rotations[joint]);
        let jacobian = left_jacobian_inverse(angles);
        for axis in 0..3 {
            let row: Vec<(usize, f64)> = (0..3).map(|k| (3 * joint + k, f64::from(jacobian.col(k)[axis]))).collect();
            let mut add = |residual: f32, weight: f64| {
                system.add(&row, f64::from(residual), weight);
                energy += weight * f64::from(residual * residual);
            };
            add(angles[axis] - mean[axis], weights.pose / f64::from(spread[axis] * spread[axis]));
            let beyond = angles[axis] - angles[axis].clamp(limits[0][axis], limits[1][axis]);
            if beyond != 0.0 {
                add(beyond, weights.limits);
            }
        }
    }
    energy
}

/// Adds the shape prior: β is standard normal. `first` is the unknown of β_0.
pub fn add_shape_prior(betas: &[f32], first: usize, weight: f64, system: &mut System) {
    for (component, &beta) in betas.iter().enumerate() {
        system.add(&[(first + component, 1.0)], f64::from(beta), weight);
    }
}

/// A pose that the wanted one should be near.
#[derive(Clone, Debug)]
pub struct Expected {
    /// Rotations.
    pub rotations: Vec<Quat>,
    /// Metres.
    pub translation: Vec3,
    /// Weight of a radian, squared, m².
    pub rotation_weight: f64,
    /// Weight of a metre, squared.
    pub translation_weight: f64,
}

/// Adds the distance from an expected pose, and returns its energy.
pub fn add_expected(state: &State, expected: &Expected, system: &mut System) -> f64 {
    let mut energy = 0.0;
    for (joint, (&rotation, &wanted)) in state.pose.rotations.iter().zip(&expected.rotations).enumerate() {
        let off = difference(rotation, wanted);
        let jacobian = left_jacobian_inverse(off);
        for axis in 0..3 {
            let row: Vec<(usize, f64)> = (0..3).map(|k| (3 * joint + k, f64::from(jacobian.col(k)[axis]))).collect();
            system.add(&row, f64::from(off[axis]), expected.rotation_weight);
            energy += expected.rotation_weight * f64::from(off[axis] * off[axis]);
        }
    }
    let first = 3 * state.pose.rotations.len();
    let off = state.pose.translation - expected.translation;
    for axis in 0..3 {
        system.add(&[(first + axis, 1.0)], f64::from(off[axis]), expected.translation_weight);
        energy += expected.translation_weight * f64::from(off[axis] * off[axis]);
    }
    energy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::voxel_person;
    use crease::rotation::quat_from_axis_angle;

    #[test]
    fn left_and_right_are_mirror_images() {
        let (left, right) = (joint_prior("left_elbow"), joint_prior("right_elbow"));
        assert_eq!(left.mean.y, -right.mean.y);
        assert_eq!(left.limits[0].y, -right.limits[1].y);
        assert_eq!(left.spread, right.spread);
        assert!(right.limits[0].y < right.limits[1].y);
    }

    #[test]
    fn a_knee_bent_backwards_is_driven_back() {
        let body = voxel_person();
        let articulated = ArticulatedBody::new(&body, 2);
        let mut state = articulated.rest();
        state.pose.rotations[4] = Quat::from_rotation_x(-0.8);
        for _ in 0..10 {
            let mut system = System::new(articulated.pose_unknowns());
            add_pose_prior(&articulated, &state, &PriorWeights::default(), &mut system);
            state = articulated.moved(&state, &system.step(1e-3));
        }
        let angle = axis_angle_from_quat(state.pose.rotations[4]).x;
        assert!((angle - 0.2).abs() < 1e-2, "{angle}");
    }

    #[test]
    fn an_expected_pose_is_reached() {
        let body = voxel_person();
        let articulated = ArticulatedBody::new(&body, 2);
        let mut state = articulated.rest();
        let mut expected = Expected {
            rotations: state.pose.rotations.clone(),
            translation: Vec3::new(0.1, 0.2, 0.3),
            rotation_weight: 1.0,
            translation_weight: 1.0,
        };
        expected.rotations[16] = quat_from_axis_angle(Vec3::new(0.3, -0.9, 0.4));
        for _ in 0..6 {
            let mut system = System::new(articulated.pose_unknowns());
            add_expected(&state, &expected, &mut system);
            state = articulated.moved(&state, &system.step(0.0));
        }
        assert!(state.pose.rotations[16].angle_between(expected.rotations[16]) < 2e-3);
        assert!(state.pose.translation.distance(expected.translation) < 1e-4);
    }
}
