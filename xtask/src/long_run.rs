//! `long-run`: a training run on more frames than memory holds, and the memory that it takes.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::{command, files, lint, progress, workspace};

/// Narrow networks and one pass: what is measured is the way of the data, not the arithmetic.
const ASSIGNMENTS: [&str; 12] = [
    "deformation.network.width=32",
    "deformation.network.layer_count=3",
    "deformation.network.epoch_count=1",
    "deformation.points_a_frame=4000",
    "deformation.anchor_weight=0",
    "laplacian.network.width=32",
    "laplacian.network.epoch_count=1",
    "laplacian.points_a_step=100000",
    "frequency_count=4",
    "level_count=1",
    "anchor_count=100",
    "texture_size=64",
];

/// How much of it.
#[derive(Args)]
pub struct Options {
    /// Frames of the sequence, which is made first
    #[arg(long, default_value_t = 18_000)]
    frames: u32,
    /// Points of each
    #[arg(long, default_value_t = 40_000)]
    points: u32,
    /// Keep the sequence and what was computed
    #[arg(long)]
    keep: bool,
}

/// Makes the sequence, trains its first epoch, and prints the largest resident memory of it; target/long-run.json has it over time.
pub fn run(options: &Options) -> Result<()> {
    let mut build = command::cargo("build");
    build.args(["--workspace", "--bin", "crease", "--example", "write_long_sequence"]).args(lint::FEATURES);
    command::run(&mut build)?;
    let folder = workspace::root().join("target/long-run");
    files::empty(&folder)?;
    let sequence = folder.join("sequence");
    let mut generate = command::program(workspace::root().join("target/debug/examples/write_long_sequence"));
    generate.arg(&sequence).args([options.frames, options.points].map(|number| number.to_string()));
    progress::aloud("writing the sequence", || command::run(&mut generate))?;

    let began = Instant::now();
    let samples = progress::aloud("training", || train(&folder, &sequence))?;
    let largest = samples.iter().map(|sample| sample.resident_mib).fold(0.0, f64::max);
    println!("| frames | points a frame | seconds | largest resident memory |\n|---|---|---|---|");
    let (frames, points, seconds) = (options.frames, options.points, began.elapsed().as_secs());
    println!("| {frames} | {points} | {seconds} | {largest:.0} MiB |");
    let record = workspace::root().join("target/long-run.json");
    fs::write(&record, serde_json::to_string_pretty(&samples)? + "\n").context("cannot write target/long-run.json")?;
    if !options.keep {
        fs::remove_dir_all(&folder).context("cannot remove target/long-run/")?;
    }
    Ok(())
}

/// Memory at a moment.
#[derive(serde::Serialize)]
struct Sample {
    seconds: f64,
    resident_mib: f64,
}

fn train(folder: &Path, sequence: &Path) -> Result<Vec<Sample>> {
    let mut train = command::program(workspace::root().join("target/debug/crease"));
    train.arg("train").arg(sequence).arg("--output").arg(folder.join("long.glb"));
    train.args(["--preset", "paper", "--json"]).args(ASSIGNMENTS.iter().flat_map(|assignment| ["--set", assignment]));
    let log = fs::File::create(folder.join("log.jsonl")).context("cannot write target/long-run/log.jsonl")?;
    let mut child = train.stdout(Stdio::from(log)).spawn().context("cannot start the trainer")?;
    let status_file = format!("/proc/{}/status", child.id());
    let began = Instant::now();
    let mut samples = Vec::new();
    loop {
        if let Some(status) = child.try_wait()? {
            ensure!(
                status.success(),
                "the trainer ended with {status}; target/long-run/log.jsonl says how far it came"
            );
            return Ok(samples);
        }
        // Where there is no /proc the run is still a test of endurance.
        if let Some(resident_mib) = fs::read_to_string(&status_file).ok().and_then(|text| resident_mib(&text)) {
            samples.push(Sample { seconds: began.elapsed().as_secs_f64(), resident_mib });
        }
        ensure!(!command::interrupted(), "interrupted");
        thread::sleep(Duration::from_secs(1));
    }
}

/// The high-water mark of Linux' account of a process.
fn resident_mib(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_read() {
        assert_eq!(resident_mib("Name:\tcrease\nVmHWM:\t    2048 kB\nVmRSS:\t    1024 kB\n"), Some(2.0));
        assert_eq!(resident_mib("Name:\tcrease\n"), None);
    }
}
