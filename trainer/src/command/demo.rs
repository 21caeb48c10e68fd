//! `crease demo`: the avatars that the page shows, remade from their sequences.

use super::{open_sequence, read_avatar, train};
use clap::{Args, ValueEnum};
use crease::avatar::Avatar;
use crease_trainer::config::{ChosenFrames, RunConfig, read_body_model};
use crease_trainer::evaluate::{Evaluation, evaluate};
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::options::TrainOptions;
use crease_trainer::progress::Progress;
use crease_trainer::registration::{Accuracy, Hints, compare, register};
use crease_trainer::sequence::{Capture, Reading, Up, read_body, write_body};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// One of the page's avatars.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Subject {
    /// Point clouds from all around and true poses; four clips
    ShirtDancer,
    /// One depth camera; shape and poses are estimated from its images
    TeeTurner,
}

struct Recipe {
    /// The person's sequences and the frames to train on.
    training: &'static [(&'static str, &'static str)],
    /// What it is measured on.
    tests: &'static [(&'static str, &'static str)],
    /// Whether poses are estimated, and the true ones left alone.
    is_registered: bool,
}

impl Subject {
    fn name(self) -> &'static str {
        match self {
            Self::ShirtDancer => "shirt-dancer",
            Self::TeeTurner => "tee-turner",
        }
    }

    fn recipe(self) -> Recipe {
        match self {
            // Tests: frames between those of training, and a dance that was never seen.
            Self::ShirtDancer => Recipe {
                training: &[
                    ("shirt-dancer", "1::2"),
                    ("aist-krump", "1::2"),
                    ("aist-jazz", "::"),
                    ("aist-break-2", "::"),
                ],
                tests: &[("shirt-dancer", "0::2"), ("aist-lahop", "0::2")],
                is_registered: false,
            },
            Self::TeeTurner => {
                Recipe { training: &[("tee-turner", "1::2")], tests: &[("tee-turner", "0::2")], is_registered: true }
            }
        }
    }
}

#[derive(Args)]
pub struct Arguments {
    /// Directory that holds the sequences
    pub sequences: PathBuf,
    /// Which avatar
    #[arg(long, value_enum, default_value_t = Subject::ShirtDancer)]
    pub subject: Subject,
    /// Where to write the avatar, web/assets/SUBJECT.glb if left out; its figures go beside it, with the ending json
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Trains on the subject's sequences and measures on frames that training did not see.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let name = arguments.subject.name();
    let recipe = arguments.subject.recipe();
    let output = arguments.output.clone().unwrap_or_else(|| Path::new("web/assets").join(format!("{name}.glb")));
    let place = |(sequence, _): &(&str, &str)| arguments.sequences.join(sequence);
    let mut record = json!({});
    let mut poses = Vec::new();
    if recipe.is_registered {
        for entry in recipe.training {
            let path = std::env::temp_dir().join(format!("crease-{}-body.npz", entry.0));
            let accuracy = estimate(&place(entry), &path)?;
            record["registration"][entry.0] = serde_json::to_value(accuracy)?;
            poses.push(path);
        }
    }
    let chosen = |(index, entry): (usize, &(&str, &str))| -> anyhow::Result<ChosenFrames> {
        Ok(ChosenFrames {
            directory: place(entry),
            poses: poses.get(index).cloned(),
            reading: Reading::default(),
            frames: entry.1.parse()?,
        })
    };
    let training = RunConfig {
        output: output.clone(),
        body: None,
        name: None,
        preset: "compact".into(),
        sequences: recipe.training.iter().enumerate().map(chosen).collect::<anyhow::Result<_>>()?,
        options: TrainOptions::compact(),
    };
    let kept =
        train::Kept { directory: output.with_extension("checkpoint"), interval: Duration::from_secs(30), stays: false };
    train::execute(&training, Progress::Bars, &kept)?;

    let avatar = Arc::new(read_avatar(&output)?);
    let mut tests = Vec::new();
    for (index, entry) in recipe.tests.iter().enumerate() {
        let (sequence, frames) = entry;
        let measured = |liveliness| measure(Arc::clone(&avatar), &place(entry), poses.get(index), frames, liveliness);
        let (evaluation, lively) = (measured(0.0)?, measured(1.0)?);
        tests.push(json!({ "test": format!("{sequence} {frames}"), "evaluation": evaluation, "lively": lively }));
    }
    record["command"] = json!(training.command());
    record["seed"] = json!(training.options.seed);
    record["tests"] = Value::Array(tests);
    let text = serde_json::to_string_pretty(&record)? + "\n";
    write_whole(&output.with_extension("json"), text.as_bytes())?;
    println!("{text}");
    Ok(())
}

/// Registers the body with a sequence, writes it to `path`, and says how far it is from the truth, if there is one.
fn estimate(sequence: &Path, path: &Path) -> anyhow::Result<Option<Accuracy>> {
    let body = read_body_model(None)?;
    let capture = Capture::open(sequence)?;
    let registration = register(&capture, &body, &Hints::default(), Progress::Bars)?;
    write_body(path, &registration.parameters, Up::Y, capture.frames_per_second)?;
    let truth = sequence.join("body.npz");
    if !truth.exists() {
        return Ok(None);
    }
    let truth = read_body(&truth)?.y_up(capture.poses_up, |betas| body.shaped(betas).rest_joints[0]);
    Ok(Some(compare(&body, &registration.parameters, &truth, capture.camera())?))
}

fn measure(
    avatar: Arc<Avatar>,
    sequence: &Path,
    poses: Option<&PathBuf>,
    frames: &str,
    liveliness: f32,
) -> anyhow::Result<Evaluation> {
    let sequence = open_sequence(&avatar, sequence, poses, &Reading::default())?;
    let frames = frames.parse::<FrameRange>()?.indices(sequence.capture.frame_count)?;
    let bar = Progress::Bars.bar("measuring", frames.len());
    evaluate(avatar, &sequence, &frames, liveliness, || bar.advance(1))
}
