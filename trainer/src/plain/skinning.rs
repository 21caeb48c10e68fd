//! Linear blend skinning as burn sees it (paper Eq. lbs): gradients flow from posed vertices to offsets and to poses.
//!
//! A pose is one that is given, and small turns of its joints. A turn ω, in the frame of the joint's parent, is the rotation by 2 atan(|ω|/2)
//! about ω: to first order |ω| radians, and without a square root that has no derivative at nothing.

use super::rows_of;
use burn::tensor::{Device, Tensor, TensorData};
use crease::body::{Pose, Rig};
use glam::{Mat3, Quat, Vec3, Vec3A};

/// A body that can be posed on a device. Host twin: `PosedSurface`, level 0.
pub(super) struct Skinning {
    parents: Vec<Option<usize>>,
    /// Each joint from its parent in the rest pose, the root from the origin: (1, 3, 1), metres.
    from_parents: Vec<Tensor<3>>,
    /// Rest joints: (1, 3, 1), metres.
    rest_joints: Vec<Tensor<3>>,
    /// Skinning weights: (1, vertices, joints).
    weights: Tensor<3>,
    /// Rest vertices: (1, vertices, 3), metres.
    rest: Tensor<3>,
    /// Pose blend shapes: (9 (joints − 1), 3 vertices).
    pose_directions: Option<Tensor<2>>,
    /// What makes of a vector h the matrix of h ×, row-major: (3, 9).
    cross: Tensor<2>,
}

impl Skinning {
    pub(super) fn new(rig: &Rig, device: &Device) -> Self {
        let column = |point: Vec3A| rows_of(std::iter::once(point), device).reshape([1, 3, 1]);
        let from_parent = |(&joint, parent): (&Vec3A, &Option<usize>)| {
            column(parent.map_or(joint, |parent| joint - rig.rest_joints[parent]))
        };
        let (vertex_count, joint_count) = (rig.rest.len(), rig.parents.len());
        let mut weights = vec![0.0; vertex_count * joint_count];
        let influences = rig.skin.joints.iter().zip(&rig.skin.weights);
        for (row, (joints, values)) in weights.chunks_exact_mut(joint_count).zip(influences) {
            joints.iter().zip(values).for_each(|(&joint, weight)| row[usize::from(joint)] += weight);
        }
        let directions = rig.pose_directions.as_ref().map(|directions| {
            let rows = rows_of(directions.iter().flatten().copied(), device);
            rows.reshape([directions.len(), 3 * vertex_count])
        });
        #[rustfmt::skip]
        let cross: Vec<f32> = vec![
            0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0,
            0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0,
            0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        ];
        Self {
            parents: rig.parents.clone(),
            from_parents: rig.rest_joints.iter().zip(&rig.parents).map(from_parent).collect(),
            rest_joints: rig.rest_joints.iter().map(|&joint| column(joint)).collect(),
            weights: Tensor::from_data(TensorData::new(weights, [1, vertex_count, joint_count]), device),
            rest: rows_of(rig.rest.iter().copied(), device).reshape([1, vertex_count, 3]),
            pose_directions: directions,
            cross: Tensor::from_data(TensorData::new(cross, [3, 9]), device),
        }
    }

    /// Unknowns of a frame's pose: a turn of each joint, then a step of the translation, metres.
    pub(super) fn unknowns(joint_count: usize) -> usize {
        3 * joint_count + 3
    }

    /// `pose` after the steps of [`Self::unknowns`].
    pub(super) fn moved(pose: &Pose, steps: &[f32]) -> Pose {
        let (turns, translation) = steps.split_at(3 * pose.rotations.len());
        let turn = |turn: &[f32]| {
            let half = 0.5 * Vec3::from_slice(turn);
            Quat::from_xyzw(half.x, half.y, half.z, 1.0).normalize()
        };
        let rotations = pose.rotations.iter().zip(turns.chunks_exact(3));
        Pose {
            rotations: rotations.map(|(&rotation, step)| (turn(step) * rotation).normalize()).collect(),
            translation: pose.translation + Vec3::from_slice(translation),
        }
    }

    /// Posed vertices of the frames of `poses` after `steps` (frames, [`Self::unknowns`]): (frames · vertices, 3), metres. `offsets` (frames ·
    /// vertices, 3) are metres in the rest pose's frame.
    pub(super) fn posed(&self, poses: &[Pose], steps: Option<Tensor<2>>, offsets: Tensor<2>) -> Tensor<2> {
        let device = offsets.device();
        let (frame_count, joint_count) = (poses.len(), self.parents.len());
        let [_, vertex_count, _] = self.rest.dims();
        let (rotations, translation) = self.locals(poses, steps, &device);

        let mut rest = self.rest.clone() + offsets.reshape([frame_count, vertex_count, 3]);
        if let Some(directions) = &self.pose_directions {
            let bent = rotations.clone().slice([0..frame_count, 1..joint_count]) - identity(&device).unsqueeze::<4>();
            let blended = bent.reshape([frame_count, 9 * (joint_count - 1)]).matmul(directions.clone());
            rest = rest + blended.reshape([frame_count, vertex_count, 3]);
        }

        // Along the skeleton: each joint's rotation in the world, and where the joint is.
        let mut posed: Vec<(Tensor<3>, Tensor<3>)> = Vec::with_capacity(joint_count);
        let mut from_rest: Vec<Tensor<3>> = Vec::with_capacity(joint_count);
        for (joint, parent) in self.parents.iter().enumerate() {
            let local = rotations.clone().slice([0..frame_count, joint..joint + 1]).reshape([frame_count, 3, 3]);
            let (rotation, place) = match *parent {
                None => (local, self.from_parents[joint].clone() + translation.clone()),
                Some(parent) => {
                    let (turned, place) = &posed[parent];
                    let carried = turned.clone().matmul(self.from_parents[joint].clone());
                    (turned.clone().matmul(local), place.clone() + carried)
                }
            };
            let at_rest = rotation.clone().matmul(self.rest_joints[joint].clone());
            let columns = Tensor::cat(vec![rotation.clone(), place.clone() - at_rest], 2);
            from_rest.push(columns.reshape([frame_count, 1, 12]));
            posed.push((rotation, place));
        }

        let blended = self.weights.clone().matmul(Tensor::cat(from_rest, 1));
        let count = frame_count * vertex_count;
        let blended = blended.reshape([count, 3, 4]);
        let matrices = blended.clone().slice([0..count, 0..3, 0..3]);
        let translations = blended.slice([0..count, 0..3, 3..4]);
        ((matrices * rest.reshape([count, 1, 3])).sum_dim(2) + translations).reshape([count, 3])
    }

    /// Rotations of joints against their parents (frames, joints, 3, 3), row-major, and translations (frames, 3, 1).
    fn locals(&self, poses: &[Pose], steps: Option<Tensor<2>>, device: &Device) -> (Tensor<4>, Tensor<3>) {
        let (frame_count, joint_count) = (poses.len(), self.parents.len());
        // glam's columns of the transpose are the rows.
        let rows = |&rotation: &Quat| Mat3::from_quat(rotation).transpose().to_cols_array();
        let given: Vec<f32> = poses.iter().flat_map(|pose| pose.rotations.iter().flat_map(rows)).collect();
        let given = Tensor::<3>::from_data(TensorData::new(given, [frame_count * joint_count, 3, 3]), device);
        let translation: Vec<f32> = poses.iter().flat_map(|pose| pose.translation.to_array()).collect();
        let translation = Tensor::<3>::from_data(TensorData::new(translation, [frame_count, 3, 1]), device);
        let shape = [frame_count, joint_count, 3, 3];
        let Some(steps) = steps else { return (given.reshape(shape), translation) };
        let turns = steps.clone().slice([0..frame_count, 0..3 * joint_count]);
        let steps = steps.slice([0..frame_count, 3 * joint_count..3 * joint_count + 3]);
        let turned = self.turns(turns.reshape([frame_count * joint_count, 3])).matmul(given);
        (turned.reshape(shape), translation + steps.reshape([frame_count, 3, 1]))
    }

    /// Rotations (N, 3, 3) of turns ω (N, 3): I + 2 (h× + h hᵀ − |h|² I) / (1 + |h|²), h = ω / 2 (Cayley, Rodrigues).
    fn turns(&self, turns: Tensor<2>) -> Tensor<3> {
        let [count, _] = turns.dims();
        let half = turns * 0.5;
        let squared = half.clone().square().sum_dim(1).reshape([count, 1, 1]);
        let cross = half.clone().matmul(self.cross.clone()).reshape([count, 3, 3]);
        let outer = half.clone().reshape([count, 3, 1]) * half.reshape([count, 1, 3]);
        let one = identity(&squared.device());
        let inner = cross + outer - squared.clone() * one.clone();
        one + inner * (squared + 1.0).recip() * 2.0
    }
}

/// (1, 3, 3).
fn identity(device: &Device) -> Tensor<3> {
    Tensor::from_data(TensorData::new(Mat3::IDENTITY.to_cols_array().to_vec(), [1, 3, 3]), device)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plain::{numbers, scalar, test_devices};
    use crate::sampling::random_points;
    use crease::animate::PosedSurface;
    use crease::fixture::bent_pose;
    use crease::mesh::{Scheme, Subdivision};

    /// A rig with pose blend shapes, and two poses of it.
    fn rig() -> (Rig, Vec<crease::mesh::Triangle>, [Pose; 2]) {
        let file = include_bytes!("../../../tests/fixtures/tiny_plain.glb");
        let avatar = crease::avatar::Avatar::read(file, "tiny_plain.glb").unwrap();
        let mut rig = avatar.rig;
        let shapes = 9 * (rig.parents.len() - 1);
        let direction = |seed: usize| random_points(rig.rest.len(), 2e-3, seed as u64);
        rig.pose_directions = Some((0..shapes).map(direction).collect());
        let bent = bent_pose();
        let other = Skinning::moved(&bent, &steps(bent.rotations.len(), 9));
        (rig, avatar.triangles, [bent, other])
    }

    fn flat(points: &[Vec3A]) -> Vec<f32> {
        points.iter().flat_map(|point| point.to_array()).collect()
    }

    fn steps(joint_count: usize, seed: u64) -> Vec<f32> {
        flat(&random_points(joint_count + 1, 0.4, seed))
    }

    fn tensor(values: &[f32], rows: usize, device: &Device) -> Tensor<2> {
        Tensor::from_data(TensorData::new(values.to_vec(), [rows, values.len() / rows]), device)
    }

    #[test]
    fn vertices_are_where_the_runtime_poses_them() {
        let (rig, triangles, poses) = rig();
        let joint_count = rig.parents.len();
        let subdivision = Subdivision::new(rig.rest.len(), &triangles, 0);
        let offsets = random_points(2 * rig.rest.len(), 0.05, 1);
        let taken = [steps(joint_count, 2), steps(joint_count, 3)];
        for (choice, device) in test_devices() {
            let skinning = Skinning::new(&rig, &device);
            let posed = skinning.posed(
                &poses,
                Some(tensor(&taken.concat(), 2, &device)),
                tensor(&flat(&offsets), offsets.len(), &device),
            );
            let found = numbers(posed);
            for (frame, pose) in poses.iter().enumerate() {
                let pose = Skinning::moved(pose, &taken[frame]);
                let mut surface = PosedSurface::new(&subdivision);
                let own = &offsets[frame * rig.rest.len()..][..rig.rest.len()];
                surface.pose(&rig, own, &pose, &subdivision, Scheme::Loop, 0);
                let found = &found[3 * frame * rig.rest.len()..];
                for (expected, found) in surface.positions(0).iter().zip(found.chunks_exact(3)) {
                    let error = expected.distance(Vec3A::from_slice(found));
                    assert!(error < 2e-5, "{choice:?}, frame {frame}: {error} m");
                }
            }
        }
    }

    #[test]
    fn no_steps_are_the_poses_themselves() {
        let (rig, _, poses) = rig();
        let (_, device) = test_devices().swap_remove(0);
        let skinning = Skinning::new(&rig, &device);
        let offsets = || tensor(&vec![0.0; 3 * rig.rest.len()], rig.rest.len(), &device);
        let none = numbers(skinning.posed(&poses[..1], None, offsets()));
        let nothing = vec![0.0; Skinning::unknowns(rig.parents.len())];
        let still = numbers(skinning.posed(&poses[..1], Some(tensor(&nothing, 1, &device)), offsets()));
        assert!(none.iter().zip(&still).all(|(a, b)| (a - b).abs() < 1e-6));
        let other = numbers(skinning.posed(&poses[1..], None, offsets()));
        assert!(none.iter().zip(&other).any(|(a, b)| (a - b).abs() > 0.1));
    }

    #[test]
    fn gradients_reach_every_joint_and_agree_with_differences() {
        let (rig, _, poses) = rig();
        let unknowns = Skinning::unknowns(rig.parents.len());
        let wanted = flat(&random_points(rig.rest.len(), 1.0, 4));
        for (choice, device) in test_devices() {
            let skinning = Skinning::new(&rig, &device);
            let energy = |steps: Tensor<2>| {
                let offsets = tensor(&vec![0.01; 3 * rig.rest.len()], rig.rest.len(), &device);
                let posed = skinning.posed(&poses[..1], Some(steps), offsets);
                (posed - tensor(&wanted, rig.rest.len(), &device)).square().mean()
            };
            let start = steps(rig.parents.len(), 5);
            let leaf = tensor(&start, 1, &device).require_grad();
            let gradients = energy(leaf.clone()).backward();
            let gradient = numbers(leaf.grad(&gradients).unwrap());
            let largest = gradient.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
            assert_eq!(gradient.len(), unknowns);
            for entry in (0..unknowns).step_by(5).chain(unknowns - 3..unknowns) {
                let [below, above] = [-1e-2, 1e-2].map(|step| {
                    let mut moved = start.clone();
                    moved[entry] += step;
                    scalar(energy(tensor(&moved, 1, &device)))
                });
                let error = gradient[entry] - (above - below) / 2e-2;
                assert!(error.abs() < 0.01 * largest, "{choice:?}, unknown {entry}: {error} of {largest}");
            }
        }
    }
}
