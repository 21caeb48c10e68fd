//! The element's behaviour, case by case, in one headless Chromium (web/tests/browser/).

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde_json::json;

use crate::browser::Browser;
use crate::{command, progress, workspace};

/// The tables of cases.
const FILES: [&str; 8] = [
    "./cases/time.mjs",
    "./cases/look.mjs",
    "./cases/out.mjs",
    "./cases/readers.mjs",
    "./cases/errors.mjs",
    "./cases/faults.mjs",
    "./cases/manners.mjs",
    "./cases/threads.mjs",
];

/// Long use of a page, which no test has the time for.
const SOAK: &str = "./cases/soak.mjs";

/// Cases that do not hold.
const FAILING: &str = "./failing.mjs";

/// Runs the cases whose names contain `only`. The element must have been built.
pub fn run(only: Option<&str>) -> Result<()> {
    progress::aloud("the element's behaviour", || {
        command::run(cases(&FILES, only, &[])?.stdout(Stdio::inherit()))?;
        if only.is_none() { require_failures() } else { Ok(()) }
    })
}

/// How long, and how much of what.
#[derive(clap::Args, serde::Serialize)]
pub struct SoakOptions {
    /// Avatars in the page
    #[arg(long, default_value_t = 16)]
    avatars: u32,
    /// Times that another is put in and taken out
    #[arg(long, default_value_t = 300)]
    cycles: u32,
    /// Seeks
    #[arg(long, default_value_t = 1000)]
    seeks: u32,
    /// Times that an avatar is given another address
    #[arg(long, default_value_t = 500)]
    swaps: u32,
    /// How long all of it lasts at least
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
}

/// Uses a page for long and prints what it holds, line by line. The element must have been built.
pub fn soak(options: &SoakOptions) -> Result<()> {
    let plan = serde_json::to_string(options).context("cannot write the plan")?;
    let mut node = cases(&[SOAK], None, &["--js-flags=--expose-gc"])?;
    command::run(node.env("CREASE_SOAK", plan).stdout(Stdio::inherit()))
}

/// Each of the cases that do not hold must fail, by name.
fn require_failures() -> Result<()> {
    let output = cases(&[FAILING], None, &[])?.stdout(Stdio::piped()).output().context("cannot run node")?;
    let told = String::from_utf8_lossy(&output.stdout);
    ensure!(!output.status.success(), "cases that do not hold count as passed:\n{told}");
    let failed = told.lines().filter(|line| line.starts_with("FAILED")).count();
    if failed != 3 || told.lines().any(|line| line.starts_with("ok")) {
        bail!("expected 3 cases to fail and none to pass, found:\n{told}");
    }
    Ok(())
}

/// Runs the cases of `files`, in a browser with `more` flags than the usual ones.
fn cases(files: &[&str], only: Option<&str>, more: &[&str]) -> Result<Command> {
    let order = Browser::Chromium.order(json!({ "files": files, "only": only, "more": more }))?;
    let mut node = command::program("node");
    node.arg(workspace::web().join(Path::new("tests/browser/run.mjs"))).arg(order.to_string());
    Ok(node)
}
