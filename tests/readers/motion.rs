//! Motions in the layouts of AIST++, AMASS and SMPL-X.

use crate::fixtures::{Arrays, MOTIONS, angles, motion};
use crease::motion::Motion;
use crease::numpy::{Array, ReadError};
use crease::rotation::{axis_angle_from_quat, quat_from_axis_angle};
use glam::{Quat, Vec3};

fn assert_rotation(rotation: Quat, axis_angle: [f32; 3]) {
    // angle_between loses small angles in its arc cosine.
    let off = axis_angle_from_quat(rotation * quat_from_axis_angle(axis_angle.into()).inverse()).length();
    assert!(off < 1e-5, "{off} rad off {axis_angle:?}");
}

#[test]
fn reads_aistpp_pickles_in_metres() {
    for (name, bytes) in MOTIONS {
        let error = Motion::read(bytes, name, None).unwrap_err();
        assert_eq!((error.file.as_str(), error.field.as_str()), (name, "frames_per_second"));
        let motion = Motion::read(bytes, name, Some(60.0)).unwrap();
        assert_eq!((motion.poses.len(), motion.frames_per_second), (3, 60.0));
        assert!(motion.notes.is_empty(), "{:?}", motion.notes);
        for (t, pose) in motion.poses.iter().enumerate() {
            let t = t as f32;
            assert_eq!(pose.rotations.len(), 24);
            assert_rotation(pose.rotations[0], [t, t + 0.01, t + 0.02]);
            assert_rotation(pose.rotations[23], [t + 0.69, t + 0.70, t + 0.71]);
            // In the file 50 (t + axis), 100 to the metre.
            assert!((pose.translation - 0.5 * Vec3::new(t, t + 1.0, t + 2.0)).length() < 1e-6);
        }
    }
}

#[test]
fn reads_amass_and_its_rate() {
    let motion_read = Motion::read(&motion(2, 72).npz(), "walk.npz", None).unwrap();
    assert_eq!((motion_read.poses.len(), motion_read.frames_per_second), (2, 120.0));
    assert_rotation(motion_read.poses[1].rotations[23], [0.169, 0.170, 0.171]);
    assert_eq!(motion_read.poses[1].translation, Vec3::new(3.0, 4.0, 5.0));
    assert!(motion_read.notes.is_empty());

    let integer_rate = Array::new(&[1], vec![30i64]);
    let newer = motion(2, 72).without("mocap_framerate").with("mocap_frame_rate", integer_rate);
    assert_eq!(Motion::read(&newer.npz(), "walk.npz", None).unwrap().frames_per_second, 30.0);
    assert_eq!(Motion::read(&newer.npz(), "walk.npz", Some(50.0)).unwrap().frames_per_second, 50.0);
}

#[test]
fn wider_skeletons_keep_the_shared_joints_and_say_so() {
    for width in [66, 156, 165] {
        let motion = Motion::read(&motion(2, width).npz(), "walk.npz", None).unwrap();
        let pose = &motion.poses[1];
        assert_eq!(pose.rotations.len(), 24);
        assert_rotation(pose.rotations[21], [0.163, 0.164, 0.165]);
        assert_eq!(pose.rotations[22..], [Quat::IDENTITY; 2], "hands at rest");
        assert!(motion.notes[0].contains("22"), "{:?}", motion.notes);
    }
}

/// A motion in SMPL-X's layout.
fn smplx(frames: usize, body_width: usize) -> Arrays {
    Arrays(vec![
        ("global_orient", angles(frames, 3)),
        ("body_pose", angles(frames, body_width)),
        ("transl", Array::new(&[frames, 3], vec![1.0f32; 3 * frames])),
    ])
}

#[test]
fn reads_root_and_body_apart() {
    for width in [63, 69] {
        let motion = Motion::read(&smplx(2, width).npz(), "walk.npz", Some(30.0)).unwrap();
        let pose = &motion.poses[1];
        assert_rotation(pose.rotations[0], [0.1, 0.101, 0.102]);
        assert_rotation(pose.rotations[1], [0.1, 0.101, 0.102]);
        assert_rotation(pose.rotations[21], [0.160, 0.161, 0.162]);
        assert_eq!(pose.rotations[23] == Quat::IDENTITY, width == 63);
        assert_eq!(motion.notes.len(), usize::from(width == 63));
        assert_eq!(pose.translation, Vec3::ONE);
    }
    // One dimension more, as some write it.
    let by_joint = smplx(2, 63)
        .with("body_pose", Array::new(&[2, 21, 3], vec![0.5f32; 126]))
        .with("global_orient", Array::new(&[2, 1, 3], vec![0.0f32; 6]));
    let motion = Motion::read(&by_joint.npz(), "walk.npz", Some(30.0)).unwrap();
    assert_rotation(motion.poses[1].rotations[1], [0.5; 3]);
}

#[test]
fn what_is_assumed_is_noted() {
    let motion_read = Motion::read(&motion(1, 72).without("trans").npz(), "walk.npz", None).unwrap();
    assert_eq!(motion_read.poses[0].translation, Vec3::ZERO);
    assert!(motion_read.notes[0].contains("translation"));
    let unscaled =
        Arrays(vec![("smpl_poses", angles(1, 72)), ("smpl_trans", Array::new(&[1, 3], vec![1.0, 2.0, 3.0]))]);
    let motion_read = Motion::read(&unscaled.npz(), "walk.npz", Some(60.0)).unwrap();
    assert_eq!(motion_read.poses[0].translation, Vec3::new(1.0, 2.0, 3.0));
    assert!(motion_read.notes[0].contains("smpl_scaling"));
}

fn error_of(arrays: Arrays, frames_per_second: Option<f32>) -> ReadError {
    Motion::read(&arrays.npz(), "walk.npz", frames_per_second).expect_err("should be refused")
}

#[test]
fn wrong_motions_are_errors() {
    let nan = |shape: &[usize]| Array::new(shape, vec![f32::NAN; shape.iter().product()]);
    let rate = |rate: f64| Array::new(&[], vec![rate]);
    for (arrays, field, found) in [
        (motion(0, 72), "poses", "none"),
        (motion(2, 70), "poses", "shape [2, 70]"),
        (motion(2, 72).with("poses", Array::new(&[], vec![1.0])), "poses", "shape []"),
        (motion(2, 72).with("poses", nan(&[2, 72])), "poses", "NaN at [0, 0]"),
        (motion(1, 72).with("poses", Array::new(&[1, 72], vec![1e6; 72])), "poses", "1000000"),
        (motion(2, 72).with("trans", nan(&[2, 3])), "trans", "NaN at [0, 0]"),
        (motion(2, 72).with("trans", nan(&[3, 3])), "trans", "3"),
        (motion(2, 72).with("trans", nan(&[2, 2])), "trans", "shape [2, 2]"),
        (motion(2, 72).with("mocap_framerate", rate(0.0)), "mocap_framerate", "0"),
        (motion(2, 72).with("mocap_framerate", rate(f64::NAN)), "mocap_framerate", "NaN at []"),
        (motion(2, 72).with("mocap_framerate", nan(&[0])), "mocap_framerate", "shape [0]"),
        (smplx(2, 63).with("global_orient", angles(3, 3)), "global_orient", "3"),
        (smplx(2, 62), "body_pose", "shape [2, 62]"),
    ] {
        let error = error_of(arrays, None);
        assert_eq!((error.field.as_str(), error.found.as_str()), (field, found), "{error}");
    }
    let missing = error_of(motion(2, 72).without("poses"), None);
    assert!(missing.field.contains("smpl_poses") && missing.found.contains("trans"), "{missing}");
    for rate in [0.0, -60.0, f32::NAN, f32::INFINITY] {
        assert_eq!(error_of(motion(2, 72), Some(rate)).field, "frames_per_second");
    }
    for scaling in [0.0, -1.0, 1e-300] {
        let arrays = Arrays(vec![
            ("smpl_poses", angles(1, 72)),
            ("smpl_trans", Array::new(&[1, 3], vec![1.0; 3])),
            ("smpl_scaling", Array::new(&[1], vec![scaling])),
        ]);
        assert_eq!(error_of(arrays, Some(60.0)).field, "smpl_scaling");
    }
}
