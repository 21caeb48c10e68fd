//! Still pictures of one pose: alike through every backend and after a lost device.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::picture::{Picture, mean_absolute_difference, require_content};
use crate::site::Site;
use crate::{browser, command, progress, serve, workspace};

/// A page whose avatar, moment and backend are in its address.
const PAGE: &str = "tests/pages/still.html";

/// Pictures of the same pose differ by no more than this on average, of 255. Measured: 3e-6 on the fixture.
const LARGEST_DIFFERENCE: f64 = 0.1;

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

struct Still {
    picture: Picture,
    backend: String,
    seconds: f64,
}

/// Draws the fixture through both ways of drawing, with and without a lost device, and compares.
pub fn run() -> Result<()> {
    let webgpu = take("webgpu+cpu", MOMENT, false)?;
    let webgl2 = take("webgl2+cpu", MOMENT, false)?;
    require_content(&webgpu.picture)?;
    ensure!(
        (webgpu.backend.as_str(), webgl2.backend.as_str()) == ("webgpu+cpu", "webgl2+cpu"),
        "asked for webgpu+cpu and webgl2+cpu, got {} and {}",
        webgpu.backend,
        webgl2.backend
    );
    let difference = require_alike(&webgpu.picture, &webgl2.picture)?;
    eprintln!("   WebGPU and WebGL2 differ by {difference:.6} of 255");
    let moved = take("webgl2+cpu", OTHER_MOMENT, false)?;
    ensure!(require_alike(&webgpu.picture, &moved.picture).is_err(), "pictures of two moments count as alike");
    for before in [webgpu, webgl2] {
        let after = take(&before.backend, MOMENT, true)?;
        ensure!(after.backend == before.backend, "{} came back as {}", before.backend, after.backend);
        ensure!(after.seconds == before.seconds, "{} s before the loss, {} s after", before.seconds, after.seconds);
        require_alike(&before.picture, &after.picture).with_context(|| format!("{}, rebuilt", after.backend))?;
    }
    Ok(())
}

fn require_alike(a: &Picture, b: &Picture) -> Result<f64> {
    let difference = mean_absolute_difference(a, b)?;
    ensure!(
        difference <= LARGEST_DIFFERENCE,
        "the pictures differ by {difference:.3} of 255 on average, expected at most {LARGEST_DIFFERENCE}"
    );
    Ok(difference)
}

fn take(backend: &str, moment: f64, lose_device: bool) -> Result<Still> {
    let site = Site::new(Path::new(PAGE))?;
    let path = format!("{}?backend={}&time={moment}", site.page_url(), backend.replace('+', "%2B"));
    let serving = serve::start(site, Some(0))?;
    let picture = workspace::wasm_target().join("still.png");
    let order = json!({
        "url": serving.url(&path),
        "chromium": browser::chromium().context("chromium is not installed")?,
        "flags": browser::FLAGS,
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
        "picture": picture,
        "loseDevice": lose_device,
    });
    let told = progress::quietly(&format!("Drawing {PAGE} with {backend}"), || {
        let mut node = command::program("node");
        command::output(node.arg(workspace::web().join("tools/still_page.mjs")).arg(order.to_string()))
    })?;
    let told: Told = serde_json::from_str(&told).context("the page's observer printed no JSON of a still")?;
    ensure!(told.problems.is_empty(), "the page has errors:\n  {}", told.problems.join("\n  "));
    let bytes = fs::read(&picture).with_context(|| format!("cannot read {}", workspace::relative(&picture)))?;
    Ok(Still {
        picture: Picture::from_png(&bytes)?,
        backend: told.backend.context("the element names no backend")?,
        seconds: told.current_time.context("the element tells no time")?,
    })
}
