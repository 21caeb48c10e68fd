//! `package`: the npm package and the trainer's archive, packed into target/package/ with their checksums; and how large they are.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::{command, files, progress, setup, size, trainer_archive, wasm, workspace};

/// Members of web/package.json that are of use in this repository only.
const OWN_MEMBERS: [&str; 2] = ["scripts", "devDependencies"];

/// Builds what is out of date, packs it and tells the sizes.
pub fn run() -> Result<()> {
    let toolchain = setup::for_building()?;
    wasm::build(toolchain)?;
    wasm::build_element()?;
    let tarball = make()?;
    let archive = trainer_archive::make(&folder())?;
    write_checksums(&[&tarball, &archive])?;
    let sizes = serde_json::json!({
        "trainer": workspace::relative(&archive),
        "trainer_bytes": fs::metadata(&archive)?.len(),
        "tarball": workspace::relative(&tarball),
        "tarball_bytes": fs::metadata(&tarball)?.len(),
        "unpacked_bytes": files::below(&unpacked())?.iter().map(|file| Ok(fs::metadata(file)?.len())).sum::<Result<u64>>()?,
        "runtime_gzip_bytes": size::runtime_gzip_bytes()?,
    });
    println!("{sizes}");
    Ok(())
}

/// Where the package lies as its users get it.
pub fn unpacked() -> PathBuf {
    folder().join("crease-avatar")
}

fn folder() -> PathBuf {
    workspace::root().join("target/package")
}

/// Lays the npm package out and packs it. The element must have been built. Returns the tarball.
pub fn make() -> Result<PathBuf> {
    wasm::describe_element()?;
    progress::quietly("Packing the npm package", || {
        lay_out(&unpacked())?;
        let mut npm = command::program("npm");
        npm.args(["pack", "--silent", "--pack-destination"]).arg(folder()).current_dir(unpacked());
        let name = command::output(&mut npm)?;
        Ok(folder().join(name.trim()))
    })
}

/// The files of the package, and no others.
fn lay_out(package: &Path) -> Result<()> {
    files::empty(package)?;
    let (root, web) = (workspace::root(), workspace::web());
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        files::copy(&root.join(name), &package.join(name))?;
    }
    for name in ["README.md", "custom-elements.json"] {
        files::copy(&web.join(name), &package.join(name))?;
    }
    files::copy_folder(&web.join("lib"), &package.join("lib"), |_| true)?;
    let is_declaration = |path: &Path| path.to_string_lossy().ends_with(".d.ts");
    for name in ["dist", "pkg"] {
        files::copy_folder(&web.join(name), &package.join("types").join(name), is_declaration)?;
    }
    let text = fs::read_to_string(web.join("package.json")).context("cannot read web/package.json")?;
    files::write(&package.join("package.json"), &public_manifest(&text)?)
}

/// package.json without what only this repository uses.
fn public_manifest(text: &str) -> Result<String> {
    let mut manifest: Value = serde_json::from_str(text).context("web/package.json: expected JSON")?;
    let members = manifest.as_object_mut().context("web/package.json: expected an object")?;
    for name in OWN_MEMBERS {
        members.remove(name);
    }
    Ok(serde_json::to_string_pretty(&manifest)? + "\n")
}

/// `SHA256SUMS` beside what is published, as `sha256sum --check` reads it.
fn write_checksums(published: &[&Path]) -> Result<()> {
    let line = |file: &&Path| {
        let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
        Ok(checksum_line(&bytes, &file.file_name().context("a path without a name")?.to_string_lossy()))
    };
    let lines = published.iter().map(line).collect::<Result<String>>()?;
    files::write(&folder().join("SHA256SUMS"), &lines)
}

fn checksum_line(bytes: &[u8], name: &str) -> String {
    let mut line = String::new();
    for byte in Sha256::digest(bytes) {
        write!(line, "{byte:02x}").expect("a string takes everything");
    }
    line + "  " + name + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_public_manifest_lacks_what_only_we_use() {
        let text = public_manifest(r#"{"name": "a", "scripts": {"x": "y"}, "devDependencies": {}, "files": ["lib"]}"#);
        let manifest: Value = serde_json::from_str(&text.unwrap()).unwrap();
        assert_eq!(manifest, serde_json::json!({ "name": "a", "files": ["lib"] }));
        assert!(public_manifest("[]").is_err());
    }

    #[test]
    fn checksums_are_those_of_sha256sum() {
        let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  a.tgz\n";
        assert_eq!(checksum_line(b"", "a.tgz"), empty);
    }

    #[test]
    fn every_place_that_the_manifest_names_is_laid_out() {
        let text = fs::read_to_string(workspace::web().join("package.json")).unwrap();
        let manifest: Value = serde_json::from_str(&text).unwrap();
        let names: Vec<&str> = manifest["files"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert_eq!(names, ["lib", "types", "custom-elements.json"]);
    }
}
