//! Arrays as numpy writes them: `.npy` inside `.npz`, and pickles. Bounded readers: nothing is executed.

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
