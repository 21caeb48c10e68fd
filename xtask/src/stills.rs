//! Still pictures of one pose: alike through every backend and after a lost device.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::picture::{Picture, mean_absolute_difference, require_content};
use crate::site::Site;
use crate::{command, progress, serve, workspace};

/// A page whose avatar, moment and backend are in its address.
const PAGE: &str = "tests/pages/still.html";

/// Pictures of the same pose differ by no more than this on average, of 255. Measured: 6e-5 on the fixture.
const LARGEST_DIFFERENCE: f64 = 0.1;

/// Names of the levels of quality, best first, and how far the picture of each may be from that of the one before, of 255: where quality
/// changes in mid-play nobody should see it. Measured: 0.015, 0.07, 0.54 and 0.77; of the last two a smaller picture scaled up makes most.
const QUALITIES: [(&str, f64); 5] = [("best", 0.0), ("high", 0.05), ("medium", 0.2), ("low", 0.9), ("lowest", 1.2)];

const LIMIT_SECONDS: u32 = 120;

/// The moment that is drawn, seconds: the fixture is in the middle of the picture.
const MOMENT: f64 = 0.0;
const OTHER_MOMENT: f64 = 0.1;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Told {
    problems: Vec<String>,
    backend: Option<String>,
    current_time: Option<f64>,
}

/// A picture of one moment.
pub struct Still {
    picture: Picture,
    /// What drew it.
    pub backend: String,
    seconds: f64,
}

/// The fixtures: compact tables, and plain perceptrons.
const AVATARS: [&str; 2] = ["../fixtures/tiny.glb", "../fixtures/tiny_plain.glb"];

/// Poses and draws both fixtures in every way there is, with and without a lost device, and compares.
pub fn run() -> Result<()> {
    for avatar in AVATARS {
        let expected = take(avatar, "webgpu+cpu", MOMENT, false)?;
        require_content(&expected.picture)?;
        for backend in ["webgl2+cpu", "webgpu"] {
            let found = take(avatar, backend, MOMENT, false)?;
            let difference = require_alike(&expected.picture, &found.picture, LARGEST_DIFFERENCE)
                .with_context(|| format!("{avatar}: {backend} against webgpu+cpu"))?;
            eprintln!("   {avatar}: {backend} and webgpu+cpu differ by {difference:.6} of 255");
        }
    }
    compare_qualities("webgpu")?;
    let [avatar, plain] = AVATARS;
    for backend in ["webgpu+cpu", "webgl2+cpu"] {
        let before = take(avatar, backend, MOMENT, false)?;
        let after = take(avatar, backend, MOMENT, true)?;
        ensure!(after.seconds == before.seconds, "{} s before the loss, {} s after", before.seconds, after.seconds);
        require_alike(&before.picture, &after.picture, LARGEST_DIFFERENCE)
            .with_context(|| format!("{backend}, rebuilt"))?;
        for (avatar, moment) in [(avatar, OTHER_MOMENT), (plain, MOMENT)] {
            let other = take(avatar, backend, moment, false)?;
            let alike = require_alike(&before.picture, &other.picture, LARGEST_DIFFERENCE);
            ensure!(alike.is_err(), "different pictures count as alike");
        }
    }
    Ok(())
}

/// Draws the first fixture at every level of quality: neighbours look alike.
fn compare_qualities(backend: &str) -> Result<()> {
    let mut better: Option<Picture> = None;
    for (quality, largest) in QUALITIES {
        let still = take_with(AVATARS[0], backend, MOMENT, &format!("&quality={quality}"), false)?;
        if let Some(better) = better {
            let difference = require_alike(&better, &still.picture, largest)
                .with_context(|| format!("{backend}: quality {quality} against the level above it"))?;
            eprintln!("   {backend}: quality {quality} and the level above it differ by {difference:.3} of 255");
        }
        better = Some(still.picture);
    }
    Ok(())
}

fn require_alike(a: &Picture, b: &Picture, largest: f64) -> Result<f64> {
    let difference = mean_absolute_difference(a, b)?;
    ensure!(
        difference <= largest,
        "the pictures differ by {difference:.3} of 255 on average, expected at most {largest}"
    );
    Ok(difference)
}

fn take(avatar: &str, backend: &str, moment: f64, lose_device: bool) -> Result<Still> {
    take_with(avatar, backend, moment, "", lose_device)
}

fn take_with(avatar: &str, backend: &str, moment: f64, more: &str, lose_device: bool) -> Result<Still> {
    let query = format!("avatar={avatar}&backend={}&time={moment}{more}", backend.replace('+', "%2B"));
    let still = still(Browser::Chromium, &query, &workspace::wasm_target().join("still.png"), None, lose_device)?;
    ensure!(still.backend == backend, "asked for {backend}, the page runs {}", still.backend);
    Ok(still)
}

/// Draws the page with `query` in its address and saves the picture, `side` pixels wide and high, after the graphics device was taken away
/// where `lose_device`.
pub fn still(browser: Browser, query: &str, file: &Path, side: Option<u32>, lose_device: bool) -> Result<Still> {
    let site = Site::new(Path::new(PAGE))?;
    let path = format!("{}?{query}", site.page_url());
    let serving = serve::start(site, Some(0))?;
    let order = browser.order(json!({
        "url": serving.url(&path),
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
        "picture": file,
        "side": side,
        "loseDevice": lose_device,
    }))?;
    let told = progress::quietly(&format!("Drawing {path} in {browser:?}"), || {
        command::output(&mut browser.tool("still_page.mjs", &order))
    })?;
    let told: Told = serde_json::from_str(&told).context("the page's observer printed no JSON of a still")?;
    ensure!(told.problems.is_empty(), "the page has errors:\n  {}", told.problems.join("\n  "));
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
    Ok(Still {
        picture: Picture::from_png(&bytes)?,
        backend: told.backend.context("the element names no backend")?,
        seconds: told.current_time.context("the element tells no time")?,
    })
}
