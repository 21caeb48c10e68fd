//! Writing an avatar.

use super::Avatar;

impl Avatar {
    /// The avatar as a GLB.
    pub fn write(&self) -> Vec<u8> {
        todo!()
    }
}
