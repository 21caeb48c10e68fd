//! How a sequence's files lie in space. In memory y is up and the frame is right-handed.

use crease::body::Pose;
use glam::{Affine3A, Mat3A, Quat, Vec3A};
use serde::{Deserialize, Serialize};
use std::f32::consts::{FRAC_PI_2, PI};

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its name in `sequence.json`.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    fn unit(self) -> Vec3A {
        Vec3A::AXES[self as usize]
    }
}

/// The direction that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub enum Up {
    /// x.
    #[serde(rename = "x")]
    X,
    /// y.
    #[default]
    #[serde(rename = "y")]
    Y,
    /// z.
    #[serde(rename = "z")]
    Z,
    /// −x.
    #[serde(rename = "-x")]
    #[value(name = "-x")]
    MinusX,
    /// −y.
    #[serde(rename = "-y")]
    #[value(name = "-y")]
    MinusY,
    /// −z.
    #[serde(rename = "-z")]
    #[value(name = "-z")]
    MinusZ,
}

impl Up {
    /// All of them; y, the usual one, first.
    pub const ALL: [Self; 6] = [Self::Y, Self::Z, Self::X, Self::MinusY, Self::MinusZ, Self::MinusX];

    /// Its name in `sequence.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }

    /// The unit vector.
    pub fn direction(self) -> Vec3A {
        match self {
            Self::X => Vec3A::X,
            Self::Y => Vec3A::Y,
            Self::Z => Vec3A::Z,
            Self::MinusX => Vec3A::NEG_X,
            Self::MinusY => Vec3A::NEG_Y,
            Self::MinusZ => Vec3A::NEG_Z,
        }
    }

    /// The direction nearest to a vector that is not zero.
    pub fn nearest(vector: Vec3A) -> Self {
        let along = |up: &Self| up.direction().dot(vector);
        Self::ALL.into_iter().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or_default()
    }

    /// The rotation that brings it to y: by a quarter or half turn about x where that does it, as OpenCV's and OpenGL's axes differ.
    pub fn y_up_from_files(self) -> Quat {
        match self {
            Self::Y => Quat::IDENTITY,
            Self::Z => Quat::from_rotation_x(-FRAC_PI_2),
            Self::MinusZ => Quat::from_rotation_x(FRAC_PI_2),
            Self::MinusY => Quat::from_rotation_x(PI),
            Self::X => Quat::from_rotation_z(FRAC_PI_2),
            Self::MinusX => Quat::from_rotation_z(-FRAC_PI_2),
        }
    }

    /// A pose of files in which this is up, with y up. `root` is where the first joint rests, metres: its rotation is about this point.
    pub fn pose_to_y(self, pose: &Pose, root: Vec3A) -> Pose {
        let turn = self.y_up_from_files();
        let mut turned = pose.clone();
        turned.rotations[0] = (turn * pose.rotations[0]).normalize();
        turned.translation = turn * (glam::Vec3::from(root) + pose.translation) - glam::Vec3::from(root);
        turned
    }
}

/// How the scans of a sequence lie: mirrored first, then turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    /// What is up in the files.
    pub up: Up,
    /// The axis of the files whose sign has to be changed, where they hold mirror images.
    pub mirrored: Option<Axis>,
}

impl Orientation {
    /// From the files' coordinates to those in memory: orthogonal, with determinant −1 where they are mirrored.
    pub fn matrix(self) -> Mat3A {
        let signs = self.mirrored.map_or(Vec3A::ONE, |axis| Vec3A::ONE - 2.0 * axis.unit());
        Mat3A::from_quat(self.up.y_up_from_files()) * Mat3A::from_diagonal(signs.into())
    }

    /// [`Self::matrix`] as a motion, for cameras.
    pub fn motion(self) -> Affine3A {
        Affine3A { matrix3: self.matrix(), translation: Vec3A::ZERO }
    }
}

/// How a sequence is to be read where its description says nothing, or says otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// What is up in the scans [default: as sequence.json says]
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// The scans are mirror images: change the sign of this axis [default: as sequence.json says]
    #[arg(long, value_enum, value_name = "AXIS")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirrored: Option<Axis>,
    /// What is up in a file of poses that does not say so itself [default: as sequence.json says, or else as in the scans]
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses_up: Option<Up>,
}

impl Reading {
    /// Whether it says nothing.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The options of the command line that say the same.
    pub fn words(&self) -> Vec<String> {
        let up = |name: &str, up: Option<Up>| up.map(|up| format!("--{name} {}", up.name()));
        let mirrored = self.mirrored.map(|axis| format!("--mirrored {}", axis.name()));
        [up("up", self.up), mirrored, up("poses-up", self.poses_up)].into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::Camera;
    use crease::body::posed_from_rest;
    use crease::fixture::{bent_pose, voxel_person};

    #[test]
    fn every_direction_comes_up_and_stays_right_handed() {
        for up in Up::ALL {
            let matrix = Orientation { up, mirrored: None }.matrix();
            assert!((matrix * up.direction()).distance(Vec3A::Y) < 1e-6, "{up:?}");
            assert!((matrix.determinant() - 1.0).abs() < 1e-6);
            assert_eq!(Up::nearest(up.direction() + Vec3A::splat(0.2)), up);
            let written = serde_json::to_string(&up).unwrap();
            assert_eq!(written, format!("\"{}\"", up.name()));
        }
    }

    #[test]
    fn mirroring_changes_one_sign_of_the_files() {
        let matrix = Orientation { up: Up::Z, mirrored: Some(Axis::X) }.matrix();
        assert!((matrix * Vec3A::new(1.0, 2.0, 3.0)).distance(Vec3A::new(-1.0, 3.0, -2.0)) < 1e-6);
        assert!((matrix.determinant() + 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_camera_sees_turned_and_mirrored_points_where_it_saw_them() {
        let text = r#"{"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 30, "cy": 20,
            "world_from_camera": [[0,0,1,0.5],[1,0,0,1],[0,1,0,2],[0,0,0,1]]}"#;
        let read = Camera::decode(text.as_bytes(), "camera.json").unwrap();
        let orientation = Orientation { up: Up::MinusX, mirrored: Some(Axis::Z) };
        let mut placed = read.clone();
        placed.place(orientation.motion() * read.world_from_camera);
        let point = Vec3A::new(2.0, 1.2, 1.9);
        let [before, after] = [read.project(point), placed.project(orientation.matrix() * point)].map(Option::unwrap);
        assert!((0..3).all(|i| (before[i] - after[i]).abs() < 1e-4), "{before:?} {after:?}");
    }

    #[test]
    fn a_turned_pose_is_the_turned_body() {
        let rig = voxel_person().shaped(&[0.4, 0.1]);
        let pose = bent_pose();
        let root = rig.rest_joints[0];
        assert!(root.length() > 0.1, "the root rests off the origin");
        for up in Up::ALL {
            let turn = up.y_up_from_files();
            let [before, after] = [pose.clone(), up.pose_to_y(&pose, root)].map(|pose| posed_from_rest(&rig, &pose));
            for (v, &rest) in rig.rest.iter().enumerate().step_by(11) {
                let [before, after] =
                    [&before, &after].map(|transforms| rig.skin.blend(v, transforms).transform_point3a(rest));
                assert!(after.distance(turn * before) < 1e-5, "{up:?}, vertex {v}");
            }
        }
    }
}
