//! Arrays as numpy writes them: `.npy` inside `.npz`, and pickles. Bounded readers: nothing is executed.
//!
//! [`Archive`] opens either kind of file; its [`Field`]s are arrays that know where they came from.

mod archive;
mod array;
mod element_type;
mod npy;
mod npz;
mod pickle;

pub use archive::{Archive, Field};
pub use array::{Array, Elements};
pub use npz::{Compression, write_npz};

use crate::memory::Shortage;

/// Elements that one array may have: the largest of SMPL-X has 15 million.
const ELEMENT_LIMIT: usize = 1 << 26;
/// Bytes that one file of an archive may have, unpacked: as many elements at eight bytes each, and a header.
const ENTRY_BYTE_LIMIT: u64 = 8 * ELEMENT_LIMIT as u64 + (1 << 16);
/// Dimensions that one array may have.
const DIMENSION_LIMIT: usize = 16;

/// What is wrong with a file, by file, field, expected and found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}: {field}: expected {expected}, found {found}")]
pub struct ReadError {
    /// The file's name.
    pub file: String,
    /// Which array, entry or byte offset.
    pub field: String,
    /// What should be there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

/// A place in a file, for errors.
#[derive(Clone, Copy)]
struct Place<'a> {
    file: &'a str,
    field: &'a str,
}

impl Place<'_> {
    fn short(&self, shortage: Shortage) -> ReadError {
        self.error(shortage.expected, shortage.found)
    }

    fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        // Files may leave an array without a name.
        let field = if self.field.is_empty() { "(no name)" } else { self.field };
        ReadError {
            file: self.file.to_owned(),
            field: field.to_owned(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}
