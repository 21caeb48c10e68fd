//! A graphics device that is lost while the avatar plays: rebuilt, and the motion goes on from where it was.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::picture::{Picture, require_content};
use crate::site::Site;
use crate::{command, progress, serve, workspace};

/// A page whose avatar and backend are in its address. The motion is slow, so that it does not end meanwhile.
const PAGE: &str = "tests/pages/still.html";
const QUERY: &str = "autoplay&time=0&fps=0.02";

const LIMIT_SECONDS: u32 = 120;

/// Seconds of the motion that may pass between the last picture before the loss and the first one after it: those of a few slow pictures
/// before the loss is noticed. While the device is rebuilt time stands.
const LARGEST_STEP: f64 = 3.0;

/// What happened, in seconds of the motion.
#[derive(Clone, Debug, Deserialize)]
struct Told {
    problems: Vec<String>,
    backend: Option<String>,
    #[serde(default)]
    before: f64,
    #[serde(default)]
    after: f64,
    #[serde(default)]
    later: f64,
    #[serde(default)]
    milliseconds: f64,
    #[serde(default)]
    playing: bool,
}

/// Loses the device of every backend in mid-play but `webgpu`, whose passes take seconds a picture on a software adapter.
pub fn run() -> Result<()> {
    for backend in ["webgpu+cpu", "webgl2+cpu"] {
        let milliseconds = lose(backend).with_context(|| format!("{backend}, lost in mid-play"))?;
        eprintln!("   {backend}: playing again {milliseconds:.0} ms after the device was lost");
    }
    Ok(())
}

/// Returns the milliseconds from the loss to the next picture.
fn lose(backend: &str) -> Result<f64> {
    let site = Site::new(Path::new(PAGE))?;
    let path = format!("{}?{QUERY}&backend={}", site.page_url(), backend.replace('+', "%2B"));
    let serving = serve::start(site, Some(0))?;
    let picture = workspace::wasm_target().join("loss.png");
    let order = Browser::Chromium.order(json!({
        "url": serving.url(&path),
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
        "picture": picture,
    }))?;
    let told = progress::quietly(&format!("Losing the device of {backend}"), || {
        command::output(&mut Browser::Chromium.tool("loss_page.mjs", &order))
    })?;
    let told: Told = serde_json::from_str(&told).context("the page's observer printed no JSON of a loss")?;
    require_continued(&told, backend)?;
    let bytes = fs::read(&picture).with_context(|| format!("cannot read {}", workspace::relative(&picture)))?;
    require_content(&Picture::from_png(&bytes)?)?;
    Ok(told.milliseconds)
}

/// An error unless the same backend plays on from where it was.
fn require_continued(told: &Told, backend: &str) -> Result<()> {
    let Told { problems, backend: found, before, after, later, playing, .. } = told;
    ensure!(problems.is_empty(), "the page has errors:\n  {}", problems.join("\n  "));
    ensure!(found.as_deref() == Some(backend), "the page runs {found:?}, expected {backend}");
    ensure!(
        (0.0..=LARGEST_STEP).contains(&(after - before)),
        "the motion was at {before:.3} s before the loss and at {after:.3} s after it"
    );
    ensure!(*playing && later > after, "the motion stands at {after:.3} s, and {later:.3} s some pictures later");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told() -> Told {
        let backend = Some("webgpu".to_owned());
        Told { problems: vec![], backend, before: 1.2, after: 1.4, later: 1.9, milliseconds: 300.0, playing: true }
    }

    #[test]
    fn a_motion_that_goes_on_is_accepted() {
        require_continued(&told(), "webgpu").unwrap();
    }

    #[test]
    fn a_motion_that_starts_again_stands_or_jumps_is_not() {
        let wrong = [
            (Told { after: 0.0, later: 0.5, ..told() }, "before the loss"),
            (Told { after: 9.0, later: 9.5, ..told() }, "before the loss"),
            (Told { later: 1.4, ..told() }, "stands"),
            (Told { playing: false, ..told() }, "stands"),
            (Told { backend: Some("webgl2+cpu".into()), ..told() }, "expected webgpu"),
            (Told { problems: vec!["no picture".into()], ..told() }, "no picture"),
        ];
        for (told, reason) in wrong {
            let error = require_continued(&told, "webgpu").unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
