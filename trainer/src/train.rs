//! The pipeline: context in, avatar out. Presets differ in their options alone.

use crate::appearance::bake;
use crate::compact::{CompactDeformation, CompactLaplacian};
use crate::context::{DeformationTrainer, LaplacianTrainer, TrainContext};
use crate::options::{FunctionForm, LaplacianTarget};
use crate::plain::{FittedDeformation, FittedLaplacian, PlainDeformation, PlainLaplacian};
use anyhow::bail;
use crease::avatar::{Appearance, Avatar};
use crease::network::SurfaceFunction;
use crease::solver::CoarseFactor;
use serde_json::{Map, Value, json};

/// What goes into an avatar beside what is trained.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Name for people.
    pub name: String,
    /// The command that trains it again.
    pub command: String,
    /// Name of the preset that the options started from.
    pub preset: String,
    /// Notices of the data used, such as the body's.
    pub notices: Vec<String>,
}

/// Trains an avatar. Where the options ask for poses to be refined with f_d, the context's are the refined ones afterwards.
pub fn train(context: &mut TrainContext, facts: &Facts) -> anyhow::Result<Avatar> {
    let (deformation_trainer, laplacian_trainer) = strategies(context)?;
    let trained = context.log.timed("f_d", || deformation_trainer.train(context))?;
    let deformation = trained.adopt(context);
    let (context, log) = (&*context, &context.log);
    let laplacian = log.timed("f_l", || laplacian_trainer.train(context, &deformation))?;
    let appearance = log.timed("texture", || bake(context, &deformation))?;
    assemble(context, facts, deformation, laplacian, appearance)
}

/// The avatar of what was trained.
pub fn assemble(
    context: &TrainContext,
    facts: &Facts,
    deformation: SurfaceFunction,
    laplacian: SurfaceFunction,
    appearance: Appearance,
) -> anyhow::Result<Avatar> {
    let options = &context.options;
    let avatar = Avatar {
        name: facts.name.clone(),
        rig: context.rig.clone(),
        canonical: context.body.template.clone(),
        triangles: context.body.triangles.clone(),
        appearance,
        scheme: options.scheme,
        level_count: options.level_count,
        deformation,
        laplacian,
        form: options.form,
        anchors: context.anchors.clone(),
        anchor_weight: options.anchor_weight,
        factor: CoarseFactor::new(&context.subdivision, &context.anchors, options.anchor_weight),
        provenance: provenance(context, facts),
    };
    avatar.validate(&facts.name)?;
    Ok(avatar)
}

/// The trainers that the options name.
fn strategies(context: &TrainContext) -> anyhow::Result<(Box<dyn DeformationTrainer>, Box<dyn LaplacianTrainer>)> {
    Ok(match (context.options.function, context.options.target) {
        (FunctionForm::Plain, LaplacianTarget::Quadratic) => (Box::new(PlainDeformation), Box::new(PlainLaplacian)),
        (FunctionForm::Plain, LaplacianTarget::Operator) => (Box::new(FittedDeformation), Box::new(FittedLaplacian)),
        (FunctionForm::Compact, LaplacianTarget::Operator) => {
            (Box::new(CompactDeformation), Box::new(CompactLaplacian))
        }
        (FunctionForm::Compact, LaplacianTarget::Quadratic) => {
            bail!("options: target: expected operator where function is compact, found quadratic")
        }
    })
}

fn provenance(context: &TrainContext, facts: &Facts) -> Map<String, Value> {
    let sequences: Vec<Value> = context
        .sequences
        .iter()
        .enumerate()
        .map(|(index, sequence)| {
            let frames: Vec<usize> =
                context.samples.iter().filter(|sample| sample.sequence == index).map(|sample| sample.frame).collect();
            json!({ "name": sequence.capture.name, "licence": sequence.capture.licence, "frames": frames })
        })
        .collect();
    let facts = json!({
        "command": facts.command,
        "preset": facts.preset,
        "seed": context.options.seed,
        "options": context.options,
        "sequences": sequences,
        "notices": facts.notices,
        "trainer": format!("crease-trainer {}", env!("CARGO_PKG_VERSION")),
    });
    match facts {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}
