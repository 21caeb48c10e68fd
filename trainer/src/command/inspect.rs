//! `crease inspect`.

use clap::Args;
use crease::avatar::Avatar;
use crease::network::SurfaceFunction;
use crease_trainer::sequence::read;
use crease_trainer::sizes::section_sizes;
use std::path::PathBuf;

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb)
    pub avatar: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let bytes = read(&arguments.avatar)?;
    let avatar = Avatar::read(&bytes, &arguments.avatar.display().to_string())?;
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
