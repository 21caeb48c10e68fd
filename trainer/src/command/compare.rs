//! `crease compare`.

use clap::Args;
use crease_trainer::config::read_body_model;
use crease_trainer::registration::{Accuracy, compare};
use crease_trainer::sequence::{Capture, Reading, Up, read_body};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// Shape and poses that were found: a body.npz
    pub found: PathBuf,
    /// The true ones
    pub truth: PathBuf,
    /// Their sequence: with a depth camera, what it sees is measured by itself
    #[arg(long, value_name = "SEQUENCE")]
    pub sequence: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Body model (.npz or SMPL's .pkl); the open body if left out
    #[arg(long, value_name = "FILE")]
    pub body: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let body = read_body_model(arguments.body.as_deref())?;
    let reading = &arguments.reading;
    let capture = arguments.sequence.as_deref().map(|sequence| Capture::open_as(sequence, reading)).transpose()?;
    let up = capture.as_ref().map(|capture| capture.poses_up).or(reading.poses_up).unwrap_or(Up::Y);
    let camera = capture.as_ref().and_then(Capture::camera);
    let root = |betas: &[f32]| body.shaped(betas).rest_joints[0];
    let [found, truth] = [read_body(&arguments.found)?, read_body(&arguments.truth)?].map(|body| body.y_up(up, root));
    let accuracy = compare(&body, &found, &truth, camera)?;
    if arguments.json {
        println!("{}", serde_json::to_string(&accuracy)?);
    } else {
        print(&accuracy);
    }
    Ok(())
}

fn print(accuracy: &Accuracy) {
    println!("mean over {} frames, mm", accuracy.frames_mm.len());
    println!("vertices            {:7.1}", accuracy.vertices_mm);
    if let Some(seen) = accuracy.seen_vertices_mm {
        println!("vertices seen       {seen:7.1}");
    }
    println!("joints              {:7.1}", accuracy.joints_mm);
    for (name, distance) in &accuracy.by_joint_mm {
        println!("  {name:18}{distance:7.1}");
    }
    let worst = (0..accuracy.frames_mm.len()).max_by(|&a, &b| accuracy.frames_mm[a].total_cmp(&accuracy.frames_mm[b]));
    if let Some(frame) = worst {
        println!("worst frame {frame}: vertices {:.1}", accuracy.frames_mm[frame]);
    }
}
