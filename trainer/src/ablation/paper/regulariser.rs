//! f_d alone, on a mesh as dense as the final one, at several λ_r: what f_l is there for (paper, Pose-dependent local deformation on a
//! subdivided base mesh).

use super::subdivided_body::subdivided;
use super::{Add, Runs};
use crate::config::read_body_model;
use crate::context::{DeformationTrainer, Sample, TrainContext};
use crate::evaluate::{Measures, evaluate_meshes};
use crate::plain::PlainDeformation;
use crate::progress::Progress;
use crate::refinement::refine_poses;
use crate::targets::base_surface;

/// λ_r is of the mean of the squared umbrella, which is a sixteenth as long on the fine mesh as on the body's own.
const WEIGHTS: [f32; 5] = [0.1, 1.0, 10.0, 100.0, 1000.0];

/// f_d on the body's own mesh, as the paper has it under f_l, and then on the subdivided one at each of the weights.
pub fn regularisers(runs: &Runs, add: &mut Add) -> anyhow::Result<()> {
    let mut context = runs.paper.prepare(Progress::Bars)?;
    refine_poses(&mut context)?;
    let frames = runs.test.indices(context.sequences[0].capture.frame_count)?;
    let own = format!("{}, on the body's mesh", context.options.deformation.regulariser_weight);
    add(&own, Some(alone(&context, &frames)?), None, None);
    let body = subdivided(&read_body_model(runs.paper.body.as_deref())?, context.level_count());
    for weight in WEIGHTS {
        let mut options = context.options.clone();
        options.level_count = 0;
        options.deformation.regulariser_weight = weight;
        let TrainContext { sequences, samples, .. } = &context;
        let fine = TrainContext::new(body.clone(), sequences.clone(), samples.clone(), options, Progress::Bars)?;
        add(&format!("{weight}, on the final mesh"), Some(alone(&fine, &frames)?), None, None);
    }
    Ok(())
}

/// How close f_d comes on the finest level of its body.
fn alone(context: &TrainContext, frames: &[usize]) -> anyhow::Result<Measures> {
    let deformation = PlainDeformation.train(context)?.function;
    let triangles = context.subdivision.triangles(context.level_count());
    evaluate_meshes(&context.sequences[0], frames, triangles, |frame| {
        Ok(base_surface(context, &deformation, Sample { sequence: 0, frame }).finest().to_vec())
    })
}
