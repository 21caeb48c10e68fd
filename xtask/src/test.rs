//! `test`: everything that must hold, step by step. The first failure ends it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Result, bail, ensure};

use crate::browser::Browser;
use crate::site::Site;
use crate::toolchain::Toolchain;
use crate::{
    accessibility, browser, check, command, demo, docs, element, files, goldens, lint, loss, package, progress,
    samples, setup, size, start, stills, wasm, workspace,
};

/// The small page on which the whole way from pose to pixels is checked.
const PAGE: &str = "tests/pages/tiny.html";

/// A page whose avatar does not exist: the check must say so.
const BROKEN_PAGE: &str = "tests/pages/broken.html";

/// Installs what is missing and runs every test and lint.
pub fn run() -> Result<()> {
    let toolchain = setup::everything()?;
    wasm::build(toolchain)?;
    wasm::build_element()?;
    lint::run(toolchain)?;
    // Browsers wait more than they compute, and the compiler does not wait.
    thread::scope(|scope| {
        let compiled = scope.spawn(|| command::run(native_tests().args(["--no-run", "--quiet"])));
        in_browsers(toolchain)?;
        compiled.join().expect("the thread does not panic")
    })?;
    step("native tests", &mut native_tests())?;
    progress::aloud("npm package", package::make)?;
    progress::aloud("sample projects", samples::check_all)?;
    eprintln!("Everything passed.");
    Ok(())
}

fn native_tests() -> Command {
    let mut cargo = command::cargo("test");
    browser::lend_software_gpu(&mut cargo);
    cargo.arg("--workspace").args(lint::FEATURES);
    cargo
}

fn in_browsers(toolchain: Toolchain) -> Result<()> {
    step("element's own tests", &mut wasm::npm_script("test"))?;
    progress::aloud("size of the runtime", size::check)?;
    progress::aloud("glTF validator", validate_glbs)?;
    wasm(toolchain)?;
    element::run(None)?;
    progress::aloud("end-to-end page", end_to_end)?;
    progress::aloud("end-to-end page in Firefox", in_firefox)?;
    progress::aloud("first pictures", start::run)?;
    progress::aloud("pictures through every backend", stills::run)?;
    progress::aloud("devices lost in mid-play", loss::run)?;
    progress::aloud("golden pictures", goldens::check)?;
    progress::aloud("documentation", docs::check)?;
    docs::build()?;
    progress::aloud("demo page", demo::check)?;
    progress::aloud("accessibility", accessibility::run)
}

/// Runs a step whose output is this task's result.
fn step(name: &str, command: &mut Command) -> Result<()> {
    progress::aloud(name, || command::run(command.stdout(Stdio::inherit())))
}

/// Runs crease's wasm tests in headless Chromium.
pub fn wasm(toolchain: Toolchain) -> Result<()> {
    let mut cargo = toolchain.cargo("test");
    // The module's own profile: it is what browsers run.
    cargo.args(["--package", "crease", "--test", "fixtures", "--no-default-features", "--features", "render"]);
    cargo.args(["--profile", "web"]);
    browser::configure_wasm_tests(&mut cargo)?;
    step("wasm tests in headless Chromium", &mut cargo)
}

/// Khronos' validator over every committed GLB, and over a file that is none: it must be able to fail.
fn validate_glbs() -> Result<()> {
    let files = [glbs(&workspace::root().join("tests"))?, glbs(&workspace::web().join("assets"))?].concat();
    ensure!(!files.is_empty(), "there is no GLB to validate");
    let validate = |files: &[PathBuf]| {
        let mut node = command::program("node");
        // The validator is found from the npm package's folder.
        node.current_dir(workspace::web()).arg(workspace::root().join("tests/validate_glb.mjs")).args(files);
        node
    };
    command::run(validate(&files).stdout(Stdio::inherit()))?;
    let no_glb = workspace::root().join("Cargo.toml");
    ensure!(command::output(&mut validate(&[no_glb])).is_err(), "the validator accepts Cargo.toml as a GLB");
    Ok(())
}

/// The GLB files in a folder and its subfolders.
fn glbs(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_glb = |file: &PathBuf| file.extension().is_some_and(|extension| extension == "glb");
    Ok(files::below(folder)?.into_iter().filter(is_glb).collect())
}

fn end_to_end() -> Result<()> {
    let folder = workspace::wasm_target();
    let report = check::run(Path::new(PAGE), &folder.join("tiny.png"))?;
    println!("{}", report.to_json()?);
    match check::run(Path::new(BROKEN_PAGE), &folder.join("broken.png")) {
        Ok(_) => bail!("{BROKEN_PAGE} passed the check, expected a failure"),
        Err(error) => ensure!(format!("{error:#}").contains("no-such-avatar.glb"), "{BROKEN_PAGE}: {error:#}"),
    }
    Ok(())
}

/// Firefox has no WebGPU on Linux: the same page plays there through WebGL2.
fn in_firefox() -> Result<()> {
    let report =
        check::play(Site::new(Path::new(PAGE))?, Browser::Firefox, 20, &workspace::wasm_target().join("firefox.png"))?;
    ensure!(report.backend() == "webgl2+cpu", "expected webgl2+cpu in Firefox, found {}", report.backend());
    println!("{}", report.to_json()?);
    Ok(())
}
