//! `play`: build, serve, open. `play --check`: the same without a person.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use anyhow::Result;
use clap::Args;

use crate::site::Site;
use crate::{check, command, docs, serve, setup, wasm};

/// What to show, and to whom.
#[derive(Args)]
pub struct Options {
    /// Play headless, save a picture and print one JSON object; fails when the picture is blank or still
    #[arg(long)]
    check: bool,
    /// The page to show
    #[arg(long, value_name = "PATH", default_value = "index.html")]
    page: PathBuf,
    /// Where --check saves its picture
    #[arg(long, value_name = "PNG", default_value = "target/check.png")]
    screenshot: PathBuf,
    /// The port to serve on [default: 8080 or the next free one]
    #[arg(long)]
    port: Option<u16>,
    /// Do not open a browser
    #[arg(long)]
    no_open: bool,
}

/// Builds what is out of date, then shows the page until Ctrl-C, or checks it.
pub fn run(options: &Options) -> Result<()> {
    let toolchain = if options.check { setup::everything()? } else { setup::for_building()? };
    wasm::build(toolchain)?;
    wasm::build_element()?;
    if options.check {
        println!("{}", check::run(&options.page, &options.screenshot)?.to_json()?);
        return Ok(());
    }
    docs::build()?;
    let site = Site::new(&options.page)?;
    let path = site.page_url();
    serve(site, &path, options.port, !options.no_open)
}

/// Serves a site until Ctrl-C, and opens the page at `path` where there is somebody to see it.
pub fn serve(site: Site, path: &str, port: Option<u16>, opens: bool) -> Result<()> {
    let serving = serve::start_isolated(site, port)?;
    let url = serving.url(path);
    eprintln!("Serving {url} (Ctrl-C stops)");
    if opens && has_desktop() && webbrowser::open(&url).is_err() {
        eprintln!("No browser could be opened: please open the address yourself.");
    }
    while !command::interrupted() {
        thread::sleep(Duration::from_millis(100));
    }
    eprintln!("Stopped.");
    Ok(())
}

fn has_desktop() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}
