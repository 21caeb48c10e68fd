//! The open body, captured in code, is found again from its scans alone.

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, ply};
use crease::body::{Body, Pose, Rig, posed_from_rest};
use crease::rotation::quat_from_axis_angle;
use crease_trainer::progress::Progress;
use crease_trainer::registration::{Hints, compare, register};
use crease_trainer::sampling::area_uniform;
use crease_trainer::sequence::{BodyParameters, Camera, Capture};
use crease_trainer::visibility::DepthBuffer;
use glam::{Quat, Vec3, Vec3A};
use image::{ImageBuffer, Luma};
use std::f32::consts::PI;
use std::fs;
use std::path::Path;

const FRAME_COUNT: usize = 5;
const CAMERA: &str = r#"{"width": 320, "height": 288, "fx": 252, "fy": 252, "cx": 160, "cy": 144,
    "world_from_camera": [[1,0,0,0],[0,-1,0,1],[0,0,-1,2.2],[0,0,0,1]]}"#;

fn open_body() -> Body {
    Body::read(include_bytes!("../../assets/open_body.npz"), "the open body").unwrap()
}

/// A tall person, arms hanging, who turns a little, raises an arm and bends a knee.
fn truth(body: &Body) -> BodyParameters {
    let mut betas = vec![0.0; body.shape_directions.len()];
    (betas[0], betas[1]) = (1.2, -0.6);
    let feet = |rig: &Rig| rig.rest.iter().map(|vertex| vertex.y).fold(f32::INFINITY, f32::min);
    let floor = feet(&body.shaped(&betas));
    let poses = (0..FRAME_COUNT).map(|frame| {
        let t = frame as f32 / (FRAME_COUNT - 1) as f32;
        let mut pose = Pose::rest(24);
        let mut turn = |joint: usize, axis_angle: [f32; 3]| {
            pose.rotations[joint] = quat_from_axis_angle(Vec3::from_array(axis_angle));
        };
        turn(0, [0.0, 0.3 + 0.4 * t, 0.0]);
        turn(3, [0.1 * t, 0.1 * t, 0.0]);
        turn(16, [0.0, 0.0, -1.1 + 0.6 * t]);
        turn(17, [0.0, 0.0, 1.2]);
        turn(18, [0.0, -0.5 * t, 0.0]);
        turn(19, [0.0, 0.3, 0.0]);
        turn(1, [-0.3 * t, 0.0, 0.05]);
        turn(4, [0.5 * t, 0.0, 0.0]);
        pose.translation = Vec3::new(0.05 * t, -floor, 0.1 * t);
        pose
    });
    BodyParameters { poses: poses.collect(), betas }
}

fn posed(rig: &Rig, pose: &Pose) -> Vec<Vec3A> {
    rig.posed(pose, &posed_from_rest(rig, pose))
}

fn describe(directory: &Path, kind: &str) {
    let text = format!(
        r#"{{"name": "naked", "fps": 15, "frame_count": {FRAME_COUNT}, "units": "metre", "up": "y", "capture": {{"kind": "{kind}"}}}}"#
    );
    fs::write(directory.join("sequence.json"), text).unwrap();
}

fn write_clouds(directory: &Path, body: &Body, parameters: &BodyParameters) {
    fs::create_dir_all(directory.join("frames")).unwrap();
    let rig = body.shaped(&parameters.betas);
    for (index, pose) in parameters.poses.iter().enumerate() {
        let vertices = posed(&rig, pose);
        let samples = area_uniform(&vertices, &body.triangles, 8_000, index as u64);
        let points: Vec<Vec3A> = samples.iter().map(|sample| sample.interpolate(&body.triangles, &vertices)).collect();
        fs::write(directory.join(format!("frames/{index:04}.ply")), ply(&points)).unwrap();
    }
    describe(directory, "pointcloud");
}

fn write_depth(directory: &Path, body: &Body, parameters: &BodyParameters) {
    fs::create_dir_all(directory.join("depth")).unwrap();
    fs::write(directory.join("camera.json"), CAMERA).unwrap();
    let camera = Camera::read(&directory.join("camera.json")).unwrap();
    let rig = body.shaped(&parameters.betas);
    for (index, pose) in parameters.poses.iter().enumerate() {
        let vertices = posed(&rig, pose);
        let depths = DepthBuffer::render(&camera, &vertices, &body.triangles).depths;
        let pixels = depths.iter().map(|&depth| if depth.is_finite() { (1e3 * depth).round() as u16 } else { 0 });
        let image = ImageBuffer::<Luma<u16>, _>::from_raw(camera.width, camera.height, pixels.collect::<Vec<_>>());
        image.unwrap().save(directory.join(format!("depth/{index:04}.png"))).unwrap();
    }
    describe(directory, "depth");
}

#[test]
fn clouds_from_all_around_give_the_body_back() {
    let directory = Directory::new("register-clouds");
    let body = open_body();
    let truth = truth(&body);
    write_clouds(&directory.0, &body, &truth);
    let capture = Capture::open(&directory.0).unwrap();
    let found = register(&capture, &body, &Hints::default(), Progress::Silent).unwrap();
    let accuracy = compare(&body, &found.parameters, &truth, None).unwrap();
    assert!(accuracy.vertices_mm < 8.0 && accuracy.joints_mm < 10.0, "{accuracy:?}");
    assert!(found.failing.is_empty());
}

#[test]
fn a_depth_camera_gives_the_side_back_that_it_sees() {
    let directory = Directory::new("register-depth");
    let body = open_body();
    let truth = truth(&body);
    write_depth(&directory.0, &body, &truth);
    let capture = Capture::open(&directory.0).unwrap();
    let found = register(&capture, &body, &Hints::default(), Progress::Silent).unwrap();
    let accuracy = compare(&body, &found.parameters, &truth, capture.camera()).unwrap();
    assert!(accuracy.seen_vertices_mm.unwrap() < 15.0, "{accuracy:?}");
}

#[test]
fn a_pose_far_from_standing_needs_a_hint() {
    let directory = Directory::new("register-hint");
    let body = open_body();
    let mut truth = truth(&body);
    for pose in &mut truth.poses {
        // On the back.
        pose.rotations[0] = Quat::from_rotation_x(-PI / 2.0) * pose.rotations[0];
    }
    write_clouds(&directory.0, &body, &truth);
    let capture = Capture::open(&directory.0).unwrap();
    let error = |hints: &Hints| {
        let found = register(&capture, &body, hints, Progress::Silent).unwrap();
        compare(&body, &found.parameters, &truth, None).unwrap().vertices_mm
    };
    let mut near = truth.poses[0].clone();
    near.rotations[0] = Quat::from_rotation_x(0.2) * near.rotations[0];
    near.translation += Vec3::splat(0.05);
    assert!(error(&Hints { initial_pose: Some(near), keypoints: Vec::new() }) < 10.0);
    assert!(error(&Hints::default()) > 50.0, "without a hint the person is taken to stand");
}
