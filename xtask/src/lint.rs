//! The lints: rustfmt, clippy, biome, tsc.

use std::process::Command;

use anyhow::Result;

use crate::toolchain::Toolchain;
use crate::{command, progress, wasm};

/// Beside the default features: what native tests look at.
pub const FEATURES: [&str; 2] = ["--features", "crease/fixture,crease/render,crease/gpu,crease/threads"];

/// Runs every lint; the first that complains ends it. The wasm bindings must have been built: tsc reads their types.
pub fn run(toolchain: Toolchain) -> Result<()> {
    components()?;
    step("cargo fmt", command::cargo("fmt").args(["--all", "--check"]))?;
    let mut clippy = command::cargo("clippy");
    clippy.args(["--workspace", "--all-targets"]).args(FEATURES).args(["--", "-D", "warnings"]);
    step("cargo clippy", &mut clippy)?;
    for features in [&[][..], &["--features", "threads"]] {
        step("cargo clippy, wasm", &mut wasm_lint(toolchain, features))?;
    }
    step("biome", &mut wasm::npm_script("lint"))?;
    step("tsc", &mut wasm::npm_script("check"))
}

/// Where there is no clippy for wasm, the wasm code is checked by the compiler alone.
fn wasm_lint(toolchain: Toolchain, features: &[&str]) -> Command {
    let what = [&["--package", "crease-module", "--lib"], features].concat();
    if let Some(mut clippy) = toolchain.clippy() {
        clippy.args(what).args(["--", "-D", "warnings"]);
        return clippy;
    }
    let mut check = toolchain.cargo("check");
    check.args(what);
    check
}

/// rustup's minimal profile has neither rustfmt nor clippy.
fn components() -> Result<()> {
    let is_there = |name: &str| command::output(command::cargo(name).arg("--version")).is_ok();
    if is_there("fmt") && is_there("clippy") {
        return Ok(());
    }
    step("rustfmt and clippy", command::program("rustup").args(["component", "add", "rustfmt", "clippy"]))
}

fn step(name: &str, command: &mut Command) -> Result<()> {
    progress::aloud(name, || command::run(command))
}
