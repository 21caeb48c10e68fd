//! Limbs keep out of each other: balls along the bones, pushed apart where they overlap.

use super::articulated::{ArticulatedBody, Posed};
use super::system::System;
use crease::body::Body;
use glam::Vec3A;

/// Balls along one bone.
const BALLS_A_BONE: usize = 4;
/// Share of the bone's thickness that a ball fills: skin may touch skin.
const FILLING: f32 = 0.75;
/// Weight of a metre of overlap, squared.
const WEIGHT: f64 = 2e-2;
/// Bones that push each other, by the joint at their upper end: arms against the trunk, the legs and each other, and leg against leg.
const LIMBS: [&[&str]; 5] = [
    &["left_elbow", "left_wrist"],
    &["right_elbow", "right_wrist"],
    &["left_hip", "left_knee"],
    &["right_hip", "right_knee"],
    &["spine1", "spine2", "spine3", "head"],
];
/// Pairs of [`LIMBS`] that never are neighbours on the body.
const PAIRS: [(usize, usize); 8] = [(0, 1), (0, 2), (0, 3), (0, 4), (1, 2), (1, 3), (1, 4), (2, 3)];

/// A ball fixed to a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    joint: usize,
    /// From the joint, in the rest pose, metres.
    offset: Vec3A,
    radius: f32,
}

/// The balls of a body, limb by limb.
#[derive(Clone)]
pub struct Proxies {
    limbs: Vec<Vec<Ball>>,
}

impl Proxies {
    /// Balls as thick as the body around its bones.
    pub fn new(articulated: &ArticulatedBody) -> Self {
        let body = articulated.body;
        let rig = body.shaped(&[]);
        let limbs = LIMBS.iter().map(|names| {
            let joints = names.iter().filter_map(|name| articulated.joint(name));
            joints.flat_map(|joint| balls(body, &rig.rest_joints, joint)).collect()
        });
        Self { limbs: limbs.collect() }
    }
}

/// Balls from a joint to its child, or to the far end of its skin where it has none.
fn balls(body: &Body, rest_joints: &[Vec3A], joint: usize) -> Vec<Ball> {
    let own: Vec<Vec3A> = (0..body.template.len())
        .filter(|&v| body.skin.joints[v][0] as usize == joint)
        .map(|v| body.template[v] - rest_joints[joint])
        .collect();
    if own.is_empty() {
        return Vec::new();
    }
    let centre = own.iter().sum::<Vec3A>() / own.len() as f32;
    let child = body.parents.iter().position(|&parent| parent == Some(joint));
    let axis = child.map_or(2.0 * centre, |child| rest_joints[child] - rest_joints[joint]);
    let squared = axis.length_squared().max(1e-6);
    let radius = own.iter().map(|&v| (v - axis * (v.dot(axis) / squared).clamp(0.0, 1.0)).length()).sum::<f32>()
        / own.len() as f32;
    let at = |i: usize| axis * ((i as f32 + 0.5) / BALLS_A_BONE as f32);
    (0..BALLS_A_BONE).map(|i| Ball { joint, offset: at(i), radius: FILLING * radius }).collect()
}

/// Adds the squared overlaps and returns their energy.
pub fn add_separation(posed: &Posed, proxies: &Proxies, system: &mut System) -> f64 {
    let mut energy = 0.0;
    let centres: Vec<Vec<Vec3A>> = proxies
        .limbs
        .iter()
        .map(|balls| {
            balls.iter().map(|ball| posed.joints[ball.joint] + posed.turned(ball.joint, ball.offset)).collect()
        })
        .collect();
    for (first, second) in PAIRS {
        for (a, &at) in proxies.limbs[first].iter().zip(&centres[first]) {
            for (b, &bt) in proxies.limbs[second].iter().zip(&centres[second]) {
                let gap = at - bt;
                let overlap = a.radius + b.radius - gap.length();
                if overlap <= 0.0 {
                    continue;
                }
                let direction = gap.normalize_or(Vec3A::X);
                let mut row = posed.row(&posed.rigid_motion(a.joint, at), -direction);
                row.extend(posed.row(&posed.rigid_motion(b.joint, bt), direction));
                system.add_repeated(row, f64::from(overlap), WEIGHT);
                energy += WEIGHT * f64::from(overlap * overlap);
            }
        }
    }
    energy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::voxel_person;
    use glam::Quat;

    #[test]
    fn an_arm_in_the_trunk_comes_out_and_a_free_one_stays() {
        let body = voxel_person();
        let articulated = ArticulatedBody::new(&body, 2);
        let proxies = Proxies::new(&articulated);
        let mut state = articulated.rest();
        let energy = |state: &_, system: &mut System| add_separation(&articulated.pose(state, false), &proxies, system);
        let count = articulated.pose_unknowns();
        assert_eq!(energy(&state, &mut System::new(count)), 0.0, "nothing overlaps in the rest pose");
        // The forearm across the chest and into it.
        state.pose.rotations[16] = Quat::from_rotation_z(-1.5);
        state.pose.rotations[18] = Quat::from_rotation_z(-1.2);
        let before = energy(&state, &mut System::new(count));
        assert!(before > 0.0);
        for _ in 0..20 {
            let mut system = System::new(count);
            energy(&state, &mut system);
            (0..count).for_each(|unknown| system.add(&[(unknown, 1.0)], 0.0, 1e-4));
            state = articulated.moved(&state, &system.step(0.0));
        }
        assert!(energy(&state, &mut System::new(count)) < 0.1 * before);
    }
}
