//! A folder that a test writes into.

use std::fs;
use std::path::PathBuf;

/// Empty at first, and gone when it is dropped.
pub struct Folder(pub PathBuf);

impl Folder {
    /// `name` tells it from those of other tests.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("crease-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
