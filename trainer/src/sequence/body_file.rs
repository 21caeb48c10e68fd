//! `body.npz`: shape and poses of a body over a sequence, as AMASS keeps them.

use super::orientation::Up;
use super::{read, read_error};
use crate::files::write_whole;
use crease::body::Pose;
use crease::motion::Motion;
use crease::numpy::{Archive, Array, Compression, ReadError, write_npz};
use crease::rotation::axis_angle_from_quat;
use glam::Vec3A;
use std::path::Path;

/// One shape, and a pose for each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyParameters {
    /// β.
    pub betas: Vec<f32>,
    /// θ_t and t_t.
    pub poses: Vec<Pose>,
}

/// Shape and poses as a file has them.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenBody {
    /// β, and poses in the file's coordinates.
    pub parameters: BodyParameters,
    /// What is up in the file, if it says so.
    pub up: Option<Up>,
}

impl WrittenBody {
    /// Shape and poses with y up. `otherwise` is up in files that do not say; `root` gives where the first joint of the body with shape β
    /// rests, metres.
    pub fn y_up(self, otherwise: Up, root: impl Fn(&[f32]) -> Vec3A) -> BodyParameters {
        let up = self.up.unwrap_or(otherwise);
        let BodyParameters { betas, mut poses } = self.parameters;
        if up != Up::Y {
            let root = root(&betas);
            poses.iter_mut().for_each(|pose| *pose = up.pose_to_y(pose, root));
        }
        BodyParameters { betas, poses }
    }
}

/// Reads shape and poses, metres: `betas (B,)`, and poses in any layout of [`Motion::read`] with translations. Of SMPL-H's and
/// SMPL-X's joints the 22 that all share are taken. Files of [`write_body`] have `up (3,)`, the direction that is up.
pub fn read_body(path: &Path) -> Result<WrittenBody, ReadError> {
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
    let up = read_up(&mut archive)?;
    Ok(WrittenBody { parameters: BodyParameters { betas, poses: poses(&bytes, &file)? }, up })
}

/// The poses of a motion, whatever its rate: that tells only when one is shown.
fn poses(bytes: &[u8], file: &str) -> Result<Vec<Pose>, ReadError> {
    const ANY_RATE: f32 = 60.0;
    Ok(Motion::read(bytes, file, Some(ANY_RATE))?.poses)
}

/// What a file of poses says about what is up.
fn read_up(archive: &mut Archive) -> Result<Option<Up>, ReadError> {
    let Some(field) = archive.optional("up")? else { return Ok(None) };
    field.expect_shape(&[3])?;
    let direction = Vec3A::from_slice(&field.finite_numbers()?);
    match Up::nearest(direction) {
        up if up.direction().distance(direction) < 1e-3 => Ok(Some(up)),
        _ => Err(field.error("the unit vector of an axis", direction.to_string())),
    }
}

/// The first pose of a motion that may say what is up, with y up. `otherwise` and `root` as of [`WrittenBody::y_up`].
pub fn read_first_pose(path: &Path, otherwise: Up, root: Vec3A) -> Result<Option<Pose>, ReadError> {
    let bytes = read(path)?;
    let file = path.display().to_string();
    let up = read_up(&mut Archive::open(&bytes, &file)?)?.unwrap_or(otherwise);
    Ok(poses(&bytes, &file)?.first().map(|pose| up.pose_to_y(pose, root)))
}

/// Writes shape and poses: `betas (B,)`, `poses (T, 72)` axis-angle, `trans (T, 3)` metres, `up (3,)`, `mocap_framerate`. The file is whole or
/// absent.
pub fn write_body(path: &Path, body: &BodyParameters, up: Up, frames_per_second: f32) -> anyhow::Result<()> {
    let angles: Vec<f32> = (body.poses.iter().flat_map(|pose| &pose.rotations))
        .flat_map(|&rotation| axis_angle_from_quat(rotation).to_array())
        .collect();
    let translations: Vec<f32> = body.poses.iter().flat_map(|pose| pose.translation.to_array()).collect();
    let count = body.poses.len();
    let betas = Array::new(&[body.betas.len()], body.betas.clone());
    let poses = Array::new(&[count, angles.len() / count.max(1)], angles);
    let trans = Array::new(&[count, 3], translations);
    let rate = Array::new(&[], vec![f64::from(frames_per_second)]);
    let up = Array::new(&[3], up.direction().to_array().to_vec());
    let arrays = [("betas", &betas), ("poses", &poses), ("trans", &trans), ("up", &up), ("mocap_framerate", &rate)];
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
        write_body(&path, &written, Up::MinusZ, 15.0).unwrap();
        let found = read_body(&path).unwrap();
        assert_eq!(found.up, Some(Up::MinusZ));
        let root = Vec3A::new(0.0, -0.2, 0.1);
        let turned = found.clone().y_up(Up::X, |_| root);
        assert_eq!(turned.poses[1], Up::MinusZ.pose_to_y(&found.parameters.poses[1], root), "the file knows best");
        assert_eq!(read_first_pose(&path, Up::Y, root).unwrap().unwrap(), turned.poses[0]);
        let read = found.parameters;
        assert_eq!(read.betas, written.betas);
        for (read, written) in read.poses.iter().zip(&written.poses) {
            assert!(read.translation.distance(written.translation) < 1e-6);
            assert!(read.rotations.iter().zip(&written.rotations).all(|(a, b)| a.angle_between(*b) < 1e-3));
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
