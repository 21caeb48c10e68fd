//! `reproduce`: whether the wasm module, in both forms, is the same wherever and whenever it is built.

use std::path::Path;

use anyhow::{Result, ensure};
use sha2::{Digest, Sha256};

use crate::{command, files, progress, setup, wasm, workspace};

/// Clones the last commit into two folders, builds each from clean and compares the modules. An error where they differ.
pub fn run() -> Result<()> {
    let toolchain = setup::for_building()?;
    let folder = workspace::root().join("target/reproduce");
    files::empty(&folder)?;
    let build = |name: &str| {
        let root = folder.join(name);
        progress::aloud(&format!("Building in {}", workspace::relative(&root)), || {
            clone(&root)?;
            wasm::build_apart(toolchain, &root)
        })
    };
    let builds = [build("one")?, build("another folder")?];
    for module in builds.as_flattened() {
        println!("{}  {} bytes", files::hex(&Sha256::digest(module)), module.len());
    }
    ensure!(builds[0] == builds[1], "two builds of one commit differ; they lie in {}", workspace::relative(&folder));
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}

fn clone(root: &Path) -> Result<()> {
    let mut git = command::program("git");
    git.args(["clone", "--quiet", "--local"]).arg(workspace::root()).arg(root);
    command::run(&mut git)
}
