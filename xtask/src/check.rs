//! The check of a page: it plays in a browser, shows something, moves, and reports no error.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde::Serialize;
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::picture::{Picture, Region, require_content, require_motion};
use crate::site::Site;
use crate::{command, progress, serve, workspace};

/// Frames that a page must draw.
const FRAMES: u32 = 60;

/// A software renderer on a busy machine needs its time.
const LIMIT_SECONDS: u32 = 240;

/// What `play --check` reports.
#[derive(Debug, Serialize)]
pub struct Report {
    #[serde(rename = "first_frame_ms")]
    first_frame_milliseconds: f64,
    frames: u64,
    #[serde(rename = "frame_ms_median")]
    frame_milliseconds: f64,
    backend: String,
    screenshot: String,
}

impl Report {
    /// What computed and what drew.
    pub fn backend(&self) -> &str {
        &self.backend
    }

    /// One JSON object on one line.
    pub fn to_json(&self) -> Result<String> {
        serde_json::to_string(self).context("cannot write the report")
    }
}

/// Plays a page (its path relative to the root) and saves the later of two pictures. The page must have been built.
pub fn run(page: &Path, screenshot: &Path) -> Result<Report> {
    play(Site::new(page)?, Browser::Chromium, FRAMES, screenshot)
}

/// Plays a site's page for that many frames and saves the later of two pictures.
pub fn play(site: Site, browser: Browser, frames: u32, screenshot: &Path) -> Result<Report> {
    let after = workspace::root().join(screenshot);
    let before = after.with_extension("before.png");
    let told = observe(site, "", browser, frames, [&before, &after])?;
    let region = region(&told["region"]).context("the page's observer named no region")?;
    let look = |file: &Path| -> Result<Picture> {
        let bytes = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
        Picture::from_png(&bytes)?.crop(region)
    };
    let (first, second) = (look(&before)?, look(&after)?);
    fs::remove_file(&before).with_context(|| format!("cannot remove {}", workspace::relative(&before)))?;
    require_content(&first)?;
    require_content(&second)?;
    require_motion(&first, &second)?;
    report(&told["statistics"], frames, workspace::relative(&after))
}

/// The element's statistics after `frames` frames of a page (its path relative to the root, and `query` to go with it).
pub fn statistics(page: &Path, query: &str, frames: u32) -> Result<Value> {
    let picture = workspace::root().join("target/bench.png");
    let mut told = observe(Site::new(page)?, query, Browser::Chromium, frames, [&picture, &picture])?;
    Ok(told["statistics"].take())
}

/// Plays a page and takes a picture half-way and at the end; returns what its observer saw, which is no problem.
fn observe(site: Site, query: &str, browser: Browser, frames: u32, [before, after]: [&Path; 2]) -> Result<Value> {
    let path = site.page_url() + query;
    let serving = serve::start(site, Some(0))?;
    let order = browser.order(json!({
        "url": serving.url(&path),
        "frames": frames,
        "limitMilliseconds": 1000 * LIMIT_SECONDS,
        "before": before,
        "after": after,
    }))?;
    let told = progress::quietly(&format!("Playing {path} in {browser:?}"), || {
        command::output(&mut browser.tool("watch_page.mjs", &order))
    })?;
    let told: Value = serde_json::from_str(&told).context("the page's observer printed no JSON")?;
    require_no_problem(&told)?;
    Ok(told)
}

/// Turns what went wrong in the page, all of it, into one error.
fn require_no_problem(told: &Value) -> Result<()> {
    let problems = told["problems"].as_array().context("the page's observer listed no problems")?;
    let texts: Vec<&str> = problems.iter().filter_map(Value::as_str).collect();
    ensure!(texts.is_empty(), "the page has errors:\n  {}", texts.join("\n  "));
    Ok(())
}

fn region(told: &Value) -> Option<Region> {
    let number = |name: &str| told[name].as_f64().filter(|value| *value >= 0.0).map(|value| value.round() as usize);
    Some(Region { x: number("x")?, y: number("y")?, width: number("width")?, height: number("height")? })
}

fn report(statistics: &Value, wanted: u32, screenshot: String) -> Result<Report> {
    let number = |name: &str| {
        let value = statistics[name].as_f64().filter(|value| value.is_finite());
        value.with_context(|| format!("element.statistics.{name}: expected a number, found {}", statistics[name]))
    };
    let Some(backend) = statistics["backend"].as_str().filter(|name| !name.is_empty()) else {
        bail!("element.statistics.backend: expected a name, found {}", statistics["backend"]);
    };
    let frames = number("frames")? as u64;
    ensure!(frames >= u64::from(wanted), "element.statistics.frames: expected at least {wanted}, found {frames}");
    Ok(Report {
        first_frame_milliseconds: to_tenths(number("firstFrameMilliseconds")?),
        frames,
        frame_milliseconds: to_tenths(number("frameMilliseconds")?),
        backend: backend.to_owned(),
        screenshot,
    })
}

/// Browsers give times to a tenth of a millisecond at best.
fn to_tenths(milliseconds: f64) -> f64 {
    (10.0 * milliseconds).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics() -> Value {
        json!({ "frames": 61, "firstFrameMilliseconds": 812.4600000001, "frameMilliseconds": 16.7, "backend": "WebGPU" })
    }

    #[test]
    fn the_report_is_one_json_object_with_the_promised_fields() {
        let text = report(&statistics(), FRAMES, "target/check.png".to_owned()).unwrap().to_json().unwrap();
        let expected = json!({
            "first_frame_ms": 812.5, "frames": 61, "frame_ms_median": 16.7, "backend": "WebGPU",
            "screenshot": "target/check.png",
        });
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), expected);
        assert!(!text.contains('\n'));
    }

    #[test]
    fn missing_and_wrong_statistics_are_named() {
        for (name, value) in [("frames", json!(59)), ("frameMilliseconds", Value::Null), ("backend", json!(""))] {
            let mut broken = statistics();
            broken[name] = value;
            let error = report(&broken, FRAMES, String::new()).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }

    #[test]
    fn every_problem_of_the_page_is_told() {
        assert!(require_no_problem(&json!({ "problems": [] })).is_ok());
        let error = require_no_problem(&json!({ "problems": ["no adapter", "404 avatar.glb"] })).unwrap_err();
        assert!(error.to_string().contains("no adapter") && error.to_string().contains("404 avatar.glb"));
        assert!(require_no_problem(&json!({})).is_err());
    }

    #[test]
    fn a_region_needs_all_its_numbers() {
        let told = json!({ "x": 0, "y": 8.4, "width": 640, "height": 480 });
        assert_eq!(region(&told), Some(Region { x: 0, y: 8, width: 640, height: 480 }));
        assert_eq!(region(&json!({ "x": 0, "y": -8, "width": 640, "height": 480 })), None);
        assert_eq!(region(&Value::Null), None);
    }
}
