//! The trainer as its users get it: one program, licences and notices in an archive that is the same for the same program.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use flate2::{Compression, GzBuilder};
use tar::{Builder, Header};

use crate::{command, progress, workspace};

/// Beside the program.
const COMPANIONS: [&str; 4] = ["LICENSE-MIT", "LICENSE-APACHE", "README.md", "CHANGELOG.md"];

/// Builds the trainer for this machine and packs it into `folder`. Returns the archive.
pub fn make(folder: &Path) -> Result<PathBuf> {
    let mut build = command::cargo("build");
    build.args(["--release", "--package", "crease-trainer", "--bin", "crease"]);
    // Lines of code are of no use without the code.
    build.env("CARGO_PROFILE_RELEASE_DEBUG", "false").env("CARGO_PROFILE_RELEASE_STRIP", "symbols");
    progress::aloud("Building the trainer", || command::run(&mut build))?;
    let program = workspace::root().join("target/release").join(format!("crease{}", std::env::consts::EXE_SUFFIX));
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    let name = format!("crease-trainer-{}-{machine}-{system}", env!("CARGO_PKG_VERSION"));
    let archive = folder.join(format!("{name}.tar.gz"));
    let companions = COMPANIONS.map(|name| workspace::root().join(name));
    pack(&archive, &name, &program, &companions)
        .with_context(|| format!("cannot write {}", workspace::relative(&archive)))?;
    Ok(archive)
}

/// Every file under `name`, without dates, owners or this machine's modes.
fn pack(archive: &Path, name: &str, program: &Path, companions: &[PathBuf]) -> Result<()> {
    let compressed = GzBuilder::new().mtime(0).write(File::create(archive)?, Compression::best());
    let mut tar = Builder::new(compressed);
    let all = std::iter::once((program, 0o755)).chain(companions.iter().map(|file| (file.as_path(), 0o644)));
    for (file, mode) in all {
        let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
        let mut header = Header::new_ustar();
        header.set_mode(mode);
        header.set_size(bytes.len() as u64);
        let inside = Path::new(name).join(file.file_name().context("a path without a name")?);
        tar.append_data(&mut header, inside, bytes.as_slice())?;
    }
    tar.into_inner()?.finish()?.sync_all()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::GzDecoder;

    #[test]
    fn an_archive_is_the_same_whenever_it_is_packed() {
        let folder = workspace::root().join("target/tmp/trainer-archive");
        fs::create_dir_all(&folder).unwrap();
        let (program, archive) = (folder.join("crease"), folder.join("a.tar.gz"));
        let licence = workspace::root().join("LICENSE-MIT");
        let packed = || {
            // Written anew: its date is another.
            fs::write(&program, "a program").unwrap();
            pack(&archive, "crease-1", &program, std::slice::from_ref(&licence)).unwrap();
            fs::read(&archive).unwrap()
        };
        let bytes = packed();
        assert_eq!(packed(), bytes);
        let mut reader = tar::Archive::new(GzDecoder::new(bytes.as_slice()));
        let entries: Vec<(String, u32)> = (reader.entries().unwrap())
            .map(|entry| entry.unwrap())
            .map(|entry| (entry.path().unwrap().display().to_string(), entry.header().mode().unwrap()))
            .collect();
        assert_eq!(entries, [("crease-1/crease".to_owned(), 0o755), ("crease-1/LICENSE-MIT".to_owned(), 0o644)]);
    }
}
