//! What a page downloads before an avatar can play, apart from the avatar.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::{files, workspace};

/// Scripts that draw with WebGL2: loaded only where WebGPU is missing.
const WEBGL2_SCRIPTS: &str = "painter-";

/// What that may be at most, each file gzipped.
const RUNTIME_GZIP_LIMIT: usize = 250_000;

/// An error where the runtime has outgrown its limit.
pub fn check() -> Result<()> {
    let bytes = runtime_gzip_bytes()?;
    require_within(bytes, RUNTIME_GZIP_LIMIT)?;
    ensure!(require_within(bytes, bytes - 1).is_err(), "a limit below the runtime's size counts as kept");
    eprintln!("   {bytes} bytes gzipped, of {RUNTIME_GZIP_LIMIT} allowed");
    Ok(())
}

fn require_within(bytes: usize, limit: usize) -> Result<()> {
    ensure!(
        bytes <= limit,
        "web/lib: expected at most {limit} bytes, gzipped, of module and scripts where WebGPU draws, found {bytes}"
    );
    Ok(())
}

/// Bytes of the wasm module and of the scripts that load where WebGPU draws, each file gzipped as servers do.
pub fn runtime_gzip_bytes() -> Result<usize> {
    files::below(&workspace::web().join("lib"))
        .context("build it with `cargo xtask build-web`")?
        .iter()
        .filter(|file| is_of_every_page(file))
        .map(|file| gzip_bytes(file))
        .sum()
}

fn is_of_every_page(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    (name.ends_with(".js") || name.ends_with(".wasm")) && !name.starts_with(WEBGL2_SCRIPTS)
}

fn gzip_bytes(file: &Path) -> Result<usize> {
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    Ok(encoder.finish()?.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_kept_or_both_numbers_are_told() {
        assert!(require_within(RUNTIME_GZIP_LIMIT, RUNTIME_GZIP_LIMIT).is_ok());
        let error = require_within(RUNTIME_GZIP_LIMIT + 1, RUNTIME_GZIP_LIMIT).unwrap_err().to_string();
        assert!(error.contains("250000") && error.contains("250001"), "{error}");
    }

    #[test]
    fn scripts_of_webgl2_and_source_maps_do_not_count() {
        for (name, counts) in
            [("worker.js", true), ("crease_bg.wasm", true), ("painter-A1.js", false), ("worker.js.map", false)]
        {
            assert_eq!(is_of_every_page(Path::new(name)), counts, "{name}");
        }
    }
}
