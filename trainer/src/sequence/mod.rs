//! A captured sequence on disk: `sequence.json` with scans of one of several layouts, `body.npz`, `ground_truth/NNNN.npz`.

mod body_file;
mod camera;
mod capture;
mod depth;
mod orientation;

pub use body_file::{BodyParameters, WrittenBody, read_body, read_first_pose, write_body};
pub use camera::Camera;
pub use capture::{Capture, Description, Frame, GroundTruth};
pub use depth::{ImageFile, NEARNESS, decode_frame};
pub use orientation::{Axis, Orientation, Reading, Up};

use crease::body::Pose;
use crease::numpy::ReadError;
use glam::Vec3A;
use std::path::Path;

/// A capture with the body's shape and poses in it.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// Scans and ground truth.
    pub capture: Capture,
    /// Shape coefficients of the person.
    pub betas: Vec<f32>,
    /// Pose of each frame.
    pub poses: Vec<Pose>,
}

impl Sequence {
    /// Reads `sequence.json` of `directory`, and shape and poses from `poses`, or else from its own `body.npz`.
    ///
    /// `reading` counts more than the description. `root` gives where the first joint of the body with shape β rests, metres: poses that do
    /// not have y up are turned, and the root is turned about it.
    pub fn open(
        directory: &Path,
        poses: Option<&Path>,
        reading: &Reading,
        root: impl Fn(&[f32]) -> Vec3A,
    ) -> Result<Self, ReadError> {
        let capture = Capture::open_as(directory, reading)?;
        let own = directory.join("body.npz");
        let path = poses.unwrap_or(&own);
        if !path.exists() {
            return Err(read_error(
                path,
                "file",
                "shape and poses of the body: `crease register` estimates them from the scans",
                "none".into(),
            ));
        }
        let BodyParameters { betas, poses } = read_body(path)?.y_up(capture.poses_up, root);
        if poses.len() != capture.frame_count {
            let expected = format!("{} frames as in sequence.json", capture.frame_count);
            return Err(read_error(path, "poses", &expected, poses.len().to_string()));
        }
        Ok(Self { capture, betas, poses })
    }
}

/// Reads a whole file; the error names it.
pub fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    std::fs::read(path).map_err(|error| read_error(path, "file", "a readable file", error.to_string()))
}

pub(crate) fn read_error(path: &Path, field: &str, expected: &str, found: String) -> ReadError {
    ReadError { file: path.display().to_string(), field: field.into(), expected: expected.into(), found }
}
