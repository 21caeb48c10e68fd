//! `samples`: the projects of examples/ are built from the packed npm package, and each of them plays.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::browser::Browser;
use crate::site::Site;
use crate::{check, command, files, package, progress, setup, wasm, workspace};

/// Projects that a bundler builds into their folder `dist`.
const BUNDLED: [&str; 3] = ["vite", "webpack", "react"];

/// What the pages of all samples name, and the small files of the tests that stand in.
const MEDIA: [(&str, &str); 2] =
    [("avatar.glb", "tests/fixtures/tiny.glb"), ("dance.pkl", "web/assets/motions/dance_a.pkl")];

/// Frames that each draws: enough to see it move.
const FRAMES: u32 = 8;

/// Packs, builds and plays.
pub fn run() -> Result<()> {
    let toolchain = setup::everything()?;
    wasm::build(toolchain)?;
    wasm::build_element()?;
    package::make()?;
    check_all()
}

/// Builds every sample and plays it; the package must have been made.
pub fn check_all() -> Result<()> {
    let plain = folder().join("plain");
    files::empty(&plain)?;
    files::copy_folder(&workspace::root().join("examples/plain"), &plain, |_| true)?;
    files::copy_folder(&package::unpacked().join("lib"), &plain.join("crease-avatar"), |_| true)?;
    play(&plain)?;
    for name in BUNDLED {
        play(&progress::aloud(&format!("Building examples/{name}"), || build(name))?)?;
    }
    Ok(())
}

fn folder() -> PathBuf {
    workspace::root().join("target/samples")
}

/// Installs what the lock file names and runs the sample's own build; returns the built site.
fn build(name: &str) -> Result<PathBuf> {
    let project = workspace::root().join("examples").join(name);
    for arguments in [["ci", "--ignore-scripts"], ["run", "build"]] {
        command::run(command::program("npm").args(arguments).current_dir(&project))?;
    }
    let site = folder().join(name);
    files::empty(&site)?;
    files::copy_folder(&project.join("dist"), &site, |_| true)?;
    Ok(site)
}

fn play(site: &Path) -> Result<()> {
    for (name, stand_in) in MEDIA {
        files::copy(&workspace::root().join(stand_in), &site.join(name))?;
    }
    let picture = site.with_extension("png");
    let report = check::play(Site::folder(site)?, Browser::Chromium, FRAMES, &picture)?;
    println!("{}", report.to_json()?);
    Ok(())
}
