//! Motions: poses over time, sampled at any moment.

mod read;
mod sample;
mod timeline;

pub use sample::interpolate;
pub use timeline::{Timeline, fade_in};

use crate::body::Pose;

/// Poses at a fixed rate.
#[derive(Clone, Debug)]
pub struct Motion {
    /// At least one pose, all of [`SMPL_JOINT_COUNT`] joints when read from a file.
    pub poses: Vec<Pose>,
    /// Poses a second.
    pub frames_per_second: f32,
    /// What the reader had to do that a person may want to know ("fingers left at rest").
    pub notes: Vec<String>,
}

/// Joints of SMPL's skeleton.
pub const SMPL_JOINT_COUNT: usize = 24;
