//! The web module: cargo, then wasm-bindgen, then wasm-opt; and the element around it.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::{Context, Result};

use crate::toolchain::Toolchain;
use crate::{build_name, command, files, progress, short_names, webgl2_shaders, workspace};

/// The module is built twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// For every page.
    Single,
    /// For pages that are isolated from others: their workers may share its memory and be its threads.
    Threads,
}

impl Form {
    /// Both.
    pub const ALL: [Form; 2] = [Form::Single, Form::Threads];

    fn name(self) -> &'static str {
        match self {
            Form::Single => "crease",
            Form::Threads => "crease_threads",
        }
    }

    /// The file that it becomes.
    pub fn module(self) -> String {
        format!("{}_bg.wasm", self.name())
    }

    /// The script that binds it.
    pub fn bindings(self) -> String {
        format!("{}.js", self.name())
    }

    /// Names of the module's functions by their numbers, which is all that a browser's call stack tells of them.
    pub fn symbols(self) -> String {
        format!("{}_bg.symbols", self.name())
    }

    /// A folder of its own: each has other flags, and would undo the other's work.
    fn target(self, target: &Path) -> PathBuf {
        match self {
            Form::Single => target.to_owned(),
            Form::Threads => target.join("threads"),
        }
    }

    fn flags(self) -> &'static [&'static str] {
        match self {
            Form::Single => &[],
            Form::Threads => &THREADS,
        }
    }
}

/// Memory that is given to the module, of so many bytes at most, and what a thread needs to have its own part of it.
const THREADS: [&str; 18] = [
    "-C",
    "target-feature=+atomics,+bulk-memory,+mutable-globals",
    "-C",
    "link-arg=--shared-memory",
    "-C",
    "link-arg=--import-memory",
    "-C",
    "link-arg=--max-memory=1073741824",
    "-C",
    "link-arg=--export=__wasm_init_tls",
    "-C",
    "link-arg=--export=__tls_size",
    "-C",
    "link-arg=--export=__tls_align",
    "-C",
    "link-arg=--export=__tls_base",
    "-C",
    "link-arg=--export=__heap_base",
];

/// What the compiler may use: everywhere in browsers since 2023.
const WASM_FEATURES: [&str; 8] = [
    "--enable-simd",
    "--enable-threads",
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

/// Builds `crease-module` into web/pkg/, in both forms. Does nothing beyond asking cargo when neither they nor this program, which finishes
/// them, changed.
pub fn build(toolchain: Toolchain) -> Result<()> {
    let compile = |form| compile(toolchain, form, workspace::root(), &workspace::wasm_target());
    let compiled = progress::aloud("Compiling the wasm module, in both forms", || {
        // Linking, which optimises all crates together, has one processor at work.
        thread::scope(|scope| {
            let threads = scope.spawn(|| compile(Form::Threads));
            let single = compile(Form::Single)?;
            Ok([single, threads.join().expect("the thread does not panic")?])
        })
    })?;
    let package = workspace::web().join("pkg");
    let own = std::env::current_exe().context("cannot find this program's own file")?;
    let is_finished = |(form, compiled): (&Form, &PathBuf)| {
        [compiled, &own].iter().all(|source| is_newer(&package.join(form.module()), source))
    };
    if !Form::ALL.iter().zip(&compiled).all(is_finished) {
        bind_and_optimise(&compiled, &package)?;
    }
    webgl2_shaders::write(&package)?;
    build_name::write(&package)
}

fn compile(toolchain: Toolchain, form: Form, root: &Path, target: &Path) -> Result<PathBuf> {
    let target = form.target(target);
    let flags = [&PANICS, form.flags()].concat();
    let mut cargo = toolchain.cargo_in(root, &target, &flags, "rustc");
    cargo.args(["--package", "crease-module", "--lib", "--profile", "web"]);
    if form == Form::Threads {
        cargo.args(["--features", "threads"]);
    }
    command::run(cargo.arg("--").args(CODE_GENERATION))?;
    Ok(toolchain.output_folder(&target, "web").join("crease_module.wasm"))
}

/// The finished modules, built from clean by the repository at `root`, whose folder is as good as any.
pub fn build_apart(toolchain: Toolchain, root: &Path) -> Result<[Vec<u8>; 2]> {
    let target = root.join("target/web");
    let folder = target.join("pkg");
    let mut modules = [Vec::new(), Vec::new()];
    for (form, module) in Form::ALL.into_iter().zip(&mut modules) {
        let compiled = compile(toolchain, form, root, &target)?;
        bind(form, &compiled, &folder)?;
        optimise(form, &folder)?;
        *module = fs::read(folder.join(form.module())).context("cannot read the finished module")?;
    }
    Ok(modules)
}

fn bind_and_optimise(compiled: &[PathBuf], package: &Path) -> Result<()> {
    let aside = workspace::wasm_target().join("pkg");
    if aside.exists() {
        fs::remove_dir_all(&aside).with_context(|| format!("cannot clear {}", workspace::relative(&aside)))?;
    }
    for (form, compiled) in Form::ALL.into_iter().zip(compiled) {
        progress::quietly("Writing the bindings", || bind(form, compiled, &aside))?;
        progress::quietly("Optimising the wasm module", || optimise(form, &aside))?;
    }
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

fn bind(form: Form, compiled: &Path, folder: &Path) -> Result<()> {
    let words = ["wasm-bindgen", "--target", "web", "--out-name", form.name(), "--out-dir"].map(Path::new);
    wasm_bindgen_cli::wasm_bindgen::run_cli_with_args(words.into_iter().chain([folder, compiled]))
        .with_context(|| format!("wasm-bindgen cannot read {}", workspace::relative(compiled)))?;
    let (module, script) = (folder.join(form.module()), folder.join(form.bindings()));
    let bytes = fs::read(&module).with_context(|| format!("cannot read {}", workspace::relative(&module)))?;
    let (short_module, short_script) = short_names::shorten(&bytes, &files::read(&script)?, form.name())?;
    files::write(&module, short_module)?;
    files::write(&script, short_script)
}

fn optimise(form: Form, folder: &Path) -> Result<()> {
    let module = folder.join(form.module());
    let before = fs::metadata(&module)?.len();
    let optimised = module.with_extension("optimised");
    let symbols = format!("--symbolmap={}", folder.join(form.symbols()).display());
    let mut wasm_opt = command::program(workspace::web().join("node_modules/.bin/wasm-opt"));
    wasm_opt.arg(&module).arg("-o").arg(&optimised).arg("-Oz").arg(symbols).args(WASM_FEATURES);
    command::run(&mut wasm_opt)?;
    let after = fs::metadata(&optimised)?.len();
    fs::rename(&optimised, &module)?;
    eprintln!("   {}: {} kB, was {} kB before optimising", form.module(), after / 1000, before / 1000);
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
