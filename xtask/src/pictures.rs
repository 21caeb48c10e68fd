//! `pictures`: draws what the demo's shelf shows, into demo/pictures/.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::site::Site;
use crate::{command, progress, serve, setup, wasm, workspace};

const PAGE: &str = "tests/pages/picture.html";

/// All of them together, bytes: they come before anything else of the page's pictures.
const MOST_BYTES: u64 = 100_000;

const LIMIT_SECONDS: u32 = 120;

#[derive(Deserialize)]
struct Made {
    file: PathBuf,
    bytes: u64,
}

/// Builds what is out of date, draws every picture, and tells how large they are.
pub fn run() -> Result<()> {
    let toolchain = setup::everything()?;
    wasm::build(toolchain)?;
    wasm::build_element()?;
    let site = Site::new(Path::new(PAGE))?;
    let path = site.page_url();
    let serving = serve::start(site, Some(0))?;
    let order = Browser::Chromium.order(json!({
        "url": serving.url(&path),
        "folder": workspace::root().join("demo/pictures"),
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
    }))?;
    let told = progress::quietly("Drawing the demo's pictures", || {
        command::output(&mut Browser::Chromium.tool("make_pictures.mjs", &order))
    })?;
    let made: Vec<Made> = serde_json::from_str(&told).context("the painter of pictures printed no JSON")?;
    for Made { file, bytes } in &made {
        println!("{}: {bytes} bytes", workspace::relative(file));
    }
    let total: u64 = made.iter().map(|picture| picture.bytes).sum();
    ensure!(total <= MOST_BYTES, "the pictures have {total} bytes, expected at most {MOST_BYTES}");
    Ok(())
}
