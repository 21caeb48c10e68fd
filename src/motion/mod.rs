//! Motions: poses over time, sampled at any moment.

mod read;

use crate::body::Pose;

/// Poses at a fixed rate.
#[derive(Clone, Debug)]
pub struct Motion {
    /// At least one pose.
    pub poses: Vec<Pose>,
    /// Poses a second.
    pub frames_per_second: f32,
    /// What the reader had to do that a person may want to know ("55 joints mapped to the first 24").
    pub notes: Vec<String>,
}

impl Motion {
    /// Seconds from the first pose to the last.
    pub fn duration(&self) -> f32 {
        (self.poses.len() - 1) as f32 / self.frames_per_second
    }

    /// The pose at `seconds`, clamped to the motion: rotations by spherical interpolation, translation linearly.
    pub fn sample(&self, seconds: f32) -> Pose {
        let _ = seconds;
        todo!()
    }
}
