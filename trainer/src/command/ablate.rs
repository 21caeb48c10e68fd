//! `crease ablate`.

use super::train::Preset;
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use crease_trainer::ablation::{self, CompactRow, FidelityRow, OptionRow, PaperRow, PaperRuns, Study};
use crease_trainer::ablation::{compact_against_plain, compact_table, fidelity_table, option_table, paper_table};
use crease_trainer::config::{ChosenFrames, RunConfig};
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::options::TrainOptions;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::{Capture, Reading};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Plain networks that a processor trains in minutes; `--set` changes them, and without epochs none are trained.
const NETWORKS: [&str; 4] = [
    "deformation.network.width=128",
    "deformation.network.epoch_count=30",
    "laplacian.network.width=192",
    "laplacian.network.epoch_count=12",
];

/// The paper's form learns from every point of every scan, so a few passes show where it goes.
const PAPER_NETWORKS: [&str; 3] =
    ["deformation.points_a_frame=4000", "laplacian.network.epoch_count=4", "laplacian.points_a_step=20000"];

#[derive(Args)]
pub struct Arguments {
    /// Directory of a sequence with ground truth
    pub sequence: PathBuf,
    /// Shape and poses; body.npz of the sequence if left out
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// What is varied
    #[arg(long, value_enum, default_value_t = Subject::Fidelity)]
    pub what: Subject,
    /// Frames to train on, as a Python slice
    #[arg(long, value_name = "START:STOP:STEP", default_value = "1::2")]
    pub train: FrameRange,
    /// Frames to measure
    #[arg(long, value_name = "START:STOP:STEP", default_value = "0::2")]
    pub test: FrameRange,
    /// Numbers of basis functions (compact)
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48,64")]
    pub counts: Vec<usize>,
    /// Which of the paper's studies (paper) [default: those that the capture allows]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "STUDY")]
    pub studies: Vec<Study>,
    /// Option that is varied (option), for instance anchor_count
    #[arg(long, required_if_eq("what", "option"))]
    pub key: Option<String>,
    /// Its values
    #[arg(long, num_args = 1.., required_if_eq("what", "option"), value_name = "VALUE")]
    pub values: Vec<String>,
    /// What training starts from (option)
    #[arg(long, value_enum, default_value_t = Preset::Compact)]
    pub preset: Preset,
    /// Leave the paper's form out (fidelity)
    #[arg(long)]
    pub without_paper: bool,
    /// Where to write the rows (.json)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overrides an option of training; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Subject {
    /// Body, base, displacements in place of Laplacians, detail in compact and in plain form, the paper's form
    Fidelity,
    /// The number of basis functions of the compact form, and plain networks beside it
    Compact,
    /// Any option of training: --key, --values
    Option,
    /// What else the paper varies: anchors, operator, density, neighbourhood, regulariser, weighting
    Paper,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let (rows, table) = match arguments.what {
        Subject::Fidelity => fidelity(arguments)?,
        Subject::Compact => compact(arguments)?,
        Subject::Option => option(arguments)?,
        Subject::Paper => paper(arguments)?,
    };
    print!("{table}");
    if let Some(path) = &arguments.output {
        let record = json!({
            "sequence": arguments.sequence.file_name().map(|name| name.to_string_lossy()),
            "train": arguments.train.to_string(),
            "test": arguments.test.to_string(),
            "key": arguments.key,
            "rows": rows,
        });
        write_whole(path, (serde_json::to_string_pretty(&record)? + "\n").as_bytes())?;
    }
    Ok(())
}

/// The run that the arguments describe, `preset` with `networks` before what the user sets.
fn config(arguments: &Arguments, preset: Preset, networks: &[&str]) -> anyhow::Result<RunConfig> {
    let assignments = networks.iter().copied().chain(arguments.assignments.iter().map(String::as_str));
    let start = TrainOptions::preset(preset.name())?;
    Ok(RunConfig {
        output: PathBuf::new(),
        body: None,
        name: None,
        preset: preset.name().into(),
        sequences: vec![ChosenFrames {
            directory: arguments.sequence.clone(),
            poses: arguments.poses.clone(),
            reading: arguments.reading,
            frames: arguments.train,
        }],
        options: assignments.into_iter().try_fold(start, |options, text| options.with(text))?,
    })
}

/// The paper's form, small enough for a processor.
fn config_of_paper(arguments: &Arguments) -> anyhow::Result<RunConfig> {
    config(arguments, Preset::Paper, &[&NETWORKS[..], &PAPER_NETWORKS].concat())
}

fn fidelity(arguments: &Arguments) -> anyhow::Result<(Value, String)> {
    let context = config(arguments, Preset::Compact, &NETWORKS)?.prepare(Progress::Bars)?;
    let mut paper =
        (!arguments.without_paper).then(|| config_of_paper(arguments)?.prepare(Progress::Bars)).transpose()?;
    let frames = arguments.test.indices(context.sequences[0].capture.frame_count)?;
    let report = |row: &FidelityRow| eprint!("{}", row.line());
    let rows = ablation::fidelity(&context, paper.as_mut(), &frames, report)?;
    Ok((serde_json::to_value(&rows)?, fidelity_table(&rows)))
}

fn compact(arguments: &Arguments) -> anyhow::Result<(Value, String)> {
    let mut context = config(arguments, Preset::Compact, &NETWORKS)?.prepare(Progress::Bars)?;
    let sequence = context.sequences[0].clone();
    let frames = arguments.test.indices(sequence.capture.frame_count)?;
    let report = |row: &CompactRow| eprint!("{}", row.line());
    let rows = compact_against_plain(&mut context, &arguments.counts, &sequence, &frames, report)?;
    Ok((serde_json::to_value(&rows)?, compact_table(&rows)))
}

fn option(arguments: &Arguments) -> anyhow::Result<(Value, String)> {
    let config = config(arguments, arguments.preset, &[])?;
    let key = arguments.key.as_deref().context("--key: expected the key of an option, found none")?;
    let report = |row: &OptionRow| eprint!("{}", row.line());
    let rows = ablation::option(&config, key, &arguments.values, arguments.test, report)?;
    Ok((serde_json::to_value(&rows)?, option_table(key, &rows)))
}

fn paper(arguments: &Arguments) -> anyhow::Result<(Value, String)> {
    let (compact, paper) = (config(arguments, Preset::Compact, &[])?, config_of_paper(arguments)?);
    let is_depth = Capture::open_as(&arguments.sequence, &arguments.reading)?.camera().is_some();
    let allows = |study: &Study| is_depth || *study != Study::Weighting;
    if let Some(study) = arguments.studies.iter().find(|study| !allows(study)) {
        bail!("--studies {}: expected depth images, found point clouds, which all weigh the same", study.name());
    }
    let mut studies = arguments.studies.clone();
    if studies.is_empty() {
        studies.extend(Study::value_variants().iter().filter(|study| allows(study)));
    }
    let runs = PaperRuns { compact: &compact, paper: &paper, test: arguments.test };
    let rows = ablation::paper(&runs, &studies, |row: &PaperRow| eprint!("{}", row.line()))?;
    Ok((serde_json::to_value(&rows)?, paper_table(&rows)))
}
