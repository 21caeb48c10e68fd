//! A body of any shape in any pose, and how its points move when shape and pose change: analytic Jacobians of skinning.
//!
//! Unknowns of a frame, in this order: an increment ω_j for each joint, in the frame of the joint's parent (R_j ← exp(ω_j) R_j, radians);
//! the translation, metres; the shape coefficients β, where they are estimated too.
//!
//! Pose blend shapes move the points but not the derivatives: they are small, and Gauss–Newton steps forgive it.

use crease::body::{Body, Pose, Rig, posed_from_rest};
use crease::mesh::{Triangle, vertex_normals};
use crease::rotation::quat_from_axis_angle;
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};

/// A body model made ready for registration.
pub struct ArticulatedBody<'a> {
    /// The model.
    pub body: &'a Body,
    /// Displacement of each joint for each shape component: `[component][joint]`, metres per unit.
    joint_directions: Vec<Vec<Vec3A>>,
    /// How many shape components are estimated.
    shape_count: usize,
    /// What stands off the rest vertices, metres; empty for the naked skin.
    clothes: Vec<Vec3A>,
}

/// Shape and pose of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// β.
    pub betas: Vec<f32>,
    /// θ and t.
    pub pose: Pose,
}

/// A body in one state.
pub struct Posed<'a> {
    articulated: &'a ArticulatedBody<'a>,
    rig: Rig,
    posed_from_rest: Vec<Affine3A>,
    /// Joint positions in the world, metres.
    pub joints: Vec<Vec3A>,
    /// World rotation of each joint's parent; the identity for the root.
    world_from_parent: Vec<Mat3A>,
    /// Vertices in the world, metres.
    pub vertices: Vec<Vec3A>,
    /// Unit normals of the vertices.
    pub normals: Vec<Vec3A>,
    /// Derivative of each joint's position by each shape coefficient: `[component][joint]`.
    joint_by_shape: Vec<Vec<Vec3A>>,
}

/// How one point of the surface moves.
pub struct Motion {
    /// For each joint that moves the point: the lever a with dx = ω × a for an increment ω in the world's frame.
    levers: Vec<(usize, Vec3A)>,
    /// dx by each shape coefficient.
    by_shape: Vec<Vec3A>,
}

impl<'a> ArticulatedBody<'a> {
    /// Prepares `body`; at most `shape_count` of its shape components are used.
    pub fn new(body: &'a Body, shape_count: usize) -> Self {
        let shape_count = shape_count.min(body.shape_directions.len());
        let joint_directions = body.shape_directions[..shape_count]
            .iter()
            .map(|direction| {
                let displacement = |row: &Vec<(u32, f32)>| row.iter().map(|&(v, w)| w * direction[v as usize]).sum();
                body.joint_regressor.iter().map(displacement).collect()
            })
            .collect();
        Self { body, joint_directions, shape_count, clothes: Vec::new() }
    }

    /// The body with clothes on: offsets from its rest vertices, metres.
    pub fn wearing(self, clothes: Vec<Vec3A>) -> Self {
        Self { clothes, ..self }
    }

    /// Number of joints J.
    pub fn joint_count(&self) -> usize {
        self.body.parents.len()
    }

    /// The joint of this name.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.body.joint_names.iter().position(|joint| joint == name)
    }

    /// Number of shape coefficients.
    pub fn shape_count(&self) -> usize {
        self.shape_count
    }

    /// Rotations and translation: 3 J + 3.
    pub fn pose_unknowns(&self) -> usize {
        3 * self.joint_count() + 3
    }

    /// The triangles.
    pub fn triangles(&self) -> &[Triangle] {
        &self.body.triangles
    }

    /// Poses the body. Derivatives by shape are there where `with_shape`.
    pub fn pose(&'a self, state: &State, with_shape: bool) -> Posed<'a> {
        let mut rig = self.body.shaped(&state.betas);
        rig.rest.iter_mut().zip(&self.clothes).for_each(|(rest, &off)| *rest += off);
        let posed_from_rest = posed_from_rest(&rig, &state.pose);
        let joints: Vec<Vec3A> =
            posed_from_rest.iter().zip(&rig.rest_joints).map(|(a, &joint)| a.transform_point3a(joint)).collect();
        let world_from_parent = rig
            .parents
            .iter()
            .map(|parent| parent.map_or(Mat3A::IDENTITY, |parent| posed_from_rest[parent].matrix3))
            .collect();
        let vertices = rig.posed(&state.pose, &posed_from_rest);
        let mut normals = vec![Vec3A::ZERO; vertices.len()];
        vertex_normals(&vertices, &self.body.triangles, &mut normals);
        let joint_by_shape = match with_shape {
            false => Vec::new(),
            true => self.joint_directions.iter().map(|direction| carried(&rig, &posed_from_rest, direction)).collect(),
        };
        Posed { articulated: self, rig, posed_from_rest, joints, world_from_parent, vertices, normals, joint_by_shape }
    }

    /// The state after a step of the unknowns; β stays where `step` has no entries for it.
    pub fn moved(&self, state: &State, step: &[f64]) -> State {
        let mut next = state.clone();
        for (joint, rotation) in next.pose.rotations.iter_mut().enumerate() {
            let increment = Vec3::from_array(std::array::from_fn(|axis| step[3 * joint + axis] as f32));
            *rotation = (quat_from_axis_angle(increment) * *rotation).normalize();
        }
        let (pose, shape) = step.split_at(self.pose_unknowns());
        next.pose.translation +=
            Vec3::from_array(std::array::from_fn(|axis| pose[3 * self.joint_count() + axis] as f32));
        for (beta, &step) in next.betas.iter_mut().zip(shape) {
            *beta += step as f32;
        }
        next
    }

    /// Zero shape in the rest pose.
    pub fn rest(&self) -> State {
        State { betas: vec![0.0; self.shape_count], pose: Pose::rest(self.joint_count()) }
    }
}

/// Displacements of rest joints carried along the skeleton: how the posed joints move.
fn carried(rig: &Rig, posed_from_rest: &[Affine3A], direction: &[Vec3A]) -> Vec<Vec3A> {
    let mut moved: Vec<Vec3A> = Vec::with_capacity(direction.len());
    for (joint, parent) in rig.parents.iter().enumerate() {
        moved.push(match parent {
            None => direction[joint],
            Some(parent) => moved[*parent] + posed_from_rest[*parent].matrix3 * (direction[joint] - direction[*parent]),
        });
    }
    moved
}

impl Posed<'_> {
    /// A vector of the rest pose as `joint` turns it.
    pub fn turned(&self, joint: usize, vector: Vec3A) -> Vec3A {
        self.posed_from_rest[joint].matrix3 * vector
    }

    /// How the point with `weights` on `vertices` moves.
    pub fn motion(&self, vertices: &[u32], weights: &[f32]) -> Motion {
        let mut levers = vec![Vec3A::ZERO; self.joints.len()];
        let mut is_moved = vec![false; self.joints.len()];
        let mut by_shape = vec![Vec3A::ZERO; self.joint_by_shape.len()];
        for (&vertex, &share) in vertices.iter().zip(weights) {
            let vertex = vertex as usize;
            let skin = self.rig.skin.joints[vertex].iter().zip(&self.rig.skin.weights[vertex]);
            for (&influence, &weight) in skin {
                let weight = weight * share;
                if weight == 0.0 {
                    continue;
                }
                let influence = influence as usize;
                let carried = self.posed_from_rest[influence].transform_point3a(self.rig.rest[vertex]);
                self.add_levers(influence, carried, weight, &mut levers, &mut is_moved);
                for (component, sum) in by_shape.iter_mut().enumerate() {
                    let body = self.articulated.body;
                    let relative = body.shape_directions[component][vertex]
                        - self.articulated.joint_directions[component][influence];
                    let turned = self.posed_from_rest[influence].matrix3 * relative;
                    *sum += weight * (turned + self.joint_by_shape[component][influence]);
                }
            }
        }
        let levers = (0..levers.len()).filter(|&joint| is_moved[joint]).map(|joint| (joint, levers[joint])).collect();
        Motion { levers, by_shape }
    }

    /// How a point fixed to `joint`, at `position` in the world, moves with the pose.
    pub fn rigid_motion(&self, joint: usize, position: Vec3A) -> Motion {
        let mut levers = vec![Vec3A::ZERO; self.joints.len()];
        let mut is_moved = vec![false; self.joints.len()];
        self.add_levers(joint, position, 1.0, &mut levers, &mut is_moved);
        let levers = (0..levers.len()).filter(|&joint| is_moved[joint]).map(|joint| (joint, levers[joint])).collect();
        Motion { levers, by_shape: self.joint_by_shape.iter().map(|moved| moved[joint]).collect() }
    }

    fn add_levers(&self, joint: usize, point: Vec3A, weight: f32, levers: &mut [Vec3A], is_moved: &mut [bool]) {
        let mut ancestor = Some(joint);
        while let Some(joint) = ancestor {
            levers[joint] += weight * (point - self.joints[joint]);
            is_moved[joint] = true;
            ancestor = self.rig.parents[joint];
        }
    }

    /// The derivative of `direction`·x by the unknowns, as (unknown, value) pairs.
    pub fn row(&self, motion: &Motion, direction: Vec3A) -> Vec<(usize, f64)> {
        let mut row = Vec::with_capacity(3 * motion.levers.len() + 3 + motion.by_shape.len());
        for &(joint, lever) in &motion.levers {
            // direction·(ω × a) = ω·(a × direction), with ω turned from the parent's frame.
            let local = self.world_from_parent[joint].transpose() * lever.cross(direction);
            row.extend((0..3).map(|axis| (3 * joint + axis, f64::from(local[axis]))));
        }
        let translation = 3 * self.joints.len();
        row.extend((0..3).map(|axis| (translation + axis, f64::from(direction[axis]))));
        let shape = motion.by_shape.iter().enumerate();
        row.extend(shape.map(|(component, &moved)| (translation + 3 + component, f64::from(direction.dot(moved)))));
        row
    }
}

/// J_l⁻¹(r): how the logarithm r of a rotation grows when the rotation is multiplied from the left, log(exp(ω) exp(r)) ≈ r + J_l⁻¹(r) ω.
pub fn left_jacobian_inverse(logarithm: Vec3) -> Mat3A {
    let angle = logarithm.length();
    let cross = Mat3A::from_cols(
        Vec3A::new(0.0, logarithm.z, -logarithm.y),
        Vec3A::new(-logarithm.z, 0.0, logarithm.x),
        Vec3A::new(logarithm.y, -logarithm.x, 0.0),
    );
    let squared = match angle {
        angle if angle < 1e-2 => 1.0 / 12.0,
        angle => (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle),
    };
    Mat3A::IDENTITY - cross * 0.5 + cross * cross * squared
}

/// The logarithm of the rotation that leads from `from` to `to` (to = exp(r) from), radians.
pub fn difference(to: Quat, from: Quat) -> Vec3 {
    crease::rotation::axis_angle_from_quat(to * from.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{bent_pose, voxel_person};

    fn state() -> State {
        let mut pose = bent_pose();
        pose.rotations[0] = Quat::from_rotation_y(0.4) * pose.rotations[0];
        State { betas: vec![0.3, -0.5], pose }
    }

    #[test]
    fn rows_agree_with_finite_differences() {
        let body = voxel_person();
        let articulated = ArticulatedBody::new(&body, 2);
        let state = state();
        let posed = articulated.pose(&state, true);
        let unknowns = articulated.pose_unknowns() + articulated.shape_count();
        let direction = Vec3A::new(0.5, -0.7, 0.3);
        const STEP: f64 = 1e-3;
        for triangle in articulated.triangles().iter().step_by(37) {
            let weights = [0.2, 0.3, 0.5];
            let at = |vertices: &[Vec3A]| -> Vec3A {
                triangle.iter().zip(weights).map(|(&v, w)| vertices[v as usize] * w).sum()
            };
            let mut row = vec![0.0; unknowns];
            for (unknown, value) in posed.row(&posed.motion(triangle, &weights), direction) {
                row[unknown] += value;
            }
            for unknown in 0..unknowns {
                let [below, above] = [-STEP, STEP].map(|step| {
                    let mut steps = vec![0.0; unknowns];
                    steps[unknown] = step;
                    at(&articulated.pose(&articulated.moved(&state, &steps), false).vertices)
                });
                let difference = f64::from((above - below).dot(direction)) / (2.0 * STEP);
                assert!((row[unknown] - difference).abs() < 2e-3, "unknown {unknown}: {} {difference}", row[unknown]);
            }
        }
    }

    #[test]
    fn joints_move_as_their_rows_say() {
        let body = voxel_person();
        let articulated = ArticulatedBody::new(&body, 2);
        let state = state();
        let posed = articulated.pose(&state, true);
        let unknowns = articulated.pose_unknowns() + articulated.shape_count();
        for joint in [0, 7, 20] {
            let mut row = vec![0.0; unknowns];
            for (unknown, value) in posed.row(&posed.rigid_motion(joint, posed.joints[joint]), Vec3A::Y) {
                row[unknown] += value;
            }
            for unknown in 0..unknowns {
                let [below, above] = [-1e-3, 1e-3].map(|step| {
                    let mut steps = vec![0.0; unknowns];
                    steps[unknown] = step;
                    articulated.pose(&articulated.moved(&state, &steps), false).joints[joint].y
                });
                let difference = f64::from(above - below) / 2e-3;
                assert!((row[unknown] - difference).abs() < 2e-3, "joint {joint}, unknown {unknown}");
            }
        }
    }

    #[test]
    fn logarithms_grow_as_their_jacobian_says() {
        for logarithm in [Vec3::ZERO, Vec3::new(1e-3, 0.0, 2e-3), Vec3::new(0.4, -1.1, 0.3), Vec3::new(-1.5, 0.2, 1.7)]
        {
            let jacobian = left_jacobian_inverse(logarithm);
            let rotation = quat_from_axis_angle(logarithm);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let [below, above] = [-1e-2, 1e-2]
                    .map(|step| crease::rotation::axis_angle_from_quat(quat_from_axis_angle(axis * step) * rotation));
                let difference = (above - below) / 2e-2;
                assert!((jacobian * Vec3A::from(axis) - Vec3A::from(difference)).length() < 2e-3, "{logarithm}");
            }
        }
    }
}
