//! Poses that are off by a known amount come nearer to the truth once the clothes are known, or while they are learnt.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, open, write_sequence};
use crease::body::{Body, Pose};
use crease::rotation::quat_from_axis_angle;
use crease_trainer::context::{DeformationTrainer, Sample, TrainContext};
use crease_trainer::options::TrainOptions;
use crease_trainer::plain::PlainDeformation;
use crease_trainer::progress::Progress;
use crease_trainer::refinement::{RefinementOptions, refine_poses};
use crease_trainer::registration::{Accuracy, compare};
use crease_trainer::sequence::BodyParameters;
use glam::Vec3;

/// Joints that are turned away, and about which axis.
const TURNED: [(usize, Vec3); 5] = [(0, Vec3::Y), (1, Vec3::X), (2, Vec3::Z), (16, Vec3::Z), (17, Vec3::Y)];

/// A pose beside the true one: other in each frame, and right on the mean.
fn beside(pose: &Pose, frame: usize) -> Pose {
    let mut pose = pose.clone();
    let phase = |offset: usize| (std::f32::consts::TAU * (frame + offset) as f32 / FRAME_COUNT as f32).sin();
    for (offset, (joint, axis)) in TURNED.into_iter().enumerate() {
        pose.rotations[joint] = quat_from_axis_angle(0.12 * phase(offset) * axis) * pose.rotations[joint];
    }
    pose.translation += 0.02 * Vec3::new(phase(0), phase(2), phase(4));
    pose
}

struct Case {
    body: Body,
    truth: BodyParameters,
    context: TrainContext,
    _directory: Directory,
}

fn case(name: &str, change: impl Fn(&mut TrainOptions)) -> Case {
    let directory = Directory::new(name);
    let body = write_sequence(&directory.0);
    let mut sequence = open(&directory.0).unwrap();
    let truth = BodyParameters { betas: sequence.betas.clone(), poses: sequence.poses.clone() };
    sequence.poses = truth.poses.iter().enumerate().map(|(frame, pose)| beside(pose, frame)).collect();
    let mut options = TrainOptions::compact();
    options.compact.base_fit.smoothness = vec![3.0, 1.0];
    options.refinement.round_count = 2;
    change(&mut options);
    let samples = (0..FRAME_COUNT).filter(|frame| frame % 3 != 1).map(|frame| Sample { sequence: 0, frame }).collect();
    let context = TrainContext::new(body.clone(), vec![sequence], samples, options, Progress::Silent).unwrap();
    Case { body, truth, context, _directory: directory }
}

impl Case {
    fn accuracy(&self) -> Accuracy {
        let sequence = &self.context.sequences[0];
        let found = BodyParameters { betas: sequence.betas.clone(), poses: sequence.poses.clone() };
        compare(&self.body, &found, &self.truth, None).unwrap()
    }
}

#[test]
fn refined_poses_are_nearer_to_the_truth() {
    let mut case = case("refinement", |_| ());
    let before = case.accuracy();
    assert!(before.joints_mm > 15.0, "{before:?}");
    refine_poses(&mut case.context).unwrap();
    let after = case.accuracy();
    assert!(after.joints_mm < 0.5 * before.joints_mm, "{} mm, before {} mm", after.joints_mm, before.joints_mm);
    // Frames that are not trained on, too.
    for frame in [1, 4] {
        assert!(after.frames_mm[frame] < 0.6 * before.frames_mm[frame], "{after:?} before {before:?}");
    }
}

#[test]
fn poses_that_are_held_or_not_refined_stay() {
    let mut held = case("refinement-held", |options| {
        options.refinement.rotation_weight = 1e3;
        options.refinement.translation_weight = 1e3;
    });
    let before = held.accuracy();
    refine_poses(&mut held.context).unwrap();
    assert!((held.accuracy().joints_mm - before.joints_mm).abs() < 0.01 * before.joints_mm);
    let mut none = case("refinement-none", |options| options.refinement.round_count = 0);
    refine_poses(&mut none.context).unwrap();
    assert_eq!(none.accuracy(), before);
}

/// The paper's form, reduced to what a processor does in seconds, with poses that are learnt beside f_d.
fn joint(options: &mut TrainOptions) {
    let compact = std::mem::replace(options, TrainOptions::paper());
    options.refinement = RefinementOptions { round_count: 0, learning_rate: 1e-3, ..compact.refinement };
    options.level_count = 1;
    options.anchor_count = 60;
    options.frequency_count = 4;
    options.deformation.network.width = 32;
    options.deformation.network.epoch_count = 300;
    options.deformation.frames_a_step = 4;
    options.deformation.points_a_frame = 1_000;
}

#[test]
fn poses_that_are_learnt_with_f_d_come_nearer_to_the_truth() {
    let mut case = case("refinement-joint", joint);
    let before = case.accuracy();
    PlainDeformation.train(&case.context).unwrap().adopt(&mut case.context);
    let after = case.accuracy();
    let trained: Vec<usize> = case.context.samples.iter().map(|sample| sample.frame).collect();
    let mean = |accuracy: &Accuracy| trained.iter().map(|&frame| accuracy.frames_mm[frame]).sum::<f64>();
    assert!(mean(&after) < 0.5 * mean(&before), "{after:?} before {before:?}");
    // Frames that are not trained on stay.
    for frame in [1, 4] {
        assert_eq!(after.frames_mm[frame], before.frames_mm[frame]);
    }
}
