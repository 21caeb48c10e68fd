//! A pinhole camera in OpenCV's convention: x right, y down, z forward, pixel centres at integers.

use super::{read, read_error};
use crease::numpy::ReadError;
use glam::{Affine3A, Mat3A, Vec3A};
use std::path::Path;

/// How far `world_from_camera` may be from a rigid motion.
const RIGIDITY_TOLERANCE: f32 = 1e-3;

/// Intrinsics, pose and unit of a depth camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Focal lengths, pixels.
    pub focal: [f32; 2],
    /// Where the optical axis meets the image, pixels.
    pub centre: [f32; 2],
    /// Metres for one unit of the depth images.
    pub depth_scale: f32,
    /// Rigid.
    pub world_from_camera: Affine3A,
    /// Its inverse.
    pub camera_from_world: Affine3A,
}

#[derive(serde::Deserialize)]
struct Description {
    width: Option<u32>,
    height: Option<u32>,
    fx: Option<f32>,
    fy: Option<f32>,
    cx: Option<f32>,
    cy: Option<f32>,
    #[serde(default = "millimetres")]
    depth_scale: f32,
    #[serde(default)]
    distortion: Option<Vec<f32>>,
    #[serde(default)]
    world_from_camera: Option<[[f32; 4]; 4]>,
}

fn millimetres() -> f32 {
    1e-3
}

impl Camera {
    /// Reads `camera.json`: `width`, `height`, `fx`, `fy`, `cx`, `cy` in pixels; optional `depth_scale` (metres for one unit, a millimetre if
    /// left out) and `world_from_camera` (4 × 4, row-major, rigid; the identity if left out).
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        if !path.exists() {
            let expected = "the camera of the depth images: width, height, fx, fy, cx, cy and world_from_camera, as OpenCV has them";
            return Err(read_error(path, "file", expected, "none".into()));
        }
        Self::decode(&read(path)?, &path.display().to_string())
    }

    /// What [`Self::read`] gives for a file's bytes; `file` is its name for messages.
    pub fn decode(bytes: &[u8], file: &str) -> Result<Self, ReadError> {
        let error = |field: &str, expected: &str, found: String| read_error(Path::new(file), field, expected, found);
        let description: Description = serde_json::from_slice(bytes).map_err(|message| {
            error("JSON", "width, height, fx, fy, cx, cy, world_from_camera", message.to_string())
        })?;
        let missing = |field: &str| {
            error(field, "a number: intrinsics of the camera in pixels, as OpenCV names them", "none".into())
        };
        let number = |field: &str, value: Option<f32>| value.filter(|v| v.is_finite()).ok_or_else(|| missing(field));
        let size = |field: &str, value: Option<u32>| value.filter(|&v| v > 0).ok_or_else(|| missing(field));
        let focal = [number("fx", description.fx)?, number("fy", description.fy)?];
        for (field, value) in ["fx", "fy"].into_iter().zip(focal) {
            if value <= 0.0 {
                return Err(error(field, "a positive number", value.to_string()));
            }
        }
        if !(description.depth_scale.is_finite() && description.depth_scale > 0.0) {
            return Err(error("depth_scale", "a positive number of metres", description.depth_scale.to_string()));
        }
        if description.distortion.is_some_and(|coefficients| coefficients.iter().any(|&c| c != 0.0)) {
            return Err(error("distortion", "none: undistort the images first", "coefficients".into()));
        }
        let world_from_camera = match description.world_from_camera {
            None => Affine3A::IDENTITY,
            Some(rows) => rigid(&rows).ok_or_else(|| {
                error("world_from_camera", "a rotation and a translation in rows of four", format!("{rows:?}"))
            })?,
        };
        Ok(Self {
            width: size("width", description.width)?,
            height: size("height", description.height)?,
            focal,
            centre: [number("cx", description.cx)?, number("cy", description.cy)?],
            depth_scale: description.depth_scale,
            world_from_camera,
            camera_from_world: world_from_camera.inverse(),
        })
    }

    /// Puts the camera somewhere.
    pub fn place(&mut self, world_from_camera: Affine3A) {
        self.world_from_camera = world_from_camera;
        self.camera_from_world = world_from_camera.inverse();
    }

    /// Where it stands, metres.
    pub fn position(&self) -> Vec3A {
        self.world_from_camera.translation
    }

    /// The point seen at pixel (u, v) at `depth` metres along the optical axis, in the camera's frame.
    pub fn unproject(&self, u: f32, v: f32, depth: f32) -> Vec3A {
        Vec3A::new((u - self.centre[0]) / self.focal[0] * depth, (v - self.centre[1]) / self.focal[1] * depth, depth)
    }

    /// Pixel and depth (metres) of a point of the world; nothing behind the camera.
    pub fn project(&self, point: Vec3A) -> Option<[f32; 3]> {
        let p = self.camera_from_world.transform_point3a(point);
        (p.z > 1e-3)
            .then(|| [p.x / p.z * self.focal[0] + self.centre[0], p.y / p.z * self.focal[1] + self.centre[1], p.z])
    }
}

fn rigid(rows: &[[f32; 4]; 4]) -> Option<Affine3A> {
    let column = |c: usize| Vec3A::new(rows[0][c], rows[1][c], rows[2][c]);
    let matrix = Mat3A::from_cols(column(0), column(1), column(2));
    let off = matrix.transpose() * matrix - Mat3A::IDENTITY;
    let is_rigid = off.to_cols_array().iter().all(|x| x.abs() < RIGIDITY_TOLERANCE)
        && matrix.determinant() > 0.0
        && column(3).is_finite()
        && rows[3] == [0.0, 0.0, 0.0, 1.0];
    is_rigid.then_some(Affine3A { matrix3: matrix, translation: column(3) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(text: &str) -> Result<Camera, ReadError> {
        Camera::decode(text.as_bytes(), "camera.json")
    }

    const GOOD: &str = r#"{"width": 640, "height": 480, "fx": 500, "fy": 510, "cx": 320, "cy": 240, "distortion": null,
        "world_from_camera": [[1,0,0,0.5],[0,-1,0,1],[0,0,-1,2],[0,0,0,1]]}"#;

    #[test]
    fn points_go_to_pixels_and_back() {
        let camera = camera(GOOD).unwrap();
        let point = Vec3A::new(0.3, 0.8, -0.4);
        let [u, v, depth] = camera.project(point).unwrap();
        assert!((depth - 2.4).abs() < 1e-6);
        let back = camera.world_from_camera.transform_point3a(camera.unproject(u, v, depth));
        assert!(back.distance(point) < 1e-5);
        assert!(camera.project(Vec3A::new(0.0, 1.0, 3.0)).is_none(), "behind it");
        assert!(v > 240.0, "lower in the world is further down the image");
    }

    #[test]
    fn what_is_missing_or_wrong_is_named() {
        for (from, to, field) in [
            ("\"fx\": 500,", "", "fx"),
            ("\"height\": 480,", "", "height"),
            ("\"fy\": 510", "\"fy\": -1", "fy"),
            ("null", "[0.1, 0.0]", "distortion"),
            ("[0,-1,0,1]", "[0,1,0,1]", "world_from_camera"),
            ("{", "", "JSON"),
        ] {
            let error = camera(&GOOD.replacen(from, to, 1)).unwrap_err();
            assert_eq!(error.field, field, "{error}");
        }
    }
}
