//! Files and folders, with errors that name them.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::workspace;

/// Makes `folder` an empty one.
pub fn empty(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot clear {}", workspace::relative(folder)))?;
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", workspace::relative(folder)))
}

/// Copies a file; makes the folder that it goes to.
pub fn copy(from: &Path, to: &Path) -> Result<()> {
    make_parent(to)?;
    let named = || format!("cannot copy {} to {}", workspace::relative(from), workspace::relative(to));
    fs::copy(from, to).with_context(named).map(drop)
}

/// Copies those files of a folder, and of folders in it, that are wanted.
pub fn copy_folder(from: &Path, to: &Path, is_wanted: impl Fn(&Path) -> bool) -> Result<()> {
    for file in below(from)?.into_iter().filter(|file| is_wanted(file)) {
        copy(&file, &to.join(file.strip_prefix(from).expect("a file below the folder")))?;
    }
    Ok(())
}

/// Writes a file; makes the folder that it goes to.
pub fn write(file: &Path, contents: impl AsRef<[u8]>) -> Result<()> {
    make_parent(file)?;
    fs::write(file, contents).with_context(|| format!("cannot write {}", workspace::relative(file)))
}

/// Reads a text.
pub fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("cannot read {}", workspace::relative(file)))
}

/// All files in a folder and in folders in it, in a fixed order.
pub fn below(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot list {}", workspace::relative(folder)))?;
    let mut found = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(below(&path)?);
        } else {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Bytes as a checksum is written.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn make_parent(file: &Path) -> Result<()> {
    let parent = file.parent().context("a file without a folder")?;
    fs::create_dir_all(parent).with_context(|| format!("cannot make {}", workspace::relative(parent)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_copied_with_what_is_wanted_and_emptied() {
        let folder = std::env::temp_dir().join(format!("crease-files-{}", std::process::id()));
        let (from, to) = (folder.join("from"), folder.join("to"));
        write(&from.join("a/b.ts"), "b").unwrap();
        write(&from.join("a/c.js"), "c").unwrap();
        copy_folder(&from, &to, |path| path.extension().is_some_and(|extension| extension == "ts")).unwrap();
        assert_eq!(below(&to).unwrap(), [to.join("a/b.ts")]);
        empty(&to).unwrap();
        assert_eq!(below(&to).unwrap(), Vec::<PathBuf>::new());
        fs::remove_dir_all(&folder).unwrap();
        assert!(below(&folder).unwrap_err().to_string().contains("cannot list"));
    }
}
