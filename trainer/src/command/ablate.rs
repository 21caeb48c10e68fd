//! `crease ablate`.

use clap::{Args, ValueEnum};
use crease_trainer::ablation::{Row, compact_against_plain, table};
use crease_trainer::config::{ChosenFrames, RunConfig};
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::options::TrainOptions;
use crease_trainer::progress::Progress;
use serde_json::json;
use std::path::PathBuf;

/// Plain networks that a processor trains in minutes; `--set` changes them, and without epochs none are trained.
const NETWORKS: [&str; 4] = [
    "deformation.network.width=128",
    "deformation.network.epoch_count=30",
    "laplacian.network.width=192",
    "laplacian.network.epoch_count=12",
];

#[derive(Args)]
pub struct Arguments {
    /// Directory of a sequence with ground truth
    pub sequence: PathBuf,
    /// What is varied
    #[arg(long, value_enum)]
    pub what: Subject,
    /// Frames to train on, as a Python slice
    #[arg(long, value_name = "START:STOP:STEP", default_value = "1::2")]
    pub train: FrameRange,
    /// Frames to measure
    #[arg(long, value_name = "START:STOP:STEP", default_value = "0::2")]
    pub test: FrameRange,
    /// Numbers of basis functions
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48,64")]
    pub counts: Vec<usize>,
    /// Where to write the rows (.json)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overrides an option of training; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Subject {
    /// The number of basis functions of the compact form, and plain networks beside it
    Compact,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Subject::Compact = arguments.what;
    let networks = NETWORKS.iter().copied();
    let assignments: Vec<&str> = networks.chain(arguments.assignments.iter().map(String::as_str)).collect();
    let config = RunConfig {
        output: PathBuf::new(),
        body: None,
        name: None,
        preset: "compact".into(),
        sequences: vec![ChosenFrames { directory: arguments.sequence.clone(), poses: None, frames: arguments.train }],
        options: assignments.into_iter().try_fold(TrainOptions::compact(), |options, text| options.with(text))?,
    };
    let mut context = config.prepare(Progress::Bars)?;
    let sequence = context.sequences[0].clone();
    let frames = arguments.test.indices(sequence.capture.frame_count)?;
    let report = |row: &Row| eprint!("{}", row.line());
    let rows = compact_against_plain(&mut context, &arguments.counts, &sequence, &frames, report)?;
    print!("{}", table(&rows));
    if let Some(path) = &arguments.output {
        let record = json!({
            "sequence": sequence.capture.name,
            "train": arguments.train.to_string(),
            "test": arguments.test.to_string(),
            "rows": rows,
        });
        write_whole(path, (serde_json::to_string_pretty(&record)? + "\n").as_bytes())?;
    }
    Ok(())
}
