//! `crease inspect`.

use clap::Args;
use crease::avatar::Avatar;
use crease::motion::Motion;
use crease::network::SurfaceFunction;
use crease_trainer::coefficients::{largest_ratio, motion_ranges, training_ranges};
use crease_trainer::motion_measures::{OVERSTRETCHED, measure_motion};
use crease_trainer::sequence::read;
use crease_trainer::sizes::section_sizes;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb)
    pub avatar: PathBuf,
    /// Motions to compare the coefficients of compact functions with: their largest size, as a multiple of that in training
    #[arg(long, value_name = "MOTION", num_args = 1..)]
    pub coefficients: Vec<PathBuf>,
    /// Motions to play through the detailed mesh: is it finite, are edges overstretched, does detail flicker
    #[arg(long, value_name = "MOTION", num_args = 1.., conflicts_with = "coefficients")]
    pub motion_measures: Vec<PathBuf>,
    /// The motions' frames a second: needed where a file does not say, and stronger where it does
    #[arg(long, requires = "motion_measures")]
    pub fps: Option<f32>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let bytes = read(&arguments.avatar)?;
    let avatar = Avatar::read(&bytes, &arguments.avatar.display().to_string())?;
    if !arguments.coefficients.is_empty() {
        return coefficients(&avatar, &arguments.coefficients);
    }
    if !arguments.motion_measures.is_empty() {
        return measures(avatar, &arguments.motion_measures, arguments.fps);
    }
    println!("{}: {:.2} MB", avatar.name, bytes.len() as f64 / 1e6);
    println!("  body         {} vertices, {} joints", avatar.rig.rest.len(), avatar.rig.parents.len());
    println!("  subdivision  {} × {:?}", avatar.level_count, avatar.scheme);
    println!("  f_d          {}", describe(&avatar.deformation));
    println!("  f_l          {}, {:?}", describe(&avatar.laplacian), avatar.form);
    println!("  anchors      {}, weight {}", avatar.anchors.len(), avatar.anchor_weight);
    println!("sizes");
    for (section, size) in section_sizes(&bytes)? {
        println!("  {:10.1} kB  {section}", size as f64 / 1e3);
    }
    println!("provenance");
    for (key, value) in &avatar.provenance {
        println!("  {key}: {value}");
    }
    Ok(())
}

/// One line a motion: the largest ratio over all regions, for f_d and f_l.
fn coefficients(avatar: &Avatar, motions: &[PathBuf]) -> anyhow::Result<()> {
    // The rate tells only when a pose is shown.
    const ANY_RATE: f32 = 60.0;
    println!("largest coefficient over largest in training   f_d    f_l");
    for path in motions {
        let motion = Motion::read(&read(path)?, &path.display().to_string(), Some(ANY_RATE))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let ratios = [&avatar.deformation, &avatar.laplacian].map(|function| match function {
            SurfaceFunction::Compact(function) => {
                format!("{:.2}", largest_ratio(&motion_ranges(function, &motion.poses), &training_ranges(function)))
            }
            SurfaceFunction::Mlp(_) => "none".into(),
        });
        println!("{name:44} {:>6} {:>6}", ratios[0], ratios[1]);
    }
    Ok(())
}

/// One line a motion, as a table in Markdown.
fn measures(avatar: Avatar, motions: &[PathBuf], frames_per_second: Option<f32>) -> anyhow::Result<()> {
    let avatar = Arc::new(avatar);
    println!(
        "| motion | frames | finite | edges over {OVERSTRETCHED}, % | greatest ratio | detail, m/s² | base, m/s² |"
    );
    println!("|---|---|---|---|---|---|---|");
    for path in motions {
        let motion = Motion::read(&read(path)?, &path.display().to_string(), frames_per_second)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let found = measure_motion(Arc::clone(&avatar), &motion)?;
        let finite = if found.is_finite { "yes" } else { "no" };
        println!(
            "| {name} | {} | {finite} | {:.4} | {:.2} | {:.2} | {:.2} |",
            found.frames,
            100.0 * found.overstretched_share,
            found.greatest_ratio,
            found.detail_acceleration,
            found.base_acceleration
        );
    }
    Ok(())
}

fn describe(function: &SurfaceFunction) -> String {
    match function {
        SurfaceFunction::Mlp(mlp) => {
            let widths: Vec<String> = mlp.layers.iter().map(|layer| layer.output_count().to_string()).collect();
            format!("perceptron on level {}, layers of {}", mlp.level, widths.join(", "))
        }
        SurfaceFunction::Compact(compact) => format!(
            "tables on level {}, {} regions, {} training poses",
            compact.level,
            compact.regions.len(),
            compact.centre_count
        ),
    }
}
