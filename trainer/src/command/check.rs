//! `crease check`.

use anyhow::bail;
use clap::Args;
use crease_trainer::check::{FrameFacts, Report, check};
use crease_trainer::config::read_body_model;
use crease_trainer::sequence::{Capture, Reading};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// Directory of a sequence
    pub sequence: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Body model (.npz or SMPL's .pkl), for poses that are there; the open body if left out
    #[arg(long, value_name = "FILE")]
    pub body: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Prints what a sequence is like; fails where training would.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let report = check(
        &Capture::open_as(&arguments.sequence, &arguments.reading)?,
        &read_body_model(arguments.body.as_deref())?,
    );
    if arguments.json {
        println!("{}", serde_json::to_string(&report)?);
    } else {
        print(&report);
    }
    match report.problems.len() {
        0 => Ok(()),
        count => bail!("{}: expected no problems, found {count}", arguments.sequence.display()),
    }
}

fn print(report: &Report) {
    let kind = if report.is_depth { "depth images" } else { "point clouds" };
    println!("{}: {} frames of {kind}, {} a second", report.name, report.frame_count, report.frames_per_second);
    let range = |value: &dyn Fn(&FrameFacts) -> f32| {
        let values = || report.frames.iter().map(value);
        (values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max))
    };
    if !report.frames.is_empty() {
        let line = |name: &str, (least, greatest): (f32, f32), digits: usize| {
            println!("  {name:24} {least:.digits$} to {greatest:.digits$}");
        };
        line("points", range(&|frame| frame.points as f32), 0);
        line("height, m", range(&|frame| frame.bounds[1][1] - frame.bounds[0][1]), 2);
        line("lowest, m", range(&|frame| frame.bounds[0][1]), 2);
        line("spacing, mm", range(&|frame| frame.spacing_mm), 1);
        line("noise, mm", range(&|frame| frame.noise_mm), 1);
        line("points at edges, %", range(&|frame| 100.0 * frame.edge_share), 1);
    }
    println!("  {:24} {}", "colours", if report.has_colours { "yes" } else { "no" });
    println!("  {:24} {} frames", "ground truth", report.ground_truth_count);
    for note in &report.notes {
        println!("note: {note}");
    }
    for problem in &report.problems {
        println!("problem: {problem}");
    }
}
