//! Whole frames against `animate`.

use super::super::{GpuAnimator, GpuError, Timestamps};
use super::{Gpu, gpu, largest_distance};
use crate::animate::{Animator, Options, Stage};
use crate::avatar::Avatar;
use crate::body::Pose;
use crate::fixture::{bent_pose, compact_avatar, plain_avatar};
use crate::mesh::vertex_normals;
use crate::solver::Stop;
use crease_posing::surface_vertex::unpack_normal;
use glam::{Quat, Vec3A};
use std::sync::Arc;
use wgpu::Buffer;

/// Metres: what the default tolerance promises on the CPU (0.02 mm), on both sides.
const TOLERANCE: f32 = 4e-5;

struct Both {
    gpu: &'static Gpu,
    cpu: Animator,
    animator: GpuAnimator,
    vertices: Buffer,
}

impl Both {
    fn new(avatar: Avatar) -> Self {
        let gpu = gpu();
        let cpu = Animator::new(Arc::new(avatar)).unwrap();
        let vertices = gpu.vertices(cpu.subdivision().vertex_count(cpu.subdivision().level_count()));
        let animator = GpuAnimator::new(&gpu.device, &gpu.queue, &cpu, &vertices).unwrap();
        Self { gpu, cpu, animator, vertices }
    }

    fn on_gpu(&mut self, pose: &Pose, options: &Options) -> Vec<Vec3A> {
        self.animator.animate(pose, options, None);
        self.gpu.run([], &self.vertices)
    }

    fn on_cpu(&mut self, pose: &Pose, options: &Options) -> Vec<Vec3A> {
        self.cpu.animate(pose, options).to_vec()
    }

    /// The largest distance between the two, on the level that the options ask for.
    fn error(&mut self, pose: &Pose, options: &Options) -> f32 {
        let expected = self.on_cpu(pose, options);
        largest_distance(&self.on_gpu(pose, options)[..expected.len()], &expected)
    }
}

/// The bent pose after `time` seconds of a lively movement.
fn moving_pose(time: f32) -> Pose {
    let mut pose = bent_pose();
    pose.rotations[0] *= Quat::from_rotation_y(0.8 * time);
    pose.rotations[1] *= Quat::from_rotation_x((5.0 * time).sin());
    pose.rotations[16] *= Quat::from_rotation_z((6.0 * time).cos());
    pose
}

#[test]
fn every_stage_agrees_with_the_cpu() {
    for avatar in [compact_avatar(), plain_avatar()] {
        let mut both = Both::new(avatar);
        let detailed = Options::default();
        for pose in [bent_pose(), Pose::rest(24)] {
            for stage in [Stage::Body, Stage::Base] {
                let error = both.error(&pose, &Options { stage, ..detailed });
                assert!(error < 2e-6, "{stage:?}: {error} m");
            }
            for detail in [0.0, 1.0, 2.0] {
                let error = both.error(&pose, &Options { detail, ..detailed });
                assert!(error < TOLERANCE, "detail {detail}: {error} m");
            }
        }
        let wrong = both.on_cpu(&Pose::rest(24), &detailed);
        let right = both.on_gpu(&bent_pose(), &detailed);
        assert!(largest_distance(&wrong, &right) > 0.1, "another pose is told apart");
        let few = both.error(&bent_pose(), &Options { stop: Stop::Iterations(1), detail: 2.0, ..detailed });
        let one = Options { stop: Stop::Iterations(1), detail: 2.0, ..detailed };
        let exact = both.on_cpu(&bent_pose(), &Options { detail: 2.0, ..detailed });
        let unfinished = largest_distance(&both.on_gpu(&bent_pose(), &one), &exact);
        assert!(unfinished > 2.0 * TOLERANCE, "one iteration is too few: {unfinished} m, {few} m from the CPU's");
    }
}

#[test]
fn normals_agree_with_the_cpu() {
    let mut both = Both::new(compact_avatar());
    for level in both.cpu.levels() {
        let options = Options { level, ..Options::default() };
        both.on_gpu(&bent_pose(), &options);
        let packed: Vec<[u32; 4]> = both.gpu.read(&both.vertices);
        let positions = both.on_cpu(&bent_pose(), &options);
        let found: Vec<Vec3A> =
            packed[..positions.len()].iter().map(|vertex| unpack_normal(vertex[3]).into()).collect();
        let mut normals = positions.clone();
        vertex_normals(&positions, both.cpu.subdivision().triangles(level), &mut normals);
        let error = largest_distance(&found, &normals);
        assert!(error < 5e-3, "level {level}: {error}");
    }
}

#[test]
fn coarser_levels_agree_with_the_cpu() {
    let mut both = Both::new(compact_avatar());
    let (coarsest, finest) = both.cpu.levels().into_inner();
    assert!(coarsest < finest, "the fixture has a coarser level");
    for (level, solve_level) in [(finest, coarsest), (coarsest, coarsest), (coarsest, finest)] {
        for stage in [Stage::Body, Stage::Base, Stage::Detailed] {
            let error = both.error(&bent_pose(), &Options { stage, level, solve_level, ..Options::default() });
            assert!(error < TOLERANCE, "{stage:?} on {level}, solved on {solve_level}: {error} m");
        }
    }
    let finer = both.on_cpu(&bent_pose(), &Options::default());
    let coarser = both.on_gpu(&bent_pose(), &Options { solve_level: coarsest, ..Options::default() });
    let apart = largest_distance(&finer, &coarser);
    assert!(apart > 2.0 * TOLERANCE, "the levels differ, and the test would notice: {apart} m");
}

#[test]
fn what_is_not_finite_is_counted_and_never_shown() {
    let mut both = Both::new(compact_avatar());
    let good = both.on_gpu(&bent_pose(), &Options::default());
    let warm = Options { warm_start: true, ..Options::default() };
    let shown = both.on_gpu(&bent_pose(), &Options { detail: f32::INFINITY, ..warm });
    assert!(shown.iter().all(|position| position.is_finite()), "the last places stay");
    assert_eq!(both.animator.take_not_finite(), good.len(), "all were lost");
    // The failed solve is no guess, nor does it spoil the base.
    let error = both.error(&bent_pose(), &Options { detail: f32::INFINITY, stage: Stage::Base, ..warm });
    assert!(error < 2e-6, "{error} m");
    both.on_gpu(&bent_pose(), &Options { detail: f32::INFINITY, ..warm });
    for detail in [1.0, 2.0] {
        let error = both.error(&bent_pose(), &Options { detail, ..warm });
        assert!(error < TOLERANCE, "{error} m");
    }
    both.on_gpu(&bent_pose(), &warm);
    both.animator.take_not_finite();
    both.on_gpu(&bent_pose(), &warm);
    assert_eq!(both.animator.take_not_finite(), 0, "told once");
}

#[test]
fn warm_frames_stay_within_the_tolerance_and_jumps_start_anew() {
    let mut both = Both::new(compact_avatar());
    let warm = Options { warm_start: true, ..Options::default() };
    for frame in 0..12 {
        // The eighth frame is a seek to elsewhere.
        let time = if frame < 8 { frame as f32 / 60.0 } else { 3.0 + frame as f32 / 60.0 };
        let pose = moving_pose(time);
        let found = both.on_gpu(&pose, &warm);
        let expected = both.on_cpu(&pose, &Options { stop: Stop::Tolerance(1e-6), ..Options::default() });
        let error = largest_distance(&found, &expected);
        assert!(error < TOLERANCE, "frame {frame}: {error} m");
    }
    // With the same few iterations a warm frame is nearer than a cold one.
    let few = |warm_start| Options { stop: Stop::Iterations(2), warm_start, ..Options::default() };
    let expected = both.on_cpu(&moving_pose(3.2), &Options { stop: Stop::Tolerance(1e-6), ..Options::default() });
    let [cold, warmed] = [false, true].map(|warm_start| {
        both.on_gpu(&moving_pose(3.19), &Options::default());
        largest_distance(&both.on_gpu(&moving_pose(3.2), &few(warm_start)), &expected)
    });
    assert!(warmed < 0.5 * cold, "{warmed} after {cold}");
}

#[test]
fn a_frame_repeats_to_the_last_bit() {
    let mut both = Both::new(compact_avatar());
    let first = both.on_gpu(&bent_pose(), &Options::default());
    both.on_gpu(&Pose::rest(24), &Options::default());
    assert_eq!(both.on_gpu(&bent_pose(), &Options::default()), first);
}

#[test]
fn cost_is_counted() {
    let both = Both::new(compact_avatar());
    let cost = |iterations, stage| {
        both.animator.cost(&Options { stage, stop: Stop::Iterations(iterations), ..Options::default() })
    };
    let [one, two, three] = [1, 2, 3].map(|count| cost(count, Stage::Detailed));
    assert_eq!(three.dispatches - two.dispatches, two.dispatches - one.dispatches);
    assert_eq!(three.dispatches - two.dispatches, 30, "of one iteration on three levels");
    assert!(cost(1, Stage::Base).dispatches < 10 && one.upload_bytes < 5000 && one.operations == 0);
    assert!(Both::new(plain_avatar()).animator.cost(&Options::default()).operations > 0);
}

#[test]
fn stages_are_timed_where_the_adapter_can() {
    let mut both = Both::new(compact_avatar());
    let Some(mut timestamps) = Timestamps::new(&both.gpu.device, &both.gpu.queue) else { return };
    both.animator.animate(&bent_pose(), &Options::default(), Some(&mut timestamps));
    let (sender, receiver) = std::sync::mpsc::channel();
    timestamps.read(move |times| sender.send(times).unwrap());
    both.gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let times = receiver.recv().unwrap();
    let stages: Vec<&str> = times.iter().map(|time| time.stage).collect();
    assert_eq!(stages, ["deformation", "base", "laplacian", "residual", "solve", "surface"]);
    assert!(times.iter().all(|time| time.milliseconds.is_finite()));
}

#[test]
fn software_adapters_are_refused_by_name() {
    let info = |device_type| wgpu::AdapterInfo {
        name: "SwiftShader".into(),
        ..wgpu::AdapterInfo::new(device_type, wgpu::Backend::BrowserWebGpu)
    };
    let error = GpuAnimator::check_adapter(&info(wgpu::DeviceType::Cpu)).unwrap_err();
    assert_eq!(error, GpuError::Software { name: "SwiftShader".into() });
    assert_eq!(GpuAnimator::check_adapter(&info(wgpu::DeviceType::Other)), Ok(()));
}
