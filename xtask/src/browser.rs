//! The browsers of the tests: where they are, and what lets them draw without a graphics card and without a screen.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::{command, workspace};

/// With fewer of these the adapter is null or the canvas stays blank.
pub const FLAGS: [&str; 12] = [
    "--headless=new",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--enable-unsafe-webgpu",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/// A browser that the tools of web/tools/ open pages in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Browser {
    /// Headless, with WebGPU.
    Chromium,
    /// On a virtual screen: without one it has no WebGL. It has no WebGPU.
    Firefox,
}

impl Browser {
    /// What a tool has to know to start it: members of the tool's order, to which `about` is added.
    pub fn order(self, mut about: Value) -> Result<Value> {
        let members = match self {
            Browser::Chromium => {
                serde_json::json!({ "chromium": chromium().context("chromium is not installed")?, "flags": FLAGS })
            }
            Browser::Firefox => serde_json::json!({ "firefox": firefox().context("Firefox is not installed")? }),
        };
        let about_members = about.as_object_mut().context("an order is an object")?;
        about_members.extend(members.as_object().cloned().unwrap_or_default());
        Ok(about)
    }

    /// A tool of web/tools/, with a screen where this browser needs one.
    pub fn tool(self, name: &str, order: &Value) -> Command {
        let mut command = match self {
            Browser::Chromium => command::program("node"),
            Browser::Firefox => {
                let mut command = command::program("xvfb-run");
                command.args(["--auto-servernum", "node"]).env("LIBGL_ALWAYS_SOFTWARE", "1");
                command
            }
        };
        command.arg(workspace::web().join("tools").join(name)).arg(order.to_string());
        command
    }
}

/// Firefox, under the names that systems give it.
pub fn firefox() -> Option<PathBuf> {
    ["firefox-esr", "firefox"].into_iter().find_map(command::find)
}

/// Chromium, under the names that systems give it.
pub fn chromium() -> Option<PathBuf> {
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(command::find)
}

/// Where Debian's and Google's packages put Chromium's libraries.
const LIBRARY_FOLDERS: [&str; 3] = ["/usr/lib/chromium", "/usr/lib/chromium-browser", "/opt/google/chrome"];

/// Lets native tests find the software GPU that Chromium brings along (and its Vulkan loader), after the machine's own GPUs.
pub fn lend_software_gpu(command: &mut Command) {
    let manifest = |folder: &&str| Path::new(folder).join("vk_swiftshader_icd.json");
    if let Some(folder) = LIBRARY_FOLDERS.iter().find(|folder| manifest(folder).is_file()) {
        command.env("VK_ADD_DRIVER_FILES", manifest(folder)).env("LD_LIBRARY_PATH", folder);
    }
}

/// The program through which wasm tests steer Chromium.
pub fn driver() -> Option<PathBuf> {
    command::find("chromedriver")
}

/// Sets up a wasm `cargo test` so that its tests run in headless Chromium, steered by this very program.
pub fn configure_wasm_tests(cargo: &mut Command) -> Result<()> {
    let this_program = std::env::current_exe().context("cannot find the task runner itself")?;
    let runner = serde_json::json!([this_program, "wasm-test-runner"]);
    // A JSON list of strings is a TOML list too.
    cargo.arg("--config").arg(format!("target.wasm32-unknown-unknown.runner={runner}"));

    let chromium = chromium().context("chromium is not installed")?;
    let driver = driver().context("chromedriver is not installed")?;
    let capabilities = serde_json::json!({ "goog:chromeOptions": { "binary": chromium, "args": FLAGS } });
    let file = workspace::wasm_target().join("webdriver.json");
    fs::write(&file, capabilities.to_string())
        .with_context(|| format!("cannot write {}", workspace::relative(&file)))?;
    cargo.env("WASM_BINDGEN_TEST_WEBDRIVER_JSON", file).env("CHROMEDRIVER", driver);
    // The browser may start slowly on a busy machine.
    cargo.env("WASM_BINDGEN_TEST_DRIVER_TIMEOUT", "60").env("WASM_BINDGEN_TEST_TIMEOUT", "300");
    Ok(())
}

/// wasm-bindgen's test runner, of the version that Cargo.lock pins.
pub fn run_wasm_tests(arguments: Vec<OsString>) -> Result<()> {
    let name = OsString::from("wasm-bindgen-test-runner");
    wasm_bindgen_cli::wasm_bindgen_test_runner::run_cli_with_args(std::iter::once(name).chain(arguments))
}
