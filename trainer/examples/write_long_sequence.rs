//! Writes a sequence of any length made in code: `write_long_sequence DIRECTORY FRAMES POINTS`. The open body sways in waving clothes.
//!
//! `cargo xtask long-run` trains on it.

use crease::animate::PosedSurface;
use crease::body::Pose;
use crease::mesh::{Scheme, Subdivision, vertex_normals};
use crease::numpy::{Array, Compression, write_npz};
use crease_trainer::config::{OPEN_BODY_NOTICE, read_body_model};
use crease_trainer::sampling::area_uniform;
use crease_trainer::sequence::{BodyParameters, Up, write_body};
use glam::{Quat, Vec3, Vec3A};
use rayon::prelude::*;
use serde_json::json;
use std::fs;
use std::path::Path;

const FRAMES_PER_SECOND: f32 = 30.0;

/// Joints that sway: about which axis, radians, radians a second.
const SWAY: [(usize, Vec3, f32, f32); 7] = [
    (1, Vec3::X, 0.5, 2.1),
    (2, Vec3::X, 0.5, 1.7),
    (3, Vec3::Y, 0.4, 1.3),
    (4, Vec3::X, 0.4, 0.9),
    (16, Vec3::Z, 0.7, 1.1),
    (17, Vec3::Z, 0.7, 1.9),
    (18, Vec3::Y, 0.9, 2.3),
];

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, frames, points] = arguments.as_slice() else {
        anyhow::bail!("expected DIRECTORY FRAMES POINTS, found {arguments:?}");
    };
    write(Path::new(directory), frames.parse()?, points.parse()?)
}

fn write(directory: &Path, frame_count: usize, point_count: usize) -> anyhow::Result<()> {
    let body = read_body_model(None)?;
    let betas = vec![0.0; body.shape_directions.len()];
    let rig = body.shaped(&betas);
    let subdivision = Subdivision::new(rig.rest.len(), &body.triangles, 0);
    let triangles = &body.triangles;
    let mut normals = vec![Vec3A::ZERO; rig.rest.len()];
    vertex_normals(&rig.rest, triangles, &mut normals);
    let poses: Vec<Pose> = (0..frame_count).map(|frame| pose(frame, body.parents.len())).collect();

    fs::create_dir_all(directory.join("frames"))?;
    poses.par_iter().enumerate().try_for_each(|(index, pose)| {
        let seconds = index as f32 / FRAMES_PER_SECOND;
        // Clothes 15 mm off the body, with waves of 5 mm that wander.
        let waves = rig.rest.iter().map(|p| 0.015 + 0.005 * (40.0 * p.y + 3.0 * seconds).sin());
        let clothes: Vec<Vec3A> = normals.iter().zip(waves).map(|(&normal, wave)| normal * wave).collect();
        let mut surface = PosedSurface::new(&subdivision);
        surface.pose(&rig, &clothes, pose, &subdivision, Scheme::Loop, 0);
        let positions = surface.finest();
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        vertex_normals(positions, triangles, &mut normals);
        let scan = area_uniform(positions, triangles, point_count, index as u64);
        let rows = |values: &[Vec3A]| {
            let numbers: Vec<f32> =
                scan.iter().flat_map(|sample| sample.interpolate(triangles, values).to_array()).collect();
            Array::new(&[point_count, 3], numbers)
        };
        let arrays = [("points", &rows(positions)), ("normals", &rows(&normals))];
        fs::write(directory.join(format!("frames/{index:04}.npz")), write_npz(&arrays, Compression::Stored)?)?;
        anyhow::Ok(())
    })?;
    write_body(&directory.join("body.npz"), &BodyParameters { betas, poses }, Up::Y, FRAMES_PER_SECOND)?;
    let description = json!({
        "name": "long",
        "fps": FRAMES_PER_SECOND,
        "frame_count": frame_count,
        "units": "metre",
        "up": "y",
        "licence": OPEN_BODY_NOTICE,
        "capture": { "kind": "pointcloud" },
    });
    Ok(fs::write(directory.join("sequence.json"), serde_json::to_vec_pretty(&description)?)?)
}

fn pose(frame: usize, joint_count: usize) -> Pose {
    let seconds = frame as f32 / FRAMES_PER_SECOND;
    let mut pose = Pose::rest(joint_count);
    for (joint, axis, amplitude, rate) in SWAY {
        pose.rotations[joint] = Quat::from_axis_angle(axis, amplitude * (rate * seconds).sin());
    }
    pose
}
