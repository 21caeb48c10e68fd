//! The task runner: `cargo xtask play | test | …`, one set of steps for people and for continuous integration.

mod accessibility;
mod bench;
mod browser;
mod build_name;
mod check;
mod command;
mod demo;
mod docs;
mod element;
mod faults;
mod files;
mod fuzz;
mod goldens;
mod http;
mod lint;
mod long_run;
mod loss;
mod package;
mod picture;
mod pictures;
mod play;
mod progress;
mod reproduce;
mod samples;
mod serve;
mod setup;
mod short_names;
mod site;
mod size;
mod start;
mod stills;
mod supply;
mod test;
mod toolchain;
mod trainer_archive;
mod wasm;
mod webgl2_shaders;
mod workspace;

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Builds, shows and checks crease. Whatever a task needs is installed first.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build the web module, serve the demo page on this machine and open it
    Play(play::Options),
    /// Run every test and lint, native and in a headless browser
    Test,
    /// Measure what a frame costs and how large things are; writes target/bench.json
    Bench(bench::Options),
    /// Kill, starve and rob a training run, and compare how it ends
    Faults(faults::Options),
    /// Train on more frames than memory holds, and say how much it took
    LongRun(long_run::Options),
    /// Use a page for long and count what it holds
    Soak(element::SoakOptions),
    /// Check licences and sources; write the bill of materials
    Supply,
    /// Search for inputs that break a reader, the player or the animator
    Fuzz(fuzz::Options),
    /// Draw the golden pictures of tests/goldens/ anew
    Goldens {
        /// Compare in each browser instead
        #[arg(long)]
        check: bool,
    },
    /// Run the lints only: fmt, clippy, biome, tsc
    Lint,
    /// Run the wasm tests only, in headless Chromium
    WasmTests,
    /// Run the element's cases only, in headless Chromium; those whose names contain the words given
    ElementTests {
        /// A part of the names of the cases to run
        only: Option<String>,
    },
    /// Install what is missing: system packages, npm packages, what compiles wasm
    Setup,
    /// Build web/pkg/ (wasm and its bindings), web/dist/ (the element) and web/lib/ (both, bundled)
    BuildWeb,
    /// Use the demo page as a visitor does, in headless Chromium; screenshots go to target/demo/
    Demo,
    /// Build the site for adopters and the demo into target/site/, and serve it
    Docs(docs::Options),
    /// Pack the npm package and the trainer's archive into target/package/ and tell their sizes
    Package(package::Options),
    /// Build the wasm module twice, from clean and in different folders, and compare
    Reproduce,
    /// Draw the pictures of the demo's shelf and posters into demo/pictures/
    Pictures,
    /// Build the projects of examples/ from the packed npm package and play them in headless Chromium
    Samples,
    /// Run one wasm test executable in a headless browser; cargo calls this
    #[command(hide = true, disable_help_flag = true)]
    WasmTestRunner {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
}

fn main() -> ExitCode {
    if let Some(code) = fuzz::as_compiler() {
        return code;
    }
    match run(Arguments::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) if command::interrupted() => {
            eprintln!("stopped");
            ExitCode::from(130)
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Result<()> {
    if let Task::WasmTestRunner { arguments } = task {
        return browser::run_wasm_tests(arguments);
    }
    command::stop_on_interrupt()?;
    match task {
        Task::Play(options) => play::run(&options),
        Task::Test => test::run(),
        Task::Bench(options) => bench::run(&options),
        Task::Faults(options) => faults::run(&options),
        Task::LongRun(options) => long_run::run(&options),
        Task::Soak(options) => {
            let toolchain = setup::everything()?;
            wasm::build(toolchain)?;
            wasm::build_element()?;
            element::soak(&options)
        }
        Task::Supply => supply::run(),
        Task::Reproduce => reproduce::run(),
        Task::Fuzz(options) => fuzz::run(&options),
        Task::Lint => {
            let toolchain = setup::everything()?;
            wasm::build(toolchain)?;
            lint::run(toolchain)
        }
        Task::WasmTests => test::wasm(setup::everything()?),
        Task::Demo => demo::run(),
        Task::Docs(options) => docs::run(&options),
        Task::Goldens { check } => {
            let toolchain = setup::everything()?;
            wasm::build(toolchain)?;
            wasm::build_element()?;
            if check { goldens::check() } else { goldens::write() }
        }
        Task::Pictures => pictures::run(),
        Task::Samples => samples::run(),
        Task::Package(options) => package::run(&options),
        Task::ElementTests { only } => {
            let toolchain = setup::everything()?;
            wasm::build(toolchain)?;
            wasm::build_element()?;
            element::run(only.as_deref())
        }
        Task::Setup => setup::everything().map(drop),
        Task::BuildWeb => {
            let toolchain = setup::for_building()?;
            wasm::build(toolchain)?;
            wasm::build_element()
        }
        Task::WasmTestRunner { .. } => unreachable!("handled above"),
    }
}
