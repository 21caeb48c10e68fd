//! `crease register`.

use super::ensure_placed;
use anyhow::ensure;
use clap::Args;
use crease_trainer::config::read_body_model;
use crease_trainer::progress::Progress;
use crease_trainer::registration::{Hints, read_keypoints, register};
use crease_trainer::sequence::{Capture, Reading, Up, read_first_pose, write_body};
use std::path::{Path, PathBuf};
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
    #[command(flatten)]
    pub reading: Reading,
    /// Joints in space, or in the camera's pictures as OpenPose (a folder), COCO or MediaPipe write them (JSON)
    #[arg(long, value_name = "FILE")]
    pub keypoints: Option<PathBuf>,
    /// Replaces a file that is there
    #[arg(long)]
    pub force: bool,
    /// Go on even where units or axes of the scans seem to be others than they are read in
    #[arg(long)]
    pub unchecked: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let begin = Instant::now();
    let capture = Capture::open_as(&arguments.sequence, &arguments.reading)?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.sequence.join("body.npz"));
    ensure!(
        arguments.force || !output.exists(),
        "{}: expected no file, found one: --force replaces it, -o writes elsewhere",
        output.display()
    );
    let body = read_body_model(arguments.body.as_deref())?;
    if !arguments.unchecked {
        ensure_placed(&capture, &body, Path::new(""))?;
    }
    let initial_pose = match &arguments.initial_pose {
        None => None,
        Some(path) => read_first_pose(path, capture.poses_up, body.shaped(&[]).rest_joints[0])?,
    };
    let mut keypoints = match &arguments.keypoints {
        None => Vec::new(),
        Some(path) => read_keypoints(path, capture.frame_count, &body.joint_names, capture.camera())?,
    };
    for (_, position) in keypoints.iter_mut().flat_map(|frame| &mut frame.space) {
        *position = capture.orientation.matrix() * *position;
    }
    let hints = Hints { initial_pose, keypoints };
    let registration = register(&capture, &body, &hints, Progress::Bars)?;
    write_body(&output, &registration.parameters, Up::Y, capture.frames_per_second)?;
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
