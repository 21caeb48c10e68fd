//! What a page downloads before an avatar can play, apart from the avatar.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::workspace;

/// Bytes of the wasm module, its bindings and the element where WebGPU draws, each file gzipped as servers do.
pub fn runtime_gzip_bytes() -> Result<usize> {
    let web = workspace::web();
    let mut files = vec![web.join("pkg/crease_bg.wasm"), web.join("pkg/crease.js")];
    for folder in ["dist/public", "dist/internal"] {
        files.extend(scripts(&web.join(folder))?);
    }
    files.iter().map(|file| gzip_bytes(file)).sum()
}

/// The scripts in `folder`, not those in folders of it: what draws with WebGL2 is loaded only where WebGPU is missing.
fn scripts(folder: &Path) -> Result<Vec<PathBuf>> {
    let named = || format!("cannot read {}: build it with `cargo xtask build-web`", workspace::relative(folder));
    let entries = fs::read_dir(folder).with_context(named)?;
    let paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>().with_context(named)?;
    Ok(paths.into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "js")).collect())
}

fn gzip_bytes(file: &Path) -> Result<usize> {
    let bytes = fs::read(file)
        .with_context(|| format!("cannot read {}: build it with `cargo xtask build-web`", workspace::relative(file)))?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    Ok(encoder.finish()?.len())
}
