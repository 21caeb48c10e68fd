//! `crease register`.

use anyhow::ensure;
use clap::Args;
use crease::motion::Motion;
use crease_trainer::config::read_body_model;
use crease_trainer::progress::Progress;
use crease_trainer::registration::{Hints, read_keypoints, register};
use crease_trainer::sequence::{Capture, read, write_body};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct Arguments {
    /// Directory of a sequence: sequence.json and its scans; its body.npz is not read
    pub sequence: PathBuf,
    /// Where to write shape and poses; body.npz of the sequence if left out
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Body model (.npz or SMPL's .pkl); the open body if left out
    #[arg(long, value_name = "FILE")]
    pub body: Option<PathBuf>,
    /// A pose near that of the first frame: the first of an AMASS-style .npz. Without it the person is taken to stand near upright
    #[arg(long, value_name = "FILE")]
    pub initial_pose: Option<PathBuf>,
    /// Joints in space, or in the camera's pictures as OpenPose (a folder), COCO or MediaPipe write them (JSON)
    #[arg(long, value_name = "FILE")]
    pub keypoints: Option<PathBuf>,
    /// Replaces a file that is there
    #[arg(long)]
    pub force: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let begin = Instant::now();
    let capture = Capture::open(&arguments.sequence)?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.sequence.join("body.npz"));
    ensure!(
        arguments.force || !output.exists(),
        "{}: expected no file, found one: --force replaces it, -o writes elsewhere",
        output.display()
    );
    let body = read_body_model(arguments.body.as_deref())?;
    // The rate tells only when a pose is shown.
    const ANY_RATE: f32 = 60.0;
    let initial_pose = match &arguments.initial_pose {
        None => None,
        Some(path) => Motion::read(&read(path)?, &path.display().to_string(), Some(ANY_RATE))?.poses.into_iter().next(),
    };
    let keypoints = match &arguments.keypoints {
        None => Vec::new(),
        Some(path) => read_keypoints(path, capture.frame_count, &body.joint_names, capture.camera())?,
    };
    let hints = Hints { initial_pose, keypoints };
    let registration = register(&capture, &body, &hints, Progress::Bars)?;
    write_body(&output, &registration.parameters, capture.frames_per_second)?;
    let mean = registration.distances.iter().sum::<f64>() / registration.distances.len() as f64;
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "{}: {} frames in {seconds:.1} s, {:.2} s a frame; scan to body {:.1} mm",
        output.display(),
        capture.frame_count,
        seconds / capture.frame_count as f64,
        1e3 * mean
    );
    for &frame in &registration.failing {
        println!("frame {frame}: the body stays {:.1} mm from the scan", 1e3 * registration.distances[frame]);
    }
    Ok(())
}
