//! `crease compact`.

use super::read_avatar;
use anyhow::ensure;
use clap::Args;
use crease::body::Pose;
use crease::motion::Motion;
use crease_trainer::compact::{CompactOptions, difference, distil};
use crease_trainer::files::write_whole;
use crease_trainer::options::TrainOptions;
use crease_trainer::sequence::{read, read_body};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Arguments {
    /// The avatar with perceptrons (.glb)
    pub avatar: PathBuf,
    /// Where to write the avatar with tables (.glb)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Poses to sample at: motions, or directories of sequences; best those that the avatar was trained on
    #[arg(long, value_name = "MOTION", num_args = 1.., required = true)]
    pub poses: Vec<PathBuf>,
    /// Sample at this many poses at most, evenly spread; the error is measured half-way between them
    #[arg(long, default_value_t = 64)]
    pub count: usize,
    /// Overrides an option, for instance compact.deformation.wide.basis_count=64; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let start = TrainOptions { compact: CompactOptions::for_perceptrons(), ..TrainOptions::compact() };
    let options = arguments.assignments.iter().try_fold(start, |options, assignment| options.with(assignment))?;
    let avatar = read_avatar(&arguments.avatar)?;
    let mut poses = Vec::new();
    for path in &arguments.poses {
        poses.extend(read_poses(path)?);
    }
    ensure!(arguments.count > 1, "--count: expected at least 2, found {}", arguments.count);
    let step = poses.len().div_ceil(arguments.count).max(2);
    let at = |first: usize| -> Vec<Pose> { poses.iter().skip(first).step_by(step).cloned().collect() };
    let (sampled, between) = (at(0), at(step / 2));

    let mut compact = distil(&avatar, &sampled, &options.compact)?;
    compact.provenance.insert("distilled".into(), serde_json::to_value(&options.compact)?);
    let bytes = compact.write();
    write_whole(&arguments.output, &bytes)?;
    println!("{}: {:.2} MB, sampled at {} poses", arguments.output.display(), bytes.len() as f64 / 1e6, sampled.len());
    for (name, poses) in [("at these poses", &sampled), ("between them", &between)] {
        let found = difference(&avatar, &compact.quantised(), poses)?;
        println!(
            "{name:16} f_d {:.3} mm, f_l {:.2} 1/m, vertices {:.3} mm (rms)",
            found.deformation_mm, found.laplacian_per_metre, found.vertices_mm
        );
    }
    Ok(())
}

fn read_poses(path: &Path) -> anyhow::Result<Vec<Pose>> {
    if path.is_dir() {
        // The functions do not see the root, so what is up makes no difference.
        return Ok(read_body(&path.join("body.npz"))?.parameters.poses);
    }
    // The rate tells only when a pose is shown.
    const ANY_RATE: f32 = 60.0;
    Ok(Motion::read(&read(path)?, &path.display().to_string(), Some(ANY_RATE))?.poses)
}
