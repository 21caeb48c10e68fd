//! `crease train`.

use super::report::{self, Wanted};
use super::{ensure_placed, interrupt, open_sequence, read_avatar};
use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use crease::avatar::Avatar;
use crease::numpy::ReadError;
use crease_trainer::checkpoint::Checkpoint;
use crease_trainer::config::{ChosenFrames, OPEN_BODY_NOTICE, RunConfig, read_body_model};
use crease_trainer::context::TrainContext;
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::interrupt::Interrupted;
use crease_trainer::options::{ComputeDevice, TrainOptions};
use crease_trainer::progress::Progress;
use crease_trainer::refinement::refine_poses;
use crease_trainer::sequence::{BodyParameters, Capture, Reading, Up, write_body};
use crease_trainer::train::{Facts, train};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Rounds of `--refine`; `--set refinement.round_count` chooses others.
const REFINEMENT_ROUNDS: usize = 2;
/// The run itself, in a checkpoint's directory.
const CONFIG: &str = "run.toml";

#[derive(Args, Clone)]
pub struct Arguments {
    /// Directories of sequences: sequence.json, body.npz, frames/
    #[arg(required_unless_present_any = ["config", "resume"], value_name = "SEQUENCE")]
    pub sequences: Vec<PathBuf>,
    /// Where to write the avatar (.glb); the run's options (.toml) and its log (.csv) go beside it
    #[arg(short, long, required_unless_present_any = ["config", "resume"], value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Body model (.npz or SMPL's .pkl); the open body if left out
    #[arg(long, value_name = "FILE")]
    pub body: Option<PathBuf>,
    /// Shape and poses, for sequences in order; body.npz of each if left out
    #[arg(long, value_name = "FILE")]
    pub poses: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Frames to train on, as a Python slice; give one for all sequences or one for each [default: all]
    #[arg(long, value_name = "START:STOP:STEP")]
    pub frames: Vec<FrameRange>,
    /// Where the options start from [default: compact]
    #[arg(long, value_enum, conflicts_with = "config")]
    pub preset: Option<Preset>,
    /// Seed of every random choice [default: 0]
    #[arg(long)]
    pub seed: Option<u64>,
    /// Where networks of the paper's form are trained [default: cpu]
    #[arg(long, value_enum)]
    pub device: Option<ComputeDevice>,
    /// Overrides an option, for instance deformation.network.width=64; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Name of the avatar; the first sequence's if left out
    #[arg(long)]
    pub name: Option<String>,
    /// Take the run from a file that another run wrote; what is given beside it counts more
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Go on with a run that was broken off, from its checkpoint
    #[arg(long, value_name = "DIRECTORY", conflicts_with_all = ["sequences", "output", "body", "poses", "up", "mirrored", "poses_up", "frames", "preset", "seed", "device", "refine", "assignments", "name", "config", "checkpoint"])]
    pub resume: Option<PathBuf>,
    /// Where work is kept while the run lasts, and after it [default: beside the output until the run is done]
    #[arg(long, value_name = "DIRECTORY")]
    pub checkpoint: Option<PathBuf>,
    /// Keep the state of a network under training so often
    #[arg(long, value_name = "SECONDS", default_value_t = 30)]
    pub checkpoint_every: u64,
    /// Refine the poses with the clothes that training finds, before it trains; they are written beside the avatar, AVATAR-SEQUENCE.npz
    #[arg(long)]
    pub refine: bool,
    /// Write a page about the avatar beside it (.html), as `crease report` does: on the first sequence, frames that were not trained on
    #[arg(long)]
    pub report: bool,
    /// Go on even where units or axes of the scans seem to be others than they are read in, or poses lie beside them
    #[arg(long)]
    pub unchecked: bool,
    /// Say nothing but errors
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Tell progress and result in lines of JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Preset {
    /// What a browser plays every frame
    Compact,
    /// The paper to the letter; meant for a GPU
    Paper,
}

impl Preset {
    pub fn name(self) -> &'static str {
        match self {
            Self::Compact => "compact",
            Self::Paper => "paper",
        }
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let config = config(arguments)?;
    let progress = match (arguments.quiet, arguments.json) {
        (true, _) => Progress::Silent,
        (_, true) => Progress::Json,
        _ => Progress::Bars,
    };
    if arguments.resume.is_none() && !arguments.unchecked {
        check_places(&config)?;
    }
    let directory = arguments.resume.clone().or_else(|| arguments.checkpoint.clone());
    let kept = Kept {
        interval: Duration::from_secs(arguments.checkpoint_every),
        stays: directory.is_some(),
        directory: directory.unwrap_or_else(|| config.output.with_extension("checkpoint")),
    };
    execute(&config, progress, &kept)?;
    config.write(&config.output.with_extension("toml"))?;
    if arguments.report { report(&config, progress) } else { Ok(()) }
}

/// Looks at a few scans of each sequence, and at the poses beside them.
fn check_places(config: &RunConfig) -> anyhow::Result<()> {
    let body = read_body_model(config.body.as_deref())?;
    for chosen in &config.sequences {
        let capture = Capture::open_as(&chosen.directory, &chosen.reading)?;
        let poses = chosen.poses.clone().unwrap_or_else(|| chosen.directory.join("body.npz"));
        ensure_placed(&capture, &body, &poses)?;
    }
    Ok(())
}

/// The page about what was trained.
fn report(config: &RunConfig, progress: Progress) -> anyhow::Result<()> {
    let avatar = Arc::new(read_avatar(&config.output)?);
    let is_refined = config.options.refinement.is_on();
    let open = |(chosen, refined): (&ChosenFrames, PathBuf)| {
        let poses = if is_refined { Some(&refined) } else { chosen.poses.as_ref() };
        open_sequence(&avatar, &chosen.directory, poses, &chosen.reading)
    };
    let sequences = config.sequences.iter().zip(refined_files(config)).map(open).collect::<Result<Vec<_>, _>>()?;
    let (first, others) = sequences.split_first().context("sequences: expected at least one, found none")?;
    let wanted = Wanted {
        avatar: &config.output,
        output: config.output.with_extension("html"),
        frames: None,
        pictures: 3,
        energy_frames: 4,
        liveliness: 0.0,
        progress,
    };
    let (residue, bytes) = report::write(&wanted, Arc::clone(&avatar), first, others)?;
    let output = wanted.output.display();
    match progress {
        Progress::Bars => println!("{output}: {:.1} MB, {} frames", bytes as f64 / 1e6, residue.frames.len()),
        Progress::Json => println!("{}", json!({ "report": wanted.output, "evaluation": residue.evaluation })),
        Progress::Silent => {}
    }
    Ok(())
}

/// Where and how often a run's work is kept.
pub struct Kept {
    pub directory: PathBuf,
    pub interval: Duration,
    /// Whether the directory stays when the run is done.
    pub stays: bool,
}

/// Trains, writes the avatar and says so.
pub fn execute(config: &RunConfig, progress: Progress, kept: &Kept) -> anyhow::Result<()> {
    let begin = Instant::now();
    let mut context = config.prepare(progress)?;
    let output = &config.output;
    ensure!(!output.is_dir(), "{}: expected the name of a file, found a directory", output.display());
    context.checkpoint = Checkpoint::open(&kept.directory, kept.interval, interrupt()?)?;
    config.write(&kept.directory.join(CONFIG))?;
    let mut facts = Facts {
        name: config.name.clone().unwrap_or_else(|| context.sequences[0].capture.name.clone()),
        command: config.command(),
        preset: config.preset.clone(),
        notices: Vec::new(),
    };
    if config.body.is_none() {
        facts.notices.push(OPEN_BODY_NOTICE.into());
    }
    let avatar =
        refine_and_train(&mut context, config, &facts).map_err(|error| how_to_go_on(error, &kept.directory))?;
    let bytes = avatar.write();
    write_whole(output, &bytes)?;
    context.log.write(&output.with_extension("csv"))?;
    let (frames, seconds) = (context.samples.len(), begin.elapsed().as_secs_f64());
    drop(context);
    if !kept.stays {
        let directory = &kept.directory;
        std::fs::remove_dir_all(directory)
            .with_context(|| format!("{}: the checkpoint cannot be removed", directory.display()))?;
    }
    match progress {
        Progress::Bars => println!(
            "{}: {:.2} MB, trained on {frames} frames in {seconds:.0} s",
            output.display(),
            bytes.len() as f64 / 1e6
        ),
        Progress::Json => {
            let result = json!({ "avatar": output, "bytes": bytes.len(), "frames": frames, "seconds": seconds });
            println!("{result}");
        }
        Progress::Silent => {}
    }
    Ok(())
}

/// Trains, on refined poses where the options ask for them, and writes these.
fn refine_and_train(context: &mut TrainContext, config: &RunConfig, facts: &Facts) -> anyhow::Result<Avatar> {
    refine_poses(context)?;
    let avatar = train(context, facts)?;
    if context.options.refinement.is_on() {
        for (sequence, path) in context.sequences.iter().zip(refined_files(config)) {
            let body = BodyParameters { betas: sequence.betas.clone(), poses: sequence.poses.clone() };
            write_body(&path, &body, Up::Y, sequence.capture.frames_per_second)?;
        }
    }
    Ok(avatar)
}

/// Where the refined poses of each sequence go.
fn refined_files(config: &RunConfig) -> impl Iterator<Item = PathBuf> + '_ {
    let name = config.output.file_stem().unwrap_or_default().to_string_lossy();
    config.sequences.iter().map(move |sequence| {
        let sequence = sequence.directory.file_name().unwrap_or_default().to_string_lossy();
        config.output.with_file_name(format!("{name}-{sequence}.npz"))
    })
}

fn how_to_go_on(error: anyhow::Error, directory: &Path) -> anyhow::Error {
    let hint = format!("crease train --resume {}", directory.display());
    if error.is::<Interrupted>() {
        error.context(format!("stopped; what was done is kept, and this goes on with it: {hint}"))
    } else {
        let left_out = if error.is::<ReadError>() { "; --frames leaves frames out" } else { "" };
        error.context(format!("training failed; once this is mended, `{hint}` goes on with what was done{left_out}"))
    }
}

/// The run that the arguments ask for.
pub fn config(arguments: &Arguments) -> anyhow::Result<RunConfig> {
    if let Some(directory) = &arguments.resume {
        return RunConfig::read(&directory.join(CONFIG));
    }
    let mut config = match &arguments.config {
        Some(path) => RunConfig::read(path)?,
        None => {
            let preset = arguments.preset.unwrap_or(Preset::Compact).name();
            RunConfig {
                output: PathBuf::new(),
                body: None,
                name: None,
                preset: preset.to_owned(),
                sequences: Vec::new(),
                options: TrainOptions::preset(preset)?,
            }
        }
    };
    config.output = arguments.output.clone().unwrap_or(config.output);
    config.body = arguments.body.clone().or(config.body);
    config.name = arguments.name.clone().or(config.name);
    config.options.seed = arguments.seed.unwrap_or(config.options.seed);
    config.options.device = arguments.device.unwrap_or(config.options.device);
    if arguments.refine && config.options.refinement.round_count == 0 {
        config.options.refinement.round_count = REFINEMENT_ROUNDS;
    }
    for assignment in &arguments.assignments {
        config.options = config.options.with(assignment)?;
    }
    if !arguments.sequences.is_empty() {
        let all = |directory: &PathBuf| ChosenFrames {
            directory: directory.clone(),
            poses: None,
            reading: Reading::default(),
            frames: FrameRange::ALL,
        };
        config.sequences = arguments.sequences.iter().map(all).collect();
    }
    let (ranges, count) = (&arguments.frames, config.sequences.len());
    ensure!(
        [0, 1, count].contains(&ranges.len()),
        "--frames: expected one for all sequences or one for each of {count}, found {}",
        ranges.len()
    );
    for (sequence, range) in config.sequences.iter_mut().zip(ranges.iter().cycle()) {
        sequence.frames = *range;
    }
    if !arguments.reading.is_default() {
        config.sequences.iter_mut().for_each(|sequence| sequence.reading = arguments.reading);
    }
    let poses = &arguments.poses;
    ensure!(
        [0, count].contains(&poses.len()),
        "--poses: expected none or one for each of {count} sequences, found {}",
        poses.len()
    );
    for (sequence, poses) in config.sequences.iter_mut().zip(poses) {
        sequence.poses = Some(poses.clone());
    }
    Ok(config)
}
