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

/// What an isolated page loads for its threads: a module in place of the usual one, and scripts more.
const THREADS_FILES: [&str; 2] = ["crease_threads", "thread.js"];

/// The usual module, which an isolated page does not load.
const USUAL_MODULE: &str = "crease_bg.wasm";

/// What a page may load at most, each file gzipped, without threads and with them.
const RUNTIME_GZIP_LIMIT: usize = 250_000;
const THREADS_RUNTIME_GZIP_LIMIT: usize = 270_000;

/// An error where the runtime has outgrown its limit.
pub fn check() -> Result<()> {
    let sizes = [(runtime_gzip_bytes()?, RUNTIME_GZIP_LIMIT), (threads_gzip_bytes()?, THREADS_RUNTIME_GZIP_LIMIT)];
    for ((bytes, limit), kind) in sizes.into_iter().zip(["", ", with threads"]) {
        require_within(bytes, limit)?;
        ensure!(require_within(bytes, bytes - 1).is_err(), "a limit below the runtime's size counts as kept");
        eprintln!("   {bytes} bytes gzipped, of {limit} allowed{kind}");
    }
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
    gzip_bytes_of(is_of_every_page)
}

/// The same in an isolated page, where frames have several threads.
pub fn threads_gzip_bytes() -> Result<usize> {
    gzip_bytes_of(is_of_isolated_pages)
}

fn gzip_bytes_of(is_loaded: impl Fn(&str) -> bool) -> Result<usize> {
    files::below(&workspace::web().join("lib"))
        .context("build it with `cargo xtask build-web`")?
        .iter()
        .filter(|file| is_loaded(&file.file_name().unwrap_or_default().to_string_lossy()))
        .map(|file| gzip_bytes(file))
        .sum()
}

fn is_of_every_page(name: &str) -> bool {
    is_for_webgpu(name) && !THREADS_FILES.iter().any(|start| name.starts_with(start))
}

fn is_of_isolated_pages(name: &str) -> bool {
    is_for_webgpu(name) && name != USUAL_MODULE
}

fn is_for_webgpu(name: &str) -> bool {
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
    fn what_a_page_does_not_load_does_not_count() {
        for (name, of_every_page, of_isolated_pages) in [
            ("worker.js", true, true),
            ("crease_bg.wasm", true, false),
            ("crease_threads_bg.wasm", false, true),
            ("crease_threads-A1.js", false, true),
            ("thread.js", false, true),
            ("painter-A1.js", false, false),
            ("worker.js.map", false, false),
            ("crease_bg.symbols", false, false),
        ] {
            assert_eq!(
                (is_of_every_page(name), is_of_isolated_pages(name)),
                (of_every_page, of_isolated_pages),
                "{name}"
            );
        }
    }
}
