//! `crease demo`.

use super::{read_avatar, train};
use clap::Args;
use crease_trainer::evaluate::evaluate;
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::Sequence;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub struct Arguments {
    /// Directory of the shirt-dancer sequence
    pub sequence: PathBuf,
    /// Where to write the avatar; its figures go beside it, with the ending json
    #[arg(short, long, value_name = "FILE", default_value = "web/assets/shirt-dancer.glb")]
    pub output: PathBuf,
}

/// Trains on odd frames, measures on even ones.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let training = train::Arguments {
        sequences: vec![arguments.sequence.clone()],
        output: arguments.output.clone(),
        body: None,
        frames: vec!["1::2".parse()?],
        preset: train::Preset::Compact,
        seed: 0,
        assignments: Vec::new(),
        name: None,
    };
    train::run(&training)?;

    let sequence = Sequence::open(&arguments.sequence)?;
    let test: FrameRange = "0::2".parse()?;
    let frames = test.indices(sequence.frame_count)?;
    let bar = Progress::Bars.bar("measuring", frames.len());
    let evaluation = evaluate(Arc::new(read_avatar(&arguments.output)?), &sequence, &frames, || bar.advance(1))?;
    drop(bar);
    let record = json!({
        "command": train::command(&training),
        "seed": training.seed,
        "test": format!("{} {test}", sequence.name),
        "evaluation": evaluation,
    });
    let text = serde_json::to_string_pretty(&record)? + "\n";
    write_whole(&arguments.output.with_extension("json"), text.as_bytes())?;
    println!("{text}");
    Ok(())
}
