//! A sequence made in code: the tiny procedural body in bumpy clothes, sampled to point clouds.

use crease::animate::PosedSurface;
use crease::body::{Body, Pose};
use crease::fixture::{bent_pose, voxel_person};
use crease::mesh::{Scheme, Subdivision, vertex_normals};
use crease::numpy::{Array, Compression, ReadError, write_npz};
use crease::rotation::axis_angle_from_quat;
use crease_trainer::sampling::area_uniform;
use crease_trainer::sequence::{Reading, Sequence};
use glam::{Quat, Vec3A};
use std::fs;
use std::path::{Path, PathBuf};

pub const FRAME_COUNT: usize = 6;
const POINT_COUNT: usize = 4_000;
const BETAS: [f32; 2] = [0.3, -0.2];

/// A directory that goes away with the test.
pub struct Directory(pub PathBuf);

impl Directory {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("crease-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Reads a sequence whose poses have y up.
pub fn open(directory: &Path) -> Result<Sequence, ReadError> {
    Sequence::open(directory, None, &Reading::default(), |_| Vec3A::ZERO)
}

fn poses(count: usize) -> Vec<Pose> {
    let (rest, bent) = (Pose::rest(24), bent_pose());
    (0..count)
        .map(|frame| {
            let t = frame as f32 / (count - 1).max(1) as f32;
            let mut pose = bent.clone();
            for (rotation, (from, to)) in pose.rotations.iter_mut().zip(rest.rotations.iter().zip(&bent.rotations)) {
                *rotation = Quat::slerp(*from, *to, t);
            }
            pose.translation = rest.translation.lerp(bent.translation, t);
            pose
        })
        .collect()
}

/// Writes the sequence and gives the body it shows.
pub fn write_sequence(directory: &Path) -> Body {
    write_frames(directory, FRAME_COUNT, POINT_COUNT)
}

/// Writes a sequence of `frame_count` frames of `point_count` points and gives the body it shows.
pub fn write_frames(directory: &Path, frame_count: usize, point_count: usize) -> Body {
    let body = voxel_person();
    let rig = body.shaped(&BETAS);
    let subdivision = Subdivision::new(rig.rest.len(), &body.triangles, 2);
    let mut normals = vec![Vec3A::ZERO; rig.rest.len()];
    vertex_normals(&rig.rest, &body.triangles, &mut normals);
    // Clothes 30 mm off the body, with waves of 8 mm.
    let waves = rig.rest.iter().map(|p| 0.03 + 0.008 * (p.y * 18.0).sin());
    let clothes: Vec<Vec3A> = normals.iter().zip(waves).map(|(&normal, wave)| normal * wave).collect();

    fs::create_dir_all(directory.join("frames")).unwrap();
    fs::create_dir_all(directory.join("ground_truth")).unwrap();
    let mut surface = PosedSurface::new(&subdivision);
    for (index, pose) in poses(frame_count).iter().enumerate() {
        surface.pose(&rig, &clothes, pose, &subdivision, Scheme::Loop, subdivision.level_count());
        let (positions, triangles) = (surface.finest(), subdivision.triangles(2));
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        vertex_normals(positions, triangles, &mut normals);
        let scan = area_uniform(positions, triangles, point_count, index as u64);
        let points: Vec<Vec3A> = scan.iter().map(|sample| sample.interpolate(triangles, positions)).collect();
        fs::write(directory.join(format!("frames/{index:04}.ply")), ply(&points)).unwrap();
        let truth = area_uniform(positions, triangles, point_count, 100 + index as u64);
        let points: Vec<Vec3A> = truth.iter().map(|sample| sample.interpolate(triangles, positions)).collect();
        let normals: Vec<Vec3A> = truth.iter().map(|sample| sample.interpolate(triangles, &normals)).collect();
        let arrays = npz(&[("points", rows(&points)), ("normals", rows(&normals))]);
        fs::write(directory.join(format!("ground_truth/{index:04}.npz")), arrays).unwrap();
    }
    write_body(directory, frame_count);
    let description = format!(
        r#"{{"name": "bumpy", "fps": 15, "frame_count": {frame_count}, "units": "metre", "up": "y", "licence": "none needed",
            "capture": {{"kind": "pointcloud"}}, "ground_truth": {{"every": 1}}}}"#
    );
    fs::write(directory.join("sequence.json"), description).unwrap();
    body
}

/// Writes `body.npz` with `count` poses.
pub fn write_body(directory: &Path, count: usize) {
    let poses = poses(count);
    let angles: Vec<f32> =
        poses.iter().flat_map(|p| &p.rotations).flat_map(|&q| axis_angle_from_quat(q).to_array()).collect();
    let translations: Vec<f32> = poses.iter().flat_map(|pose| pose.translation.to_array()).collect();
    let arrays = [
        ("betas", Array::new(&[BETAS.len()], BETAS.to_vec())),
        ("poses", Array::new(&[count, 72], angles)),
        ("trans", Array::new(&[count, 3], translations)),
    ];
    fs::write(directory.join("body.npz"), npz(&arrays)).unwrap();
}

/// Writes a body model as `.npz`, for commands that take one.
pub fn write_body_model(path: &Path, body: &Body) {
    let (count, joint_count) = (body.template.len(), body.parents.len());
    let mut weights = vec![0.0; count * joint_count];
    for (row, (joints, influences)) in
        weights.chunks_exact_mut(joint_count).zip(body.skin.joints.iter().zip(&body.skin.weights))
    {
        joints.iter().zip(influences).for_each(|(&joint, influence)| row[joint as usize] += influence);
    }
    let mut regressor = vec![0.0; joint_count * count];
    for (row, entries) in regressor.chunks_exact_mut(count).zip(&body.joint_regressor) {
        entries.iter().for_each(|&(vertex, weight)| row[vertex as usize] = weight);
    }
    let component_count = body.shape_directions.len();
    let components: Vec<f32> = (0..count)
        .flat_map(|vertex| (0..3).map(move |axis| (vertex, axis)))
        .flat_map(|(vertex, axis)| body.shape_directions.iter().map(move |field| field[vertex][axis]))
        .collect();
    let parents = body.parents.iter().map(|parent| parent.map_or(-1, |parent| parent as i64));
    let corners: Vec<i64> = body.triangles.iter().flatten().map(|&corner| i64::from(corner)).collect();
    let arrays = [
        ("v_template", rows(&body.template)),
        ("f", Array::new(&[body.triangles.len(), 3], corners)),
        ("shapedirs", Array::new(&[count, 3, component_count], components)),
        ("weights", Array::new(&[count, joint_count], weights)),
        ("J_regressor", Array::new(&[joint_count, count], regressor)),
        ("kintree_table", Array::new(&[2, joint_count], parents.chain(0..joint_count as i64).collect::<Vec<_>>())),
    ];
    fs::write(path, npz(&arrays)).unwrap();
}

fn rows(vectors: &[Vec3A]) -> Array {
    Array::new(&[vectors.len(), 3], vectors.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>())
}

pub fn npz(arrays: &[(&str, Array)]) -> Vec<u8> {
    let arrays: Vec<(&str, &Array)> = arrays.iter().map(|(name, array)| (*name, array)).collect();
    write_npz(&arrays, Compression::Stored).unwrap()
}

/// A binary point cloud with a colour by height.
pub fn ply(points: &[Vec3A]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        points.len()
    )
    .into_bytes();
    for point in points {
        bytes.extend(point.to_array().iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([(point.y * 100.0) as u8, 120, 40]);
    }
    bytes
}
