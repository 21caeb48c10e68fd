//! Where things lie in the repository.

use std::path::{Path, PathBuf};

/// The repository's root folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the repository's root")
}

/// The npm package.
pub fn web() -> PathBuf {
    root().join("web")
}

/// Build outputs of the wasm target, apart from the native ones: the two may come from different compilers.
pub fn wasm_target() -> PathBuf {
    root().join("target/web")
}

/// A path as a person at the root would type it.
pub fn relative(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}
