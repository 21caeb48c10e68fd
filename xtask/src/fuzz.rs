//! `fuzz`: coverage-guided search for inputs that break a reader, the player or the animator, on stable Rust.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::{command, lint, progress, workspace};

/// A counter for each branch, which LLVM adds on a stable compiler too. There is no sanitiser, which needs a nightly one: this code is safe
/// Rust, so what can go wrong is a panic, an endless loop or too much memory, and the targets look for those themselves.
const INSTRUMENTATION: [&str; 3] = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=3",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
];

/// Where inputs that break something are kept; tests check them from then on.
const FOUND: &str = "fuzz/found";

/// Says that this program is called in the compiler's place.
const AS_COMPILER: &str = "CREASE_FUZZ_COMPILER";

/// How long, and what.
#[derive(Args)]
pub struct Options {
    /// How long to search, all targets together
    #[arg(long, default_value_t = 5.0)]
    minutes: f64,
    /// One target alone; may be repeated
    #[arg(long = "target", value_name = "NAME")]
    targets: Vec<String>,
    /// Stop each target after so many executions, if time allows
    #[arg(long, value_name = "COUNT")]
    executions: Option<u64>,
    /// Where random choices start from
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// One target's search, as the program prints it.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Row {
    target: String,
    executions: u64,
    seconds: f64,
    inputs: usize,
    counters: usize,
    found: Vec<String>,
}

/// Builds the targets, searches, keeps what was found in fuzz/found/, prints a table and writes target/fuzz.json. An error where something
/// was found.
pub fn run(options: &Options) -> Result<()> {
    let program = build()?;
    let all = command::output(&mut command::program(&program))?;
    let all: Vec<&str> = all.lines().collect();
    if let Some(unknown) = options.targets.iter().find(|name| !all.contains(&name.as_str())) {
        bail!("--target: expected one of {}, found {unknown}", all.join(", "));
    }
    let is_chosen = |name: &&str| options.targets.is_empty() || options.targets.iter().any(|target| target == name);
    let chosen: Vec<&str> = all.into_iter().filter(is_chosen).collect();
    let seconds = (60.0 * options.minutes / chosen.len() as f64).ceil().max(1.0) as u64;

    let mut rows = Vec::new();
    for name in chosen {
        rows.push(progress::aloud(&format!("fuzzing {name}"), || search(&program, name, seconds, options))?);
    }
    print!("{}", table(&rows));
    let record = workspace::root().join("target/fuzz.json");
    fs::write(&record, serde_json::to_string_pretty(&rows)? + "\n").context("cannot write target/fuzz.json")?;
    let found: Vec<String> =
        rows.iter().flat_map(|row| row.found.iter().map(move |line| format!("{}: {line}", row.target))).collect();
    ensure!(found.is_empty(), "inputs that break something, kept in {FOUND}:\n  {}", found.join("\n  "));
    ensure!(rows.iter().all(|row| row.counters > 0), "the build has no branch counters: the search was blind");
    Ok(())
}

/// The instrumented program. What others built of our dependencies is used; our own crates are built for this.
fn build() -> Result<PathBuf> {
    let mut build = command::cargo("build");
    // A test brings the program along, with the features of all tests, and so with the dependencies that they have built already.
    build.args(["--workspace", "--test", "found"]).args(lint::FEATURES);
    // Only our own crates go through the wrapper, which adds the instrumentation.
    build.env("RUSTC_WORKSPACE_WRAPPER", std::env::current_exe().context("cannot find the task runner itself")?);
    build.env(AS_COMPILER, "1");
    progress::aloud("building the fuzz targets", || command::run(&mut build))?;
    Ok(workspace::root().join("target/debug/fuzz"))
}

fn search(program: &Path, name: &str, seconds: u64, options: &Options) -> Result<Row> {
    let mut fuzz = command::program(program);
    fuzz.arg(name).arg("--seconds").arg(seconds.to_string()).arg("--seed").arg(options.seed.to_string());
    fuzz.arg("--corpus").arg(workspace::root().join("target/fuzz-corpus").join(name));
    fuzz.arg("--found").arg(workspace::root().join(FOUND).join(name));
    if let Some(executions) = options.executions {
        fuzz.arg("--executions").arg(executions.to_string());
    }
    let told =
        command::output(&mut fuzz).with_context(|| format!("an input that does not end, kept in {FOUND}/{name}"))?;
    serde_json::from_str(&told).with_context(|| format!("{name}: expected a report, found {told:?}"))
}

fn table(rows: &[Row]) -> String {
    let mut text =
        "| target | executions | seconds | inputs that reached something | found |\n|---|---|---|---|---|\n".to_owned();
    for Row { target, executions, seconds, inputs, found, .. } in rows {
        text += &format!("| {target} | {executions} | {seconds:.0} | {inputs} | {} |\n", found.len());
    }
    text
}

/// Where cargo calls this program in the compiler's place: compiles with instrumentation, and gives the compiler's exit code.
pub fn as_compiler() -> Option<ExitCode> {
    std::env::var_os(AS_COMPILER)?;
    let mut arguments = std::env::args_os().skip(1);
    let status = Command::new(arguments.next()?).args(arguments).args(INSTRUMENTATION).status();
    let code = status.ok().and_then(|status| status.code()).and_then(|code| u8::try_from(code).ok());
    Some(ExitCode::from(code.unwrap_or(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_line_for_each_target() {
        let line = r#"{"target":"ply","executions":9,"seconds":1.5,"inputs":2,"counters":3,"found":["a"]}"#;
        let rows = [serde_json::from_str(line).unwrap()];
        assert!(table(&rows).ends_with("| ply | 9 | 2 | 2 | 1 |\n"), "{}", table(&rows));
    }
}
