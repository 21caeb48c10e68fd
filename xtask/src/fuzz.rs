//! `fuzz`: coverage-guided search for inputs that break a reader, the player or the animator, on stable Rust.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::{command, progress, workspace};

/// Coverage of branches and comparisons, as cargo-fuzz has it, minus the sanitiser, which needs a nightly compiler: this code is safe Rust,
/// so what can go wrong is a panic, an endless loop or too much memory, and the targets look for those themselves.
const INSTRUMENTATION: [&str; 5] = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];

/// Says that this program is called in the compiler's place.
const AS_COMPILER: &str = "CREASE_FUZZ_COMPILER";

/// Seconds that one input may take.
const LIMIT_SECONDS: u32 = 1;
/// Resident memory that the whole process may take, MB; targets hold each input to four times its size and 64 MiB.
const LIMIT_MEGABYTES: u32 = 1024;

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
    /// Longest input, bytes
    #[arg(long, default_value_t = 16384)]
    longest: usize,
}

/// One target's search.
#[derive(serde::Serialize)]
struct Row {
    target: String,
    executions: u64,
    seconds: u64,
    inputs: usize,
    found: usize,
}

/// Builds the targets, searches, keeps what was found in fuzz/found/, prints a table and writes target/fuzz.json. An error where something
/// was found.
pub fn run(options: &Options) -> Result<()> {
    let target_folder = workspace::root().join("target/fuzz");
    let mut build = command::cargo("build");
    build.args(["--package", "crease-fuzz", "--features", "libfuzzer", "--bin", "fuzz"]);
    // Our own crates are instrumented, and the rest is what other builds use too.
    build.env("RUSTC_WORKSPACE_WRAPPER", std::env::current_exe().context("cannot find the task runner itself")?);
    build.env(AS_COMPILER, "1");
    progress::aloud("building the fuzz targets", || command::run(&mut build))?;
    let seeds = || {
        let mut cargo = command::cargo("run");
        cargo.args(["--quiet", "--package", "crease-fuzz", "--bin", "seeds", "--"]);
        cargo
    };
    let all = command::output(&mut seeds())?;
    let all: Vec<&str> = all.lines().collect();
    if let Some(unknown) = options.targets.iter().find(|name| !all.contains(&name.as_str())) {
        bail!("--target: expected one of {}, found {unknown}", all.join(", "));
    }
    let chosen: Vec<&str> = all
        .into_iter()
        .filter(|name| options.targets.is_empty() || options.targets.iter().any(|t| t == name))
        .collect();
    let seconds = (60.0 * options.minutes / chosen.len() as f64).ceil().max(1.0) as u64;
    let program = workspace::root().join("target/debug/fuzz");

    let mut rows = Vec::new();
    for name in chosen {
        let corpus = target_folder.join("corpus").join(name);
        command::run(seeds().arg(name).arg(&corpus))?;
        let row = progress::aloud(&format!("fuzzing {name}"), || search(&program, name, &corpus, seconds, options))?;
        rows.push(row);
    }
    println!("{:16} {:>12} {:>8} {:>8} {:>6}", "target", "executions", "seconds", "inputs", "found");
    for Row { target, executions, seconds, inputs, found } in &rows {
        println!("{target:16} {executions:>12} {seconds:>8} {inputs:>8} {found:>6}");
    }
    let record = workspace::root().join("target/fuzz.json");
    fs::write(&record, serde_json::to_string_pretty(&rows)? + "\n").context("cannot write target/fuzz.json")?;
    let found: usize = rows.iter().map(|row| row.found).sum();
    ensure!(found == 0, "{found} inputs that break something: see fuzz/found/");
    Ok(())
}

fn search(program: &Path, name: &str, corpus: &Path, seconds: u64, options: &Options) -> Result<Row> {
    let found_folder = workspace::root().join("fuzz/found").join(name);
    fs::create_dir_all(&found_folder)?;
    let before = files(&found_folder)?.len();
    let mut prefix = found_folder.clone().into_os_string();
    prefix.push("/");
    let log = corpus.with_extension("log");
    let mut libfuzzer = Command::new(program);
    libfuzzer.current_dir(workspace::root()).env("CREASE_FUZZ_TARGET", name).arg(corpus);
    libfuzzer.arg(format!("-artifact_prefix={}", prefix.to_string_lossy()));
    libfuzzer
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-runs={}", options.executions.map_or(-1, |n| n as i64)));
    libfuzzer.arg(format!("-timeout={LIMIT_SECONDS}")).arg(format!("-rss_limit_mb={LIMIT_MEGABYTES}"));
    libfuzzer.arg(format!("-max_len={}", options.longest)).arg("-print_final_stats=1");
    libfuzzer.stdout(fs::File::create(&log)?).stderr(fs::File::options().append(true).open(&log)?);
    let begin = std::time::Instant::now();
    // Whatever it found is in the folder; the log says the rest.
    let ended = command::run(&mut libfuzzer);
    if command::interrupted() {
        bail!("interrupted");
    }
    let text = fs::read_to_string(&log)?;
    let found = files(&found_folder)?.len() - before;
    if found == 0 {
        ended.with_context(|| format!("{}: see there", workspace::relative(&log)))?;
    } else {
        // An empty folder would say that something was.
        eprintln!("{name}: {found} found; {} says how", workspace::relative(&log));
    }
    // Fails where it is not empty, as it should.
    let _ = fs::remove_dir(&found_folder);
    let executions = executions(&text).with_context(|| format!("{}: no count", workspace::relative(&log)))?;
    let inputs = files(corpus)?.len();
    Ok(Row { target: name.to_owned(), executions, seconds: begin.elapsed().as_secs(), inputs, found })
}

/// Executions that a log tells: in its statistics, else in its last line of progress (`#1234 …`).
fn executions(log: &str) -> Option<u64> {
    let stated = log.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:")?.trim().parse().ok());
    let count = |line: &str| line.strip_prefix('#')?.split_whitespace().next()?.parse().ok();
    let counted = || log.lines().rev().find_map(count);
    stated.or_else(counted)
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot list {}", workspace::relative(folder)))?;
    Ok(entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect())
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
    fn executions_are_read_from_either_form_of_log() {
        assert_eq!(executions("#2 INITED\n#512 NEW cov: 3\nstat::number_of_executed_units: 900\n"), Some(900));
        assert_eq!(executions("#2 INITED\n#512\tNEW cov: 3\n==1== ERROR: libFuzzer: timeout\n"), Some(512));
        assert_eq!(executions("no such target\n"), None);
    }
}
