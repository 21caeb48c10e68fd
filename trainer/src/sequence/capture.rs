//! What was captured: the description and the scans, whatever their layout.

use super::camera::Camera;
use super::depth;
use super::orientation::{Axis, Orientation, Reading, Up};
use super::{read, read_error};
use crate::checkpoint::{Fingerprint, Ingredients};
use crate::ply::PointCloud;
use crate::scan_file::{ENDINGS, read_scan};
use clap::ValueEnum;
use crease::numpy::{Archive, ReadError};
use glam::Vec3A;
use std::path::{Path, PathBuf};

/// Scans of one person over time. They are read when asked for.
#[derive(Clone, Debug)]
pub struct Capture {
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
    /// How the scans lie in their files.
    pub orientation: Orientation,
    /// What is up in files of poses that do not say so themselves.
    pub poses_up: Up,
    layout: Layout,
    has_inward_normals: bool,
    metres_per_unit: f32,
}

#[derive(Clone, Debug)]
enum Layout {
    /// `frames/NNNN` with an ending of [`ENDINGS`].
    PointCloud,
    /// `depth/NNNN.png`, `color/NNNN.jpg` or `.png` if there are any, `camera.json`.
    Depth(Box<Camera>),
    /// A kind that has no scans.
    Other(String),
}

/// One frame's scan.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Which frame of the sequence.
    pub index: usize,
    /// Points, metres; at least one.
    pub points: Vec<Vec3A>,
    /// Unit normals, outward, if the scan has any.
    pub normals: Option<Vec<Vec3A>>,
    /// sRGB colours, if the scan has any.
    pub colours: Option<Vec<[u8; 3]>>,
    /// μ of each point: 1 where the distance to the camera is not known; mean 1.
    pub weights: Vec<f32>,
    /// The camera, if the scan is the view of one: only what it sees is in the scan.
    pub camera: Option<Camera>,
}

impl Frame {
    /// Of all that training takes from a scan: points, normals, colours, weights, camera.
    pub fn fingerprint(&self) -> Fingerprint {
        let Self { index: _, points, normals, colours, weights, camera } = self;
        let all = Ingredients::new("scan").points(points).bytes(bytemuck::cast_slice(weights));
        let all = all.points(normals.as_deref().unwrap_or_default());
        let all = all.bytes(colours.as_deref().unwrap_or_default().as_flattened());
        // Its shortest exact text: the type has no bytes of its own.
        all.bytes(format!("{camera:?}").as_bytes()).finish()
    }

    /// Gives points that a depth camera sees μ = exp(−`nearness` z), z in metres, divided by its mean over the frame; others keep theirs.
    pub fn weigh(&mut self, nearness: f32) {
        if let Some(camera) = &self.camera {
            let z = |&point: &Vec3A| camera.camera_from_world.transform_point3a(point).z;
            self.weights = depth::weights(self.points.iter().map(z), nearness);
        }
    }

    /// Squared cosine between each point's normal and the direction to the camera: how much a picture says about it. 1 without a camera.
    pub fn frontality(&self) -> Vec<f32> {
        let (Some(camera), Some(normals)) = (&self.camera, &self.normals) else { return vec![1.0; self.points.len()] };
        let eye = camera.position();
        let cosine = |(&point, &normal): (&Vec3A, &Vec3A)| (eye - point).normalize_or_zero().dot(normal).max(0.0);
        self.points.iter().zip(normals).map(|pair| cosine(pair).powi(2)).collect()
    }
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
    mirrored: Option<String>,
    #[serde(default)]
    poses_up: Option<String>,
    #[serde(default)]
    normals: Option<String>,
    #[serde(default)]
    licence: String,
    #[serde(default)]
    capture: CaptureDescription,
}

#[derive(Clone, Debug, Default, serde::Deserialize)]
struct CaptureDescription {
    #[serde(default)]
    kind: String,
    #[serde(default)]
    camera: Option<String>,
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
        Ok(description)
    }
}

impl Capture {
    /// Reads `sequence.json` of `directory`, and `camera.json` where the scans are depth images.
    pub fn open(directory: &Path) -> Result<Self, ReadError> {
        Self::open_as(directory, &Reading::default())
    }

    /// [`Self::open`], where `reading` counts more than the description.
    pub fn open_as(directory: &Path, reading: &Reading) -> Result<Self, ReadError> {
        let path = directory.join("sequence.json");
        let error = |field: &str, expected: &str, found: String| read_error(&path, field, expected, found);
        let description = Description::read(&read(&path)?, &path.display().to_string())?;
        let metres_per_unit = match description.units.as_deref() {
            None | Some("metre") => 1.0,
            Some("centimetre") => 0.01,
            Some("millimetre") => 0.001,
            Some(other) => return Err(error("units", "metre, centimetre or millimetre", other.into())),
        };
        let has_inward_normals = match description.normals.as_deref() {
            None | Some("outward") => false,
            Some("inward") => true,
            Some(other) => return Err(error("normals", "outward or inward", other.into())),
        };
        let ups = "x, y, z, -x, -y or -z";
        let described_up = named::<Up>(description.up, |found| error("up", ups, found))?;
        let described_poses_up = named::<Up>(description.poses_up, |found| error("poses_up", ups, found))?;
        let mirrored = named::<Axis>(description.mirrored, |found| error("mirrored", "x, y or z", found))?;
        let up = reading.up.or(described_up).unwrap_or_default();
        let orientation = Orientation { up, mirrored: reading.mirrored.or(mirrored) };
        let layout = match description.capture.kind.as_str() {
            "pointcloud" => Layout::PointCloud,
            "depth" => {
                let camera = description.capture.camera.as_deref().unwrap_or("camera.json");
                let mut camera = Camera::read(&directory.join(camera))?;
                camera.place(orientation.motion() * camera.world_from_camera);
                Layout::Depth(Box::new(camera))
            }
            other => Layout::Other(other.into()),
        };
        Ok(Self {
            directory: directory.to_path_buf(),
            name: description.name,
            frames_per_second: description.fps,
            frame_count: description.frame_count,
            licence: description.licence,
            orientation,
            poses_up: reading.poses_up.or(described_poses_up).unwrap_or(up),
            layout,
            has_inward_normals,
            metres_per_unit,
        })
    }

    /// The camera, if the scans are the view of one.
    pub fn camera(&self) -> Option<&Camera> {
        match &self.layout {
            Layout::Depth(camera) => Some(camera),
            Layout::PointCloud | Layout::Other(_) => None,
        }
    }

    /// Reads the scan of frame `index`.
    pub fn scan(&self, index: usize) -> Result<Frame, ReadError> {
        self.check_index(index)?;
        let mut frame = match &self.layout {
            Layout::PointCloud => {
                let paths = ENDINGS.map(|ending| self.directory.join(format!("frames/{index:04}.{ending}")));
                let cloud = read_scan(paths.iter().find(|path| path.exists()).unwrap_or(&paths[0]))?;
                let weights = vec![1.0; cloud.points.len()];
                let PointCloud { points, normals, colours, .. } = cloud;
                let normals = normals.map(|normals| normals.iter().map(|n| n.normalize_or_zero()).collect());
                Frame { index, points, normals, colours, weights, camera: None }
            }
            Layout::Depth(camera) => {
                let depth = self.directory.join(format!("depth/{index:04}.png"));
                let colour = ["jpg", "png"].map(|end| self.directory.join(format!("color/{index:04}.{end}")));
                let colour = colour.iter().find(|path| path.exists());
                return depth::read_frame(camera, index, &depth, colour.map(PathBuf::as_path));
            }
            Layout::Other(kind) => {
                let path = self.directory.join("sequence.json");
                return Err(read_error(&path, "capture.kind", "pointcloud or depth", kind.clone()));
            }
        };
        let matrix = self.orientation.matrix();
        for point in &mut frame.points {
            *point = matrix * (*point * self.metres_per_unit);
        }
        let sign = if self.has_inward_normals { -1.0 } else { 1.0 };
        for normal in frame.normals.iter_mut().flatten() {
            *normal = matrix * (*normal * sign);
        }
        Ok(frame)
    }

    /// Reads the ground truth of frame `index`. Not every frame has one.
    pub fn ground_truth(&self, index: usize) -> Result<GroundTruth, ReadError> {
        self.check_index(index)?;
        let path = self.ground_truth_path(index);
        let bytes = read(&path)?;
        let mut archive = Archive::open(&bytes, &path.display().to_string())?;
        let points = archive.required("points")?;
        let normals = archive.required("normals")?;
        match points.rows_of(3)? {
            0 => return Err(points.error("at least one point", "0")),
            count => normals.expect_shape(&[count, 3])?,
        }
        let vectors = |numbers: Vec<f32>| numbers.chunks_exact(3).map(Vec3A::from_slice).collect::<Vec<_>>();
        let matrix = self.orientation.matrix();
        let points = vectors(points.finite_numbers()?).iter().map(|&p| matrix * (p * self.metres_per_unit)).collect();
        let normals = vectors(normals.finite_numbers()?).iter().map(|&n| (matrix * n).normalize_or_zero()).collect();
        Ok(GroundTruth { points, normals })
    }

    /// Whether there is a file with the ground truth of frame `index`.
    pub fn has_ground_truth(&self, index: usize) -> bool {
        self.ground_truth_path(index).exists()
    }

    fn ground_truth_path(&self, index: usize) -> PathBuf {
        self.directory.join(format!("ground_truth/{index:04}.npz"))
    }

    fn check_index(&self, index: usize) -> Result<(), ReadError> {
        if index < self.frame_count {
            return Ok(());
        }
        Err(read_error(&self.directory, "frame", &format!("less than {}", self.frame_count), index.to_string()))
    }
}

/// The value of this name, if there is a name.
fn named<T: ValueEnum>(name: Option<String>, error: impl Fn(String) -> ReadError) -> Result<Option<T>, ReadError> {
    name.map(|name| T::from_str(&name, false).map_err(|_| error(name))).transpose()
}
