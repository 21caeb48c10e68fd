//! A captured sequence on disk: `sequence.json`, `body.npz`, `frames/NNNN.ply`, `ground_truth/NNNN.npz`.

use crate::ply::PointCloud;
use crease::body::Pose;
use crease::numpy::{Archive, ReadError};
use glam::{Vec3, Vec3A};
use std::path::{Path, PathBuf};

/// SMPL's joints.
const JOINT_COUNT: usize = 24;

/// A sequence with its body parameters. Scans and ground truth are read when asked for.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// Where it lies.
    pub directory: PathBuf,
    /// Name for people.
    pub name: String,
    /// Frames a second.
    pub frames_per_second: f32,
    /// Number of frames; at least one.
    pub frame_count: usize,
    /// Licence of the data, as the sequence states it; may be empty.
    pub licence: String,
    /// Shape coefficients of the person.
    pub betas: Vec<f32>,
    /// Pose of each frame.
    pub poses: Vec<Pose>,
    capture: String,
}

/// One frame's scan.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Which frame of the sequence.
    pub index: usize,
    /// Points, metres; at least one.
    pub points: Vec<Vec3A>,
    /// sRGB colours, if the scan has any.
    pub colours: Option<Vec<[u8; 3]>>,
}

/// One frame's true surface.
#[derive(Clone, Debug)]
pub struct GroundTruth {
    /// Points without noise, metres.
    pub points: Vec<Vec3A>,
    /// Unit normals, outward.
    pub normals: Vec<Vec3A>,
}

/// `sequence.json`.
#[derive(Clone, Debug, serde::Deserialize)]
pub struct Description {
    /// Name for people.
    pub name: String,
    /// Frames a second; positive.
    pub fps: f32,
    /// Number of frames; at least one.
    pub frame_count: usize,
    #[serde(default)]
    units: Option<String>,
    #[serde(default)]
    up: Option<String>,
    #[serde(default)]
    licence: String,
    #[serde(default)]
    capture: Capture,
}

#[derive(Clone, Debug, Default, serde::Deserialize)]
struct Capture {
    #[serde(default)]
    kind: String,
}

impl Description {
    /// Reads JSON; `file` is its name for messages.
    pub fn read(bytes: &[u8], file: &str) -> Result<Self, ReadError> {
        let error = |field: &str, expected: &str, found: String| read_error(Path::new(file), field, expected, found);
        let description: Self = serde_json::from_slice(bytes)
            .map_err(|message| error("JSON", "name, fps, frame_count", message.to_string()))?;
        if description.frame_count == 0 {
            return Err(error("frame_count", "at least 1", "0".into()));
        }
        if !(description.fps.is_finite() && description.fps > 0.0) {
            return Err(error("fps", "a positive number", description.fps.to_string()));
        }
        for (field, expected, found) in [("units", "metre", &description.units), ("up", "y", &description.up)] {
            if let Some(found) = found.as_ref().filter(|found| *found != expected) {
                return Err(error(field, expected, found.clone()));
            }
        }
        Ok(description)
    }
}

impl Sequence {
    /// Reads `sequence.json` and `body.npz` of `directory`.
    pub fn open(directory: &Path) -> Result<Self, ReadError> {
        let path = directory.join("sequence.json");
        let description = Description::read(&read(&path)?, &path.display().to_string())?;
        let (betas, poses) = read_body(&directory.join("body.npz"), description.frame_count)?;
        Ok(Self {
            directory: directory.to_path_buf(),
            name: description.name,
            frames_per_second: description.fps,
            frame_count: description.frame_count,
            licence: description.licence,
            betas,
            poses,
            capture: description.capture.kind,
        })
    }

    /// Reads the scan of frame `index`.
    pub fn scan(&self, index: usize) -> Result<Frame, ReadError> {
        self.check_index(index)?;
        if self.capture != "pointcloud" {
            let path = self.directory.join("sequence.json");
            return Err(read_error(&path, "capture.kind", "pointcloud", self.capture.clone()));
        }
        let path = self.directory.join(format!("frames/{index:04}.ply"));
        let cloud = PointCloud::read(&read(&path)?, &path.display().to_string())?;
        Ok(Frame { index, points: cloud.points, colours: cloud.colours })
    }

    /// Reads the ground truth of frame `index`. Not every frame has one.
    pub fn ground_truth(&self, index: usize) -> Result<GroundTruth, ReadError> {
        self.check_index(index)?;
        let path = self.directory.join(format!("ground_truth/{index:04}.npz"));
        let bytes = read(&path)?;
        let mut archive = Archive::open(&bytes, &path.display().to_string())?;
        let points = archive.required("points")?;
        let normals = archive.required("normals")?;
        match points.rows_of(3)? {
            0 => return Err(points.error("at least one point", "0")),
            count => normals.expect_shape(&[count, 3])?,
        }
        let vectors = |numbers: Vec<f32>| numbers.chunks_exact(3).map(Vec3A::from_slice).collect::<Vec<_>>();
        let points = vectors(points.finite_numbers()?);
        let normals = vectors(normals.finite_numbers()?).iter().map(|normal| normal.normalize_or_zero()).collect();
        Ok(GroundTruth { points, normals })
    }

    fn check_index(&self, index: usize) -> Result<(), ReadError> {
        if index < self.frame_count {
            return Ok(());
        }
        Err(read_error(&self.directory, "frame", &format!("less than {}", self.frame_count), index.to_string()))
    }
}

fn read_body(path: &Path, frame_count: usize) -> Result<(Vec<f32>, Vec<Pose>), ReadError> {
    let bytes = read(path)?;
    let mut archive = Archive::open(&bytes, &path.display().to_string())?;
    let betas = archive.required("betas")?.finite_numbers()?;
    let mut rows = |name: &str, width: usize| -> Result<Vec<f32>, ReadError> {
        let field = archive.required(name)?;
        field.expect_shape(&[frame_count, width])?;
        field.finite_numbers()
    };
    let poses = rows("poses", 3 * JOINT_COUNT)?;
    let translations = rows("trans", 3)?;
    let poses = poses
        .chunks_exact(3 * JOINT_COUNT)
        .zip(translations.chunks_exact(3))
        .map(|(pose, translation)| Pose::from_axis_angle(pose, Vec3::from_slice(translation)))
        .collect();
    Ok((betas, poses))
}

/// Reads a whole file; the error names it.
pub fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    std::fs::read(path).map_err(|error| read_error(path, "file", "a readable file", error.to_string()))
}

pub(crate) fn read_error(path: &Path, field: &str, expected: &str, found: String) -> ReadError {
    ReadError { file: path.display().to_string(), field: field.into(), expected: expected.into(), found }
}
