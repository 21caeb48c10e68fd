//! `body.npz`: shape and poses of a body over a sequence, as AMASS keeps them.

use super::{read, read_error};
use crate::files::write_whole;
use crease::body::Pose;
use crease::motion::Motion;
use crease::numpy::{Archive, Array, Compression, ReadError, write_npz};
use crease::rotation::axis_angle_from_quat;
use std::path::Path;

/// One shape, and a pose for each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyParameters {
    /// β.
    pub betas: Vec<f32>,
    /// θ_t and t_t.
    pub poses: Vec<Pose>,
}

/// Reads shape and poses, y up, metres: `betas (B,)`, and poses in any layout of [`Motion::read`] with translations. Of SMPL-H's and
/// SMPL-X's joints the 22 that all share are taken.
pub fn read_body(path: &Path) -> Result<BodyParameters, ReadError> {
    let bytes = read(path)?;
    let file = path.display().to_string();
    let mut archive = Archive::open(&bytes, &file)?;
    let betas = archive.required("betas")?.finite_numbers()?;
    if archive.optional("trans")?.is_none() && archive.optional("transl")?.is_none() {
        return Err(read_error(
            path,
            "trans",
            "where the body stands in each frame, (frames, 3), metres",
            "none".into(),
        ));
    }
    // The rate tells only when a pose is shown.
    const ANY_RATE: f32 = 60.0;
    Ok(BodyParameters { betas, poses: Motion::read(&bytes, &file, Some(ANY_RATE))?.poses })
}

/// Writes shape and poses: `betas (B,)`, `poses (T, 72)` axis-angle, `trans (T, 3)` metres, `mocap_framerate`. The file is whole or absent.
pub fn write_body(path: &Path, body: &BodyParameters, frames_per_second: f32) -> anyhow::Result<()> {
    let angles: Vec<f32> = (body.poses.iter().flat_map(|pose| &pose.rotations))
        .flat_map(|&rotation| axis_angle_from_quat(rotation).to_array())
        .collect();
    let translations: Vec<f32> = body.poses.iter().flat_map(|pose| pose.translation.to_array()).collect();
    let count = body.poses.len();
    let betas = Array::new(&[body.betas.len()], body.betas.clone());
    let poses = Array::new(&[count, angles.len() / count.max(1)], angles);
    let trans = Array::new(&[count, 3], translations);
    let rate = Array::new(&[], vec![f64::from(frames_per_second)]);
    let arrays = [("betas", &betas), ("poses", &poses), ("trans", &trans), ("mocap_framerate", &rate)];
    write_whole(path, &write_npz(&arrays, Compression::Deflated)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    #[test]
    fn bodies_come_back() {
        let directory = std::env::temp_dir().join(format!("crease-body-file-{}", std::process::id()));
        let path = directory.join("body.npz");
        let mut pose = Pose::rest(24);
        pose.rotations[5] = Quat::from_rotation_x(0.7);
        pose.translation = Vec3::new(0.1, 0.2, -0.3);
        let written = BodyParameters { betas: vec![0.5, -1.0], poses: vec![Pose::rest(24), pose] };
        write_body(&path, &written, 15.0).unwrap();
        let read = read_body(&path).unwrap();
        assert_eq!(read.betas, written.betas);
        for (read, written) in read.poses.iter().zip(&written.poses) {
            assert!(read.translation.distance(written.translation) < 1e-6);
            assert!(read.rotations.iter().zip(&written.rotations).all(|(a, b)| a.angle_between(*b) < 1e-3));
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
