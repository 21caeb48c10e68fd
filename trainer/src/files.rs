//! Files written whole or not at all.

use anyhow::Context;
use std::fs::{self, File};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

/// Writes `bytes` beside `path`, waits until they are on the disk, and renames: a reader never sees half a file, nor does anyone after a
/// power cut. Missing directories are made.
pub fn write_whole(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut file = PartFile::create(path)?;
    file.write_all(bytes).with_context(|| cannot_be_written(path))?;
    file.keep()
}

/// A file that is written piece by piece, and has its name when it is whole. Without [`Self::keep`] nothing is left of it.
pub struct PartFile {
    file: BufWriter<File>,
    aside: PathBuf,
    path: PathBuf,
    is_kept: bool,
}

impl PartFile {
    /// Begins the file that will be at `path`. Missing directories are made. What a process left there that was killed in the midst is taken
    /// up and written over.
    ///
    /// Fails where another process is writing the same file.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = path.file_name().with_context(|| format!("{}: expected the name of a file", path.display()))?;
        fs::create_dir_all(directory).with_context(|| format!("{}: cannot make the directory", directory.display()))?;
        let aside = directory.join(format!(".{}.part", name.to_string_lossy()));
        // Truncated only when it is ours.
        let open = File::options().read(true).write(true).create(true).truncate(false).open(&aside);
        let file = open.with_context(|| cannot_be_written(path))?;
        file.try_lock().with_context(|| format!("{}: another process is writing it", path.display()))?;
        file.set_len(0).with_context(|| cannot_be_written(path))?;
        Ok(Self { file: BufWriter::new(file), aside, path: path.to_path_buf(), is_kept: false })
    }

    /// Copies all that was written so far to the end of another.
    pub fn append_to(&mut self, other: &mut Self) -> std::io::Result<()> {
        self.file.rewind()?;
        std::io::copy(self.file.get_mut(), &mut other.file).map(|_| ())
    }

    /// Waits until everything is on the disk, and gives the file its name.
    pub fn keep(mut self) -> anyhow::Result<()> {
        let kept = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        kept.and_then(|()| fs::rename(&self.aside, &self.path)).with_context(|| cannot_be_written(&self.path))?;
        self.is_kept = true;
        Ok(())
    }
}

impl Write for PartFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.is_kept {
            // Where it cannot be removed nobody could do better.
            let _ = fs::remove_file(&self.aside);
        }
    }
}

fn cannot_be_written(path: &Path) -> String {
    format!("{}: cannot be written", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_process_left_is_taken_up_and_what_another_writes_is_not() {
        let directory = std::env::temp_dir().join(format!("crease-parts-{}", std::process::id()));
        let path = directory.join("file");
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join(".file.part"), b"half of something long").unwrap();
        write_whole(&path, b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        let writing = PartFile::create(&path).unwrap();
        let error = write_whole(&path, b"another").unwrap_err();
        assert!(error.to_string().contains("another process"), "{error}");
        drop(writing);
        write_whole(&path, b"another").unwrap();
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 1, "no part file is left");
        fs::remove_dir_all(&directory).unwrap();
    }

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
