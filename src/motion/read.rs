//! Motions from AIST++ `.pkl` and AMASS / SMPL-X-style `.npz`.

use super::Motion;
use crate::numpy::ReadError;

impl Motion {
    /// Reads a motion. `frames_per_second` overrides the file's rate and must be given where the file has none.
    pub fn read(
        bytes: &[u8],
        name: &str,
        frames_per_second: Option<f32>,
    ) -> Result<Self, ReadError> {
        let _ = (bytes, name, frames_per_second);
        todo!()
    }
}
