//! The accessibility scan: axe-core finds nothing on the demo and on the documentation, and something on a page that is bad.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::site::Site;
use crate::{command, serve};

const LIMIT_SECONDS: u32 = 120;

/// A page with faults that the scan must find.
const BAD_PAGE: &str = "tests/pages/inaccessible.html";

/// Width, height, dark.
const DESKTOP: (u32, u32, bool) = (1280, 800, false);
const PHONE: (u32, u32, bool) = (390, 844, true);

/// Scans. The documentation must have been built.
pub fn run() -> Result<()> {
    let found = scan(Site::new(Path::new("index.html"))?, &["/", "/docs/index.html", "/docs/element.html"])?;
    if !found.is_empty() {
        bail!("axe-core finds:\n  {}", found.join("\n  "));
    }
    let found = scan(Site::new(Path::new(BAD_PAGE))?, &[&format!("/{BAD_PAGE}")])?;
    for rule in ["image-alt", "button-name", "color-contrast"] {
        ensure!(found.iter().any(|line| line.contains(rule)), "axe-core does not find {rule} on {BAD_PAGE}: {found:?}");
    }
    Ok(())
}

/// What axe-core finds on these pages of the site, on a desktop and on a phone.
fn scan(site: Site, paths: &[&str]) -> Result<Vec<String>> {
    let serving = serve::start(site, Some(0))?;
    let pages: Vec<Value> = paths
        .iter()
        .flat_map(|path| [DESKTOP, PHONE].map(|(width, height, dark)| (path, width, height, dark)))
        .map(|(path, width, height, dark)| json!({ "url": serving.url(path), "width": width, "height": height, "dark": dark }))
        .collect();
    let order = Browser::Chromium.order(json!({ "pages": pages, "limitMilliseconds": 1000 * LIMIT_SECONDS }))?;
    let told = command::output(&mut Browser::Chromium.tool("scan_accessibility.mjs", &order))?;
    serde_json::from_str(&told).context("the accessibility scan printed no JSON")
}
