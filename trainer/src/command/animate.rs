//! `crease animate`.

use super::read_avatar;
use anyhow::ensure;
use clap::{Args, ValueEnum};
use crease::animate::{Animator, Options, Stage};
use crease::motion::Motion;
use crease_trainer::files::write_whole;
use crease_trainer::mesh_file::MeshFormat;
use crease_trainer::progress::Progress;
use crease_trainer::sequence::read;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb)
    pub avatar: PathBuf,
    /// The motion: AIST++ .pkl, AMASS or SMPL-X-style .npz
    pub motion: PathBuf,
    /// Directory of the meshes: one file a frame
    #[arg(short, long, value_name = "DIRECTORY")]
    pub output: PathBuf,
    /// The motion's frames a second: needed where the file does not say, and stronger where it does
    #[arg(long)]
    pub fps: Option<f32>,
    /// Kind of the files
    #[arg(long, value_enum, default_value_t = MeshFormat::Ply)]
    pub format: MeshFormat,
    /// How far down the pipeline to go
    #[arg(long, value_enum, default_value_t = StageName::Detailed)]
    pub stage: StageName,
    /// 0 is the base, 1 as trained, 2 exaggerated
    #[arg(long, default_value_t = 1.0)]
    pub detail: f32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StageName {
    /// The skinned body
    Body,
    /// The pose-dependent base mesh
    Base,
    /// The detailed mesh
    Detailed,
}

impl StageName {
    pub fn stage(self) -> Stage {
        match self {
            Self::Body => Stage::Body,
            Self::Base => Stage::Base,
            Self::Detailed => Stage::Detailed,
        }
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(arguments.detail.is_finite(), "--detail: expected a finite number, found {}", arguments.detail);
    let mut animator = Animator::new(Arc::new(read_avatar(&arguments.avatar)?))?;
    let motion = Motion::read(&read(&arguments.motion)?, &arguments.motion.display().to_string(), arguments.fps)?;
    for note in &motion.notes {
        eprintln!("note: {note}");
    }
    let options =
        Options { stage: arguments.stage.stage(), detail: arguments.detail, warm_start: true, ..Options::default() };
    let triangles = animator.triangles().to_vec();
    let bar = Progress::Bars.bar("animating", motion.poses.len());
    for (index, pose) in motion.poses.iter().enumerate() {
        let bytes = arguments.format.encode(animator.animate(pose, &options), &triangles);
        write_whole(&arguments.output.join(format!("{index:05}.{}", arguments.format.extension())), &bytes)?;
        bar.advance(1);
    }
    drop(bar);
    println!(
        "{}: {} meshes at {} frames a second",
        arguments.output.display(),
        motion.poses.len(),
        motion.frames_per_second
    );
    Ok(())
}
