//! `crease import`.

use clap::Args;
use crease_trainer::import::{Layout, Source, import};
use crease_trainer::sequence::{Axis, Orientation, Up};
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// What kind of files these are
    #[arg(value_enum)]
    pub layout: Layout,
    /// Folder of one sequence's .npz files
    pub source: PathBuf,
    /// Where to make the sequence
    #[arg(short, long, value_name = "SEQUENCE")]
    pub output: PathBuf,
    /// Folder of the scans, where they lie apart
    #[arg(long, value_name = "FOLDER")]
    pub scans: Option<PathBuf>,
    /// Frames a second, which the files do not say
    #[arg(long)]
    pub fps: f32,
    /// Unit of the scans: metre, centimetre or millimetre
    #[arg(long, default_value = "metre")]
    pub units: String,
    /// What is up in the scans and poses
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true, default_value_t = Up::Y)]
    pub up: Up,
    /// The scans are mirror images: change the sign of this axis
    #[arg(long, value_enum, value_name = "AXIS")]
    pub mirrored: Option<Axis>,
    /// What is up in the poses, where it is not what is up in the scans
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true)]
    pub poses_up: Option<Up>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let name = arguments.output.file_name().unwrap_or(arguments.output.as_os_str()).to_string_lossy().into_owned();
    let source = Source {
        frames: arguments.source.clone(),
        scans: arguments.scans.clone(),
        name,
        frames_per_second: arguments.fps,
        units: arguments.units.clone(),
        orientation: Orientation { up: arguments.up, mirrored: arguments.mirrored },
        poses_up: arguments.poses_up.unwrap_or(arguments.up),
    };
    let imported = import(arguments.layout, &source, &arguments.output)?;
    println!("{}: {} frames, {}", arguments.output.display(), imported.frame_count, imported.body.display());
    if imported.body.ends_with("poses.npz") {
        let (sequence, poses) = (arguments.output.display(), imported.body.display());
        println!("the files have no shape of the body: crease register {sequence} --initial-pose {poses}");
    }
    Ok(())
}
