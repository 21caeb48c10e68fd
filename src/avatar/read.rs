//! Reading and validating an avatar.

use super::{Avatar, AvatarError};

impl Avatar {
    /// Reads a GLB; every count, offset and index is checked; every number is finite. `name` is the file's name for messages.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self, AvatarError> {
        let _ = (bytes, name);
        todo!()
    }
}
