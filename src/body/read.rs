//! Bodies from `.npz` and from SMPL's own `.pkl`.

use super::Body;
use crate::numpy::ReadError;

impl Body {
    /// Reads a `.npz` or `.pkl` body, told apart by its first bytes; `name` is the file's name for messages.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self, ReadError> {
        let _ = (bytes, name);
        todo!()
    }
}
