//! `package`: the npm package and the trainer's archive, packed into target/package/ with their checksums; and how large they are.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::{command, files, progress, setup, size, trainer_archive, wasm, workspace};

/// Members of web/package.json that are of use in this repository only.
const OWN_MEMBERS: [&str; 2] = ["scripts", "devDependencies"];

/// What is published.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum What {
    /// The npm package
    Npm,
    /// The trainer for this machine; its build takes long
    Trainer,
}

/// What to pack.
#[derive(clap::Args)]
pub struct Options {
    /// One of the two alone
    #[arg(long, value_enum)]
    only: Option<What>,
}

/// Builds what is out of date, packs it, writes `SHA256SUMS` and tells the sizes.
pub fn run(options: &Options) -> Result<()> {
    let is_wanted = |what| options.only.is_none_or(|only| only == what);
    let (mut published, mut told) = (Vec::new(), serde_json::Map::new());
    if is_wanted(What::Npm) {
        let toolchain = setup::for_building()?;
        wasm::build(toolchain)?;
        wasm::build_element()?;
        published.push(make()?);
        let lengths = files::below(&unpacked())?.into_iter().map(|file| Ok(fs::metadata(file)?.len()));
        told.insert("unpacked_bytes".into(), lengths.sum::<Result<u64>>()?.into());
        told.insert("runtime_gzip_bytes".into(), size::runtime_gzip_bytes()?.into());
    }
    if is_wanted(What::Trainer) {
        published.push(trainer_archive::make(&folder())?);
    }
    for file in &published {
        told.insert(workspace::relative(file), fs::metadata(file)?.len().into());
    }
    write_checksums(&published)?;
    println!("{}", Value::Object(told));
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
fn write_checksums(published: &[PathBuf]) -> Result<()> {
    let line = |file: &PathBuf| {
        let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
        Ok(checksum_line(&bytes, &file.file_name().context("a path without a name")?.to_string_lossy()))
    };
    let lines = published.iter().map(line).collect::<Result<String>>()?;
    files::write(&folder().join("SHA256SUMS"), &lines)
}

fn checksum_line(bytes: &[u8], name: &str) -> String {
    format!("{}  {name}\n", files::hex(&Sha256::digest(bytes)))
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
