//! Golden pictures: the fixture avatar in each view looks as it did when somebody last looked at it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use crate::browser::Browser;
use crate::{command, stills, workspace};

/// Of a picture that looks the same, at most this share of the pixels differs to the eye.
const SURFACE_SHARE: f64 = 0.002;

/// Graphics drivers smooth thin lines in their own ways.
const LINE_SHARE: f64 = 0.04;

/// The views of the element, each with a picture in tests/goldens/.
const VIEWS: [(&str, f64); 6] = [
    ("detailed", SURFACE_SHARE),
    ("base", SURFACE_SHARE),
    ("body", SURFACE_SHARE),
    ("wireframe", LINE_SHARE),
    ("normals", SURFACE_SHARE),
    ("laplacian", SURFACE_SHARE),
];

/// Width and height of a golden, pixels.
const SIDE: u32 = 240;

/// What compares two pictures as an eye would.
#[derive(Deserialize)]
struct Told {
    /// Pixels that differ visibly; edges that are only smoothed otherwise do not count.
    different: u64,
    pixels: u64,
}

/// Draws the goldens anew. Look at them before they are committed.
pub fn write() -> Result<()> {
    fs::create_dir_all(golden("x").parent().context("a file without a folder")?)?;
    for (view, _) in VIEWS {
        draw(Browser::Chromium, view, &golden(view))?;
        eprintln!("   {}", workspace::relative(&golden(view)));
    }
    Ok(())
}

/// Draws each view in each browser and compares it with its golden; and two views with each other, which must differ.
pub fn check() -> Result<()> {
    for browser in [Browser::Chromium, Browser::Firefox] {
        for (view, share) in VIEWS {
            let found = workspace::wasm_target().join(format!("golden-{view}.png"));
            draw(browser, view, &found)?;
            require_alike(&golden(view), &found, share).with_context(|| format!("{view} in {browser:?}"))?;
        }
    }
    for (one, other, share) in
        [("detailed", "base", SURFACE_SHARE), ("base", "body", SURFACE_SHARE), ("wireframe", "detailed", LINE_SHARE)]
    {
        let alike = require_alike(&golden(one), &golden(other), share);
        ensure!(alike.is_err(), "the pictures of {one} and {other} count as alike");
    }
    Ok(())
}

fn golden(view: &str) -> PathBuf {
    workspace::root().join(format!("tests/goldens/{view}.png"))
}

fn draw(browser: Browser, view: &str, file: &Path) -> Result<()> {
    let query = format!("view={view}&motion=&time=0&theme=light&quality=best&size={SIDE}");
    stills::still(browser, &query, file, Some(SIDE), false).map(drop)
}

fn require_alike(golden: &Path, found: &Path, largest_share: f64) -> Result<()> {
    let tool = workspace::web().join("tools/compare_pictures.mjs");
    let told = command::output(command::program("node").arg(tool).args([golden, found]))?;
    let Told { different, pixels } =
        serde_json::from_str(&told).context("the comparison of pictures printed no JSON")?;
    let share = different as f64 / pixels as f64;
    eprintln!("   {}: {different} of {pixels} pixels differ", workspace::relative(found));
    ensure!(
        share <= largest_share,
        "{} does not look like {}: {:.2} % of the pixels differ, expected at most {:.2} %. If that is meant, run `cargo xtask goldens`.",
        workspace::relative(found),
        workspace::relative(golden),
        100.0 * share,
        100.0 * largest_share
    );
    Ok(())
}
