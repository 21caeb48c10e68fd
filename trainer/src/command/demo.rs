//! `crease demo`.

use super::{read_avatar, train};
use clap::Args;
use crease::avatar::Avatar;
use crease_trainer::config::{ChosenFrames, RunConfig};
use crease_trainer::evaluate::{Evaluation, evaluate};
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::options::TrainOptions;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::Sequence;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The person's sequences and the frames to train on.
const TRAINING: [(&str, &str); 4] =
    [("shirt-dancer", "1::2"), ("aist-krump", "1::2"), ("aist-jazz", "::"), ("aist-break-2", "::")];

/// What it is measured on: frames between those of training, and a dance that was never seen.
const TESTS: [(&str, &str); 2] = [("shirt-dancer", "0::2"), ("aist-lahop", "0::2")];

#[derive(Args)]
pub struct Arguments {
    /// Directory that holds the sequences shirt-dancer, aist-krump, aist-jazz, aist-break-2 and aist-lahop
    pub sequences: PathBuf,
    /// Where to write the avatar; its figures go beside it, with the ending json
    #[arg(short, long, value_name = "FILE", default_value = "web/assets/shirt-dancer.glb")]
    pub output: PathBuf,
}

/// Trains on all of the clips but one, and measures.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let chosen = |(name, frames): &(&str, &str)| -> anyhow::Result<ChosenFrames> {
        Ok(ChosenFrames { directory: arguments.sequences.join(name), frames: frames.parse()? })
    };
    let training = RunConfig {
        output: arguments.output.clone(),
        body: None,
        name: None,
        preset: "compact".into(),
        sequences: TRAINING.iter().map(chosen).collect::<anyhow::Result<_>>()?,
        options: TrainOptions::compact(),
    };
    let kept = train::Kept {
        directory: arguments.output.with_extension("checkpoint"),
        interval: Duration::from_secs(30),
        stays: false,
    };
    train::execute(&training, Progress::Bars, &kept)?;

    let avatar = Arc::new(read_avatar(&arguments.output)?);
    let mut tests = Vec::new();
    for (name, frames) in TESTS {
        let evaluation = measure(Arc::clone(&avatar), &arguments.sequences.join(name), frames)?;
        tests.push(json!({ "test": format!("{name} {frames}"), "evaluation": evaluation }));
    }
    let record = json!({ "command": training.command(), "seed": training.options.seed, "tests": tests });
    let text = serde_json::to_string_pretty(&record)? + "\n";
    write_whole(&arguments.output.with_extension("json"), text.as_bytes())?;
    println!("{text}");
    Ok(())
}

fn measure(avatar: Arc<Avatar>, sequence: &Path, frames: &str) -> anyhow::Result<Evaluation> {
    let sequence = Sequence::open(sequence)?;
    let frames = frames.parse::<FrameRange>()?.indices(sequence.frame_count)?;
    let bar = Progress::Bars.bar("measuring", frames.len());
    evaluate(avatar, &sequence, &frames, || bar.advance(1))
}
