//! `crease animate`.

use super::read_avatar;
use super::shown::Shown;
use anyhow::{bail, ensure};
use clap::{Args, ValueEnum};
use crease::animate::{Animator, Stage};
use crease::motion::Motion;
use crease_trainer::animation::{Length, UsdaFile, bake, skinned_glb};
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
    /// Directory of the meshes, one file a frame; or one file with the whole motion, NAME.usda or NAME.glb
    #[arg(short, long, value_name = "OUTPUT")]
    pub output: PathBuf,
    /// The motion's frames a second: needed where the file does not say, and stronger where it does
    #[arg(long)]
    pub fps: Option<f32>,
    /// Kind of the files [default: as the output's name ends, or else ply]
    #[arg(long, value_enum)]
    pub format: Option<Format>,
    #[command(flatten)]
    pub shown: Shown,
}

/// Kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// glTF: a mesh a frame in a directory; or, to a name that ends in .glb, one skinned figure that moves, wrinkles baked into a normal map
    Glb,
    /// Wavefront OBJ: text
    Obj,
    /// PLY, binary little endian
    Ply,
    /// USD as text: one file with the mesh of every frame, and the texture beside it
    Usda,
}

impl Format {
    /// What the user wants, and whether in one file.
    fn wanted(arguments: &Arguments) -> anyhow::Result<(Self, bool)> {
        let output = &arguments.output;
        let ending = output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        let named = match ending.as_deref() {
            Some("usda") => Some(Self::Usda),
            Some("glb") => Some(Self::Glb),
            _ => None,
        };
        match (arguments.format, named) {
            (Some(Self::Usda), None) => bail!("{}: expected a name that ends in .usda", output.display()),
            (Some(format), Some(named)) if format != named => {
                bail!("{}: expected the name of a directory, or the format that the name ends in", output.display())
            }
            (format, named) => Ok((format.or(named).unwrap_or(Self::Ply), named.is_some())),
        }
    }

    /// The kind of one frame's file.
    fn mesh(self) -> MeshFormat {
        match self {
            Self::Glb => MeshFormat::Glb,
            Self::Obj => MeshFormat::Obj,
            Self::Ply | Self::Usda => MeshFormat::Ply,
        }
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let options = arguments.shown.options()?;
    let mut animator = Animator::new(Arc::new(read_avatar(&arguments.avatar)?))?;
    let motion = Motion::read(&read(&arguments.motion)?, &arguments.motion.display().to_string(), arguments.fps)?;
    for note in &motion.notes {
        eprintln!("note: {note}");
    }
    let output = &arguments.output;
    let bar = Progress::Bars.bar("animating", motion.poses.len());
    let what = match Format::wanted(arguments)? {
        (Format::Usda, _) => {
            let length = Length { frame_count: motion.poses.len(), frames_per_second: motion.frames_per_second };
            let mut file = UsdaFile::create(output, animator.avatar(), animator.triangles(), length)?;
            for pose in &motion.poses {
                file.frame(animator.animate(pose, &options))?;
                bar.advance(1);
            }
            file.finish()?;
            "meshes"
        }
        (Format::Glb, true) => {
            ensure!(
                options.stage == Stage::Detailed && options.detail == 1.0,
                "--stage, --detail: expected none where the detail is baked into one file"
            );
            let figure = bake(&mut animator, &motion.poses, options.liveliness)?;
            write_whole(output, &skinned_glb(animator.avatar(), &figure, &motion))?;
            "poses of a skinned figure"
        }
        (format, _) => {
            let (format, triangles) = (format.mesh(), animator.triangles().to_vec());
            for (index, pose) in motion.poses.iter().enumerate() {
                let bytes = format.encode(animator.animate(pose, &options), &triangles);
                write_whole(&output.join(format!("{index:05}.{}", format.extension())), &bytes)?;
                bar.advance(1);
            }
            "meshes"
        }
    };
    drop(bar);
    println!("{}: {} {what} at {} frames a second", output.display(), motion.poses.len(), motion.frames_per_second);
    Ok(())
}
