//! Files written whole or not at all.

use anyhow::Context;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// Writes `bytes` beside `path`, waits until they are on the disk, and renames: a reader never sees half a file, nor does anyone after a
/// power cut. Missing directories are made.
pub fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().with_context(|| format!("{}: expected the name of a file", path.display()))?;
    fs::create_dir_all(directory).with_context(|| format!("{}: cannot make the directory", directory.display()))?;
    let aside = directory.join(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
    let written = write_through(&aside, bytes).and_then(|()| fs::rename(&aside, path));
    if written.is_err() {
        // The write's own error is the one to report.
        let _ = fs::remove_file(&aside);
    }
    written.with_context(|| format!("{}: cannot be written", path.display()))
}

fn write_through(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole_and_failures_leave_nothing() {
        let directory = std::env::temp_dir().join(format!("crease-files-{}", std::process::id()));
        let path = directory.join("deep/file");
        write_whole(&path, b"one").unwrap();
        write_whole(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        // A directory in the way cannot be replaced by a file.
        let error = write_whole(&directory.join("deep"), b"three").unwrap_err();
        assert!(error.to_string().contains("deep"));
        let left: Vec<_> = fs::read_dir(&directory).unwrap().collect();
        assert_eq!(left.len(), 1, "no part file is left: {left:?}");
        fs::remove_dir_all(&directory).unwrap();
    }
}
