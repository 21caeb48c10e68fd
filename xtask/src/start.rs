//! How a page starts: the base first, its detail right after; and on an adapter that grants too little.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::json;

use crate::browser::Browser;
use crate::site::Site;
use crate::{command, progress, serve};

/// A page whose quality, backend and adapter are in its address.
const PAGE: &str = "tests/pages/start.html";

const LIMIT_SECONDS: u32 = 120;

/// The limit of WebGPU that the page fakes.
const FAKED_LIMIT: &str = "maxStorageBufferBindingSize";

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Told {
    problems: Vec<String>,
    backend: String,
    warnings: Vec<String>,
    at_load: Statistics,
    after: Statistics,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Statistics {
    first_frame_milliseconds: Option<f64>,
    first_detail_milliseconds: Option<f64>,
}

/// Starts the fixture in each way and looks at what is shown when.
pub fn run() -> Result<()> {
    for backend in ["webgpu%2Bcpu", "webgl2%2Bcpu", "webgpu"] {
        let told = start(&format!("?backend={backend}"))?;
        require_base_first(&told).with_context(|| format!("backend={backend}"))?;
        require_no_warning(&told)?;
    }
    // A quality that is demanded holds from the first picture on; and the check above can fail.
    let demanded = start("?backend=webgpu%2Bcpu&quality=best")?;
    ensure!(require_base_first(&demanded).is_err(), "quality=best: the first picture is of the base");

    let limited = start(&format!("?backend=webgpu&limit={FAKED_LIMIT}"))?;
    require_told_once(&limited, FAKED_LIMIT, "webgpu+cpu")?;
    ensure!(require_no_warning(&limited).is_err(), "a warning was overlooked");
    Ok(())
}

fn require_base_first(told: &Told) -> Result<()> {
    let Told { at_load, after, .. } = told;
    let first = at_load.first_frame_milliseconds.context("the first picture has no moment")?;
    ensure!(at_load.first_detail_milliseconds.is_none(), "the first picture waited for its detail");
    let detail = after.first_detail_milliseconds.context("the first picture with detail has no moment")?;
    ensure!(first <= detail, "the base came after {first} ms, its detail after {detail} ms");
    Ok(())
}

fn require_no_warning(told: &Told) -> Result<()> {
    ensure!(told.warnings.is_empty(), "the page warns:\n  {}", told.warnings.join("\n  "));
    Ok(())
}

/// The page fell to `backend`, and said why, once.
fn require_told_once(told: &Told, reason: &str, backend: &str) -> Result<()> {
    ensure!(told.backend == backend, "expected {backend} at work, found {}", told.backend);
    let [warning] = &told.warnings[..] else {
        bail!("expected one warning, found {:?}", told.warnings);
    };
    ensure!(warning.contains(reason) && warning.contains(backend), "expected {reason} and {backend} in {warning:?}");
    Ok(())
}

fn start(query: &str) -> Result<Told> {
    let site = Site::new(Path::new(PAGE))?;
    let path = site.page_url() + query;
    let serving = serve::start(site, Some(0))?;
    let order = json!({ "url": serving.url(&path), "limitMilliseconds": 1000 * LIMIT_SECONDS });
    let order = Browser::Chromium.order(order)?;
    let told = progress::quietly(&format!("Starting {PAGE}{query}"), || {
        command::output(&mut Browser::Chromium.tool("start_page.mjs", &order))
    })?;
    let told: Told = serde_json::from_str(&told).with_context(|| format!("{PAGE}{query} told {told}"))?;
    ensure!(told.problems.is_empty(), "{PAGE}{query} has errors:\n  {}", told.problems.join("\n  "));
    Ok(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(at_load: (Option<f64>, Option<f64>), after: f64, warnings: &[&str]) -> Told {
        let statistics =
            |(first, detail)| Statistics { first_frame_milliseconds: first, first_detail_milliseconds: detail };
        Told {
            problems: vec![],
            backend: "webgpu+cpu".to_owned(),
            warnings: warnings.iter().map(|&warning| warning.to_owned()).collect(),
            at_load: statistics(at_load),
            after: statistics((at_load.0, Some(after))),
        }
    }

    #[test]
    fn a_first_picture_that_waits_is_found() {
        assert!(require_base_first(&told((Some(10.0), None), 20.0, &[])).is_ok());
        for (at_load, after) in [((Some(10.0), Some(10.0)), 10.0), ((None, None), 20.0), ((Some(30.0), None), 20.0)] {
            assert!(require_base_first(&told(at_load, after, &[])).is_err());
        }
    }

    #[test]
    fn a_reason_must_be_told_and_only_once() {
        let reason = "webgpu: maxFoo is 1. Using webgpu+cpu instead.";
        let of = |warnings: &[&str]| require_told_once(&told((None, None), 0.0, warnings), "maxFoo", "webgpu+cpu");
        assert!(of(&[reason]).is_ok());
        for warnings in [&[][..], &[reason, reason], &["another reason"]] {
            assert!(of(warnings).is_err(), "{warnings:?}");
        }
    }
}
