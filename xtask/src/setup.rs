//! What a task needs on the machine, and how it gets there.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::toolchain::{self, Toolchain};
use crate::{browser, command, progress, workspace};

/// Everything that building the web module and the element needs.
pub fn for_building() -> Result<Toolchain> {
    let toolchain = toolchain::choose();
    install(&missing(&building(toolchain)))?;
    install_npm_packages()?;
    Ok(toolchain)
}

/// The same and a browser to run it in.
pub fn everything() -> Result<Toolchain> {
    let toolchain = toolchain::choose();
    install(&missing(&[building(toolchain), browsing()].concat()))?;
    install_npm_packages()?;
    Ok(toolchain)
}

/// A Debian package and whether what we use of it is there already, from whatever source.
#[derive(Clone, Copy)]
struct Requirement {
    package: &'static str,
    is_met: bool,
}

fn requirement(package: &'static str, is_met: bool) -> Requirement {
    Requirement { package, is_met }
}

fn building(toolchain: Toolchain) -> Vec<Requirement> {
    let mut list = vec![requirement("nodejs", command::exists("node")), requirement("npm", command::exists("npm"))];
    if toolchain == Toolchain::Debian {
        let exists = |path: &str| Path::new(path).exists();
        list.extend([
            requirement("rustc-web", exists("/usr/bin/rustc")),
            requirement("cargo-web", exists("/usr/bin/cargo")),
            requirement("rust-web-src", exists("/usr/lib/rustlib/src/rust/library")),
            requirement("lld", command::exists("wasm-ld")),
        ]);
    }
    list
}

fn browsing() -> Vec<Requirement> {
    vec![
        requirement("chromium", browser::chromium().is_some()),
        requirement("chromium-driver", browser::driver().is_some()),
        requirement("firefox-esr", browser::firefox().is_some()),
        // A screen for Firefox, and OpenGL in software for that screen.
        requirement("xvfb", command::exists("xvfb-run")),
        requirement("xauth", command::exists("xauth")),
        requirement("libgl1-mesa-dri", has_library("dri/swrast_dri.so")),
        requirement("libegl1", has_library("libEGL.so.1")),
        requirement("libgl1", has_library("libGL.so.1")),
    ]
}

/// Whether a file is in a folder of shared libraries, for whatever processor.
fn has_library(name: &str) -> bool {
    let folders = fs::read_dir("/usr/lib").into_iter().flatten().flatten().map(|entry| entry.path());
    folders.chain([Path::new("/usr/lib").to_owned()]).any(|folder| folder.join(name).exists())
}

fn missing(requirements: &[Requirement]) -> Vec<&'static str> {
    requirements.iter().filter(|requirement| !requirement.is_met).map(|requirement| requirement.package).collect()
}

fn install(packages: &[&str]) -> Result<()> {
    if packages.is_empty() {
        return Ok(());
    }
    let line = packages.join(" ");
    if !command::exists("apt-get") {
        bail!("missing on this machine: {line} (the names of Debian's packages)");
    }
    if !is_root() {
        bail!("missing packages; install them with this line, then run the task again:\n  {}", by_hand(packages));
    }
    progress::aloud(&format!("Installing {line}"), || {
        // A fresh machine has no package lists yet.
        command::run(command::program("apt-get").args(["update", "-q"]))?;
        let mut apt = command::program("apt-get");
        apt.args(["install", "-y", "-q", "--no-install-recommends"]).args(packages);
        command::run(apt.env("DEBIAN_FRONTEND", "noninteractive"))
    })
}

fn by_hand(packages: &[&str]) -> String {
    format!("sudo apt-get update && sudo apt-get install -y --no-install-recommends {}", packages.join(" "))
}

#[cfg(unix)]
fn is_root() -> bool {
    nix::unistd::geteuid().is_root()
}

#[cfg(not(unix))]
fn is_root() -> bool {
    false
}

/// Installs web/node_modules as the lock file says, unless that has been done.
fn install_npm_packages() -> Result<()> {
    let web = workspace::web();
    let lock = web.join("package-lock.json");
    // Our own copy of the lock file, written last: npm's own record does not tell an unfinished installation.
    let installed = web.join("node_modules/.installed-package-lock.json");
    let wanted = fs::read(&lock).with_context(|| format!("cannot read {}", workspace::relative(&lock)))?;
    if fs::read(&installed).is_ok_and(|found| found == wanted) {
        return Ok(());
    }
    progress::aloud("Installing npm packages", || {
        command::run(command::program("npm").args(["ci", "--ignore-scripts", "--prefix"]).arg(&web))?;
        fs::write(&installed, &wanted).with_context(|| format!("cannot write {}", workspace::relative(&installed)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_unmet_requirements_are_installed() {
        let list = [requirement("nodejs", true), requirement("lld", false), requirement("npm", false)];
        assert_eq!(missing(&list), ["lld", "npm"]);
    }

    #[test]
    fn the_line_for_people_names_every_package() {
        assert!(by_hand(&["lld", "npm"]).ends_with("install -y --no-install-recommends lld npm"));
    }

    #[test]
    fn the_lock_file_names_no_registry() {
        let lock = fs::read_to_string(workspace::web().join("package-lock.json")).unwrap();
        assert!(lock.contains("\"integrity\"") && !lock.contains("\"resolved\""));
    }
}
