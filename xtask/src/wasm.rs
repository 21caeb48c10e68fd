//! The web module: cargo, then wasm-bindgen, then wasm-opt; and the element around it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::toolchain::Toolchain;
use crate::{build_name, command, files, progress, short_names, webgl2_shaders, workspace};

const MODULE: &str = "crease_bg.wasm";
const BINDINGS: &str = "crease.js";

/// Names of the module's functions by their numbers, which is all that a browser's call stack tells of them.
const SYMBOLS: &str = "crease_bg.symbols";

/// What the compiler may use: everywhere in browsers since 2023.
const WASM_FEATURES: [&str; 7] = [
    "--enable-simd",
    "--enable-bulk-memory",
    "--enable-nontrapping-float-to-int",
    "--enable-sign-ext",
    "--enable-mutable-globals",
    "--enable-reference-types",
    "--enable-multivalue",
];

/// Where all crates are optimised together little more is inlined: every copy is downloaded, and what frames spend their time in has been
/// inlined within its own crate. A frame takes as long as with the compiler's own threshold.
const CODE_GENERATION: [&str; 2] = ["-C", "llvm-args=-inline-threshold=5"];

/// A panic ends as the trap `unreachable`, as it would anyway, but says nothing before: its texts would be a tenth of what a page downloads.
/// Tests do without this.
const PANICS: [&str; 3] = ["-Zunstable-options", "-C", "panic=immediate-abort"];

/// Builds `crease-module` into web/pkg/. Does nothing beyond asking cargo when neither it nor this program, which finishes it, changed.
pub fn build(toolchain: Toolchain) -> Result<()> {
    let compiled = progress::aloud("Compiling the wasm module", || {
        compile(toolchain, workspace::root(), &workspace::wasm_target())
    })?;
    let package = workspace::web().join("pkg");
    let own = std::env::current_exe().context("cannot find this program's own file")?;
    if ![&compiled, &own].iter().all(|source| is_newer(&package.join(MODULE), source)) {
        bind_and_optimise(&compiled, &package)?;
    }
    webgl2_shaders::write(&package)?;
    build_name::write(&package, MODULE)
}

fn compile(toolchain: Toolchain, root: &Path, target: &Path) -> Result<PathBuf> {
    let mut cargo = toolchain.cargo_in(root, target, &PANICS, "rustc");
    cargo.args(["--package", "crease-module", "--lib", "--profile", "web", "--"]);
    command::run(cargo.args(CODE_GENERATION))?;
    Ok(toolchain.output_folder(target, "web").join("crease_module.wasm"))
}

/// The finished module, built from clean by the repository at `root`, whose folder is as good as any.
pub fn build_apart(toolchain: Toolchain, root: &Path) -> Result<Vec<u8>> {
    let target = root.join("target/web");
    let compiled = compile(toolchain, root, &target)?;
    let folder = target.join("pkg");
    bind(&compiled, &folder)?;
    optimise(&folder.join(MODULE))?;
    fs::read(folder.join(MODULE)).context("cannot read the finished module")
}

fn bind_and_optimise(compiled: &Path, package: &Path) -> Result<()> {
    let aside = workspace::wasm_target().join("pkg");
    if aside.exists() {
        fs::remove_dir_all(&aside).with_context(|| format!("cannot clear {}", workspace::relative(&aside)))?;
    }
    progress::quietly("Writing the bindings", || bind(compiled, &aside))?;
    progress::quietly("Optimising the wasm module", || optimise(&aside.join(MODULE)))?;
    replace(&aside, package)
}

/// Writes web/custom-elements.json, the element's interface for tools, from its sources.
pub fn describe_element() -> Result<()> {
    progress::quietly("Describing the element", || command::run(&mut npm_script("manifest")))
}

/// Compiles the element's TypeScript into web/dist/ and bundles it into web/lib/.
pub fn build_element() -> Result<()> {
    progress::quietly("Compiling the element", || command::run(&mut npm_script("build")))
}

/// A script of web/package.json.
pub fn npm_script(name: &str) -> std::process::Command {
    let mut npm = command::program("npm");
    npm.args(["run", "--silent", name, "--prefix"]).arg(workspace::web());
    npm
}

fn bind(compiled: &Path, folder: &Path) -> Result<()> {
    let words = ["wasm-bindgen", "--target", "web", "--out-name", "crease", "--out-dir"].map(Path::new);
    wasm_bindgen_cli::wasm_bindgen::run_cli_with_args(words.into_iter().chain([folder, compiled]))
        .with_context(|| format!("wasm-bindgen cannot read {}", workspace::relative(compiled)))?;
    let (module, script) = (folder.join(MODULE), folder.join(BINDINGS));
    let bytes = fs::read(&module).with_context(|| format!("cannot read {}", workspace::relative(&module)))?;
    let (short_module, short_script) = short_names::shorten(&bytes, &files::read(&script)?)?;
    files::write(&module, short_module)?;
    files::write(&script, short_script)
}

fn optimise(module: &Path) -> Result<()> {
    let before = fs::metadata(module)?.len();
    let optimised = module.with_extension("optimised");
    let symbols = format!("--symbolmap={}", module.with_file_name(SYMBOLS).display());
    let mut wasm_opt = command::program(workspace::web().join("node_modules/.bin/wasm-opt"));
    wasm_opt.arg(module).arg("-o").arg(&optimised).arg("-Oz").arg(symbols).args(WASM_FEATURES);
    command::run(&mut wasm_opt)?;
    let after = fs::metadata(&optimised)?.len();
    fs::rename(&optimised, module)?;
    eprintln!("   {MODULE}: {} kB, was {} kB before optimising", after / 1000, before / 1000);
    Ok(())
}

fn is_newer(product: &Path, source: &Path) -> bool {
    let time = |path: &Path| fs::metadata(path).and_then(|data| data.modified());
    matches!((time(product), time(source)), (Ok(product), Ok(source)) if product > source)
}

/// Puts the finished folder where the old one was.
fn replace(finished: &Path, destination: &Path) -> Result<()> {
    let named = |what: &str| format!("cannot {what} {}", workspace::relative(destination));
    if destination.exists() {
        fs::remove_dir_all(destination).with_context(|| named("clear"))?;
    }
    fs::rename(finished, destination).with_context(|| named("write"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_product_is_never_newer() {
        let source = workspace::root().join("Cargo.toml");
        assert!(!is_newer(&workspace::root().join("no-such-file"), &source));
        assert!(!is_newer(&source, &source), "the same time counts as old");
    }
}
