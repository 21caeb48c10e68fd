//! `demo`: uses the demo page as a visitor does, and takes its screenshots.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::site::Site;
use crate::{accessibility, command, docs, progress, serve, setup, wasm, workspace};

const LIMIT_SECONDS: u32 = 90;

#[derive(Deserialize)]
struct Told {
    problems: Vec<String>,
    screenshots: Vec<std::path::PathBuf>,
}

/// Builds what is out of date, checks the page and scans it for accessibility.
pub fn run() -> Result<()> {
    let toolchain = setup::everything()?;
    wasm::build(toolchain)?;
    wasm::build_element()?;
    docs::build()?;
    check()?;
    progress::quietly("Scanning for accessibility", accessibility::run)
}

/// Goes through the page step by step; screenshots lie in target/demo/ afterwards.
pub fn check() -> Result<()> {
    let root = workspace::root();
    let folder = root.join("target/demo");
    fs::create_dir_all(&folder).context("cannot make target/demo")?;
    let serving = serve::start_isolated(Site::new(Path::new("index.html"))?, Some(0))?;
    let order = Browser::Chromium.order(json!({
        "url": serving.url("/"),
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
        "folder": folder,
        "avatar": root.join("tests/fixtures/tiny.glb"),
        "motion": root.join("tests/fixtures/pickles/motion-numpy2.pkl"),
    }))?;
    let told = progress::quietly("Using the demo page", || {
        command::output(&mut Browser::Chromium.tool("exercise_demo.mjs", &order))
    })?;
    let told: Told = serde_json::from_str(&told).context("the demo's visitor printed no JSON")?;
    for file in &told.screenshots {
        eprintln!("   {}", workspace::relative(file));
    }
    ensure!(told.problems.is_empty(), "the demo page has errors:\n  {}", told.problems.join("\n  "));
    Ok(())
}
