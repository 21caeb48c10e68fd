//! `crease eval`.

use super::{open_sequence, read_avatar};
use clap::Args;
use crease_trainer::evaluate::{Evaluation, Measures, evaluate};
use crease_trainer::frames::FrameRange;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::Reading;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb)
    pub avatar: PathBuf,
    /// Directory of a sequence with ground truth; scans are not needed
    pub sequence: PathBuf,
    /// Shape and poses; body.npz of the sequence if left out
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Frames to measure, as a Python slice
    #[arg(long, value_name = "START:STOP:STEP", default_value = "::")]
    pub frames: FrameRange,
    /// What poses far from training wear: 0 what is likeliest, 1 the folds of the nearest training poses, as a page shows
    #[arg(long, default_value_t = 0.0)]
    pub liveliness: f32,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let avatar = Arc::new(read_avatar(&arguments.avatar)?);
    let sequence = open_sequence(&avatar, &arguments.sequence, arguments.poses.as_ref(), &arguments.reading)?;
    let frames = arguments.frames.indices(sequence.capture.frame_count)?;
    let bar = Progress::Bars.bar("measuring", frames.len());
    let evaluation = evaluate(avatar, &sequence, &frames, arguments.liveliness, || bar.advance(1))?;
    drop(bar);
    if arguments.json {
        println!("{}", serde_json::to_string(&evaluation)?);
    } else {
        print(&evaluation);
    }
    Ok(())
}

fn print(evaluation: &Evaluation) {
    println!("{} frames      scan→mesh cm  mesh→scan cm  normal consistency", evaluation.frames);
    let row = |name: &str, Measures { scan_to_mesh_cm, mesh_to_scan_cm, nc }: Measures| {
        println!("{name:14} {scan_to_mesh_cm:12.3} {mesh_to_scan_cm:13.3} {nc:19.4}");
    };
    row("body", evaluation.body);
    row("base", evaluation.base);
    row("detailed", evaluation.detailed);
}
