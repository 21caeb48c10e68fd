//! Poses and clothes in turn: the base is fitted to all scans, and every pose to its scan with the base of all on.
//!
//! What a frame's own fit says would follow the error of its pose; the mean over all frames, and what of it changes slowly with the pose,
//! does not.

use crate::checkpoint::{Ingredients, Keep};
use crate::compact::{CompactDeformation, RegressionOptions};
use crate::context::{Sample, TrainContext};
use crate::registration::{DressedPerson, Hold};
use crease::animate::PosedSurface;
use crease::body::Pose;
use crease::network::{Scratch, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Whether and how poses are refined, before training and in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefinementOptions {
    /// Rounds of fitting the base and refining the poses; 0 takes the poses as they are.
    pub round_count: usize,
    /// Weight of a radian between a joint's rotation and that of the pose at first, squared, against the scan's mean square in m².
    pub rotation_weight: f64,
    /// Weight of a metre of the translation, squared.
    pub translation_weight: f64,
    /// Adam's learning rate of the poses, radians and metres a step, where f_d descends on E_d (plain functions, quadratic targets): θ_t and t_t
    /// of the training frames are learnt with it, in the second half of its steps. 0 leaves them.
    #[serde(default)]
    pub learning_rate: f64,
}

impl RefinementOptions {
    /// Whether poses are others after training.
    pub fn is_on(&self) -> bool {
        self.round_count > 0 || self.learning_rate > 0.0
    }
}

impl Default for RefinementOptions {
    fn default() -> Self {
        Self { round_count: 0, rotation_weight: 1.5e-5, translation_weight: 1e-3, learning_rate: 0.0 }
    }
}

/// Refines the poses of all frames that have a scan, trained on or not. The base is that of the frames that are trained on. Rounds that the
/// checkpoint has are taken from there.
pub fn refine_poses(context: &mut TrainContext) -> anyhow::Result<()> {
    let round_count = context.options.refinement.round_count;
    if round_count == 0 {
        return Ok(());
    }
    let initial: Vec<Pose> = frames(context).map(|sample| context.pose(sample).clone()).collect();
    let inputs = inputs(context);
    for round in 0..round_count {
        let inputs = inputs.clone().value(&round).finish();
        let refine = || refined(context, &initial);
        let mut poses = context.checkpoint.remember(&format!("refined-{round}"), inputs, refine)?.into_iter();
        for sequence in &mut context.sequences {
            sequence.poses = poses.by_ref().take(sequence.poses.len()).collect();
        }
    }
    Ok(())
}

/// All frames of all sequences.
fn frames(context: &TrainContext) -> impl Iterator<Item = Sample> + '_ {
    let of_sequence = |(sequence, poses): (usize, usize)| (0..poses).map(move |frame| Sample { sequence, frame });
    context.sequences.iter().map(|sequence| sequence.poses.len()).enumerate().flat_map(of_sequence)
}

/// Everything that the rounds depend on: what is trained on, and all poses and scans.
fn inputs(context: &TrainContext) -> Ingredients {
    let trained: Vec<[usize; 2]> = context.samples.iter().map(|sample| [sample.sequence, sample.frame]).collect();
    let start = context.ingredients("refined").value(&context.sequences[0].betas).value(&trained);
    frames(context).fold(start, |all, sample| match context.frame_ingredients("refined", sample) {
        Ok(frame) => all.bytes(&frame.finish().0),
        // Without a scan a frame keeps its pose.
        Err(_) => all.bytes(&context.pose(sample).to_bytes()),
    })
}

/// One round: poses of all frames.
fn refined(context: &TrainContext, initial: &[Pose]) -> anyhow::Result<Vec<Pose>> {
    let options = context.options.refinement;
    let base = slow_base(context)?;
    let hold = Hold { rotation_weight: options.rotation_weight, translation_weight: options.translation_weight };
    let person = DressedPerson::new(&context.body, &context.sequences[0].betas);
    let bar = context.progress.bar("refining the poses", initial.len());
    let samples: Vec<Sample> = frames(context).collect();
    let pose = |(&sample, initial): (&Sample, &Pose)| {
        // Training tells of scans that it needs and cannot read.
        let Ok(ingredients) = context.frame_ingredients("refining", sample) else { return Ok(initial.clone()) };
        let clothes = clothes(context, &base, context.pose(sample));
        let inputs = ingredients.bytes(&initial.to_bytes()).points(&clothes).finish();
        let refine = || person.refined(&context.scan(sample)?, clothes, initial, hold);
        let pose = context.checkpoint.remember(&sample.name("refining"), inputs, refine);
        bar.advance(1);
        pose
    };
    samples.par_iter().zip(initial).map(pose).collect()
}

/// f_d of all frames without what changes fast with the pose.
fn slow_base(context: &TrainContext) -> anyhow::Result<SurfaceFunction> {
    let mut slow = context.options.compact.deformation;
    slow.narrow = RegressionOptions { basis_count: 0, ..slow.narrow };
    // Poses follow what the scans say, not what is likeliest elsewhere.
    (slow.shrinkage, slow.mirrored) = (1.0, false);
    let offsets = CompactDeformation.fit(context)?;
    Ok(SurfaceFunction::Compact(CompactDeformation.regress_with(context, &offsets, &slow)?))
}

/// What stands off the rest vertices at `pose`, metres. Subdivision draws vertices inwards, and the scans were on the subdivided surface.
fn clothes(context: &TrainContext, base: &SurfaceFunction, pose: &Pose) -> Vec<Vec3A> {
    let rest = &context.rig.rest;
    let mut offsets = vec![Vec3A::ZERO; rest.len()];
    base.evaluate(&context.domains[0], pose, &mut Scratch::default(), &mut offsets);
    let mut surface = PosedSurface::new(&context.subdivision);
    let still = Pose::rest(pose.rotations.len());
    let level = context.level_count();
    surface.pose(&context.rig, &offsets, &still, &context.subdivision, context.options.scheme, level);
    surface.finest().iter().zip(rest).map(|(&drawn, &rest)| drawn - rest).collect()
}
