//! Running the documentation's examples in headless Chromium.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use super::page::Page;
use super::template;
use crate::browser::Browser;
use crate::site::Site;
use crate::{command, files, progress, serve};

/// A software renderer on a busy machine needs its time.
const LIMIT_SECONDS: u32 = 60;

/// An example that does not run: the check must say so.
const BROKEN: &str =
    "<crease-avatar src=\"avatar.glb\"></crease-avatar>\n<script type=\"module\">noSuchFunction();</script>\n";

#[derive(Deserialize)]
struct Told {
    url: String,
    problems: Vec<String>,
}

/// Opens each example of the site in `folder`; any error in a page is one here. Then does the same with a broken one.
pub fn run(folder: &Path, pages: &[Page]) -> Result<()> {
    let examples = pages.iter().flat_map(|page| (0..page.examples.len()).map(|index| page.example_file(index)));
    let files: Vec<String> = examples.collect();
    ensure!(!files.is_empty(), "the documentation has no example");
    let name = format!("Running {} examples of the documentation", files.len());
    require_no_problem(&progress::quietly(&name, || open(folder, &files))?)?;
    let broken = "broken.html".to_owned();
    files::write(&folder.join("examples").join(&broken), template::example(&pages[0], 0, BROKEN))?;
    let told = open(folder, &[broken])?;
    ensure!(require_no_problem(&told).is_err(), "an example that throws passed the check");
    Ok(())
}

fn open(folder: &Path, files: &[String]) -> Result<Vec<Told>> {
    let serving = serve::start(Site::folder(folder)?, Some(0))?;
    let order = Browser::Chromium.order(json!({
        "urls": files.iter().map(|file| serving.url(&format!("/examples/{file}"))).collect::<Vec<_>>(),
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
    }))?;
    let told = command::output(&mut Browser::Chromium.tool("run_examples.mjs", &order))?;
    serde_json::from_str(&told).context("the runner of the examples printed no JSON")
}

fn require_no_problem(told: &[Told]) -> Result<()> {
    let lines =
        told.iter().flat_map(|page| page.problems.iter().map(move |problem| format!("{}: {problem}", page.url)));
    let lines: Vec<String> = lines.collect();
    ensure!(lines.is_empty(), "examples have errors:\n  {}", lines.join("\n  "));
    Ok(())
}
