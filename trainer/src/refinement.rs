//! Poses and clothes in turn: the base is fitted to all scans, and every pose to its scan with the base of all on.
//!
//! What a frame's own fit says would follow the error of its pose; the mean over all frames, and what of it changes slowly with the pose,
//! does not.

use crate::compact::{CompactDeformation, RegressionOptions};
use crate::context::TrainContext;
use crate::registration::{DressedPerson, Hold};
use crease::animate::PosedSurface;
use crease::body::Pose;
use crease::network::{Scratch, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Whether and how poses are refined before training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefinementOptions {
    /// Rounds of fitting the base and refining the poses; 0 takes the poses as they are.
    pub round_count: usize,
    /// Weight of a radian between a joint's rotation and that of the pose at first, squared, against the scan's mean square in m².
    pub rotation_weight: f64,
    /// Weight of a metre of the translation, squared.
    pub translation_weight: f64,
}

impl Default for RefinementOptions {
    fn default() -> Self {
        Self { round_count: 0, rotation_weight: 1.5e-5, translation_weight: 1e-3 }
    }
}

/// Refines the poses of all frames that have a scan, trained on or not. The base is that of the frames that are trained on.
pub fn refine_poses(context: &mut TrainContext) -> anyhow::Result<()> {
    let options = context.options.refinement;
    let initial: Vec<Vec<Pose>> = context.sequences.iter().map(|sequence| sequence.poses.clone()).collect();
    for _ in 0..options.round_count {
        let refined = refined(context, &initial)?;
        for (sequence, poses) in context.sequences.iter_mut().zip(refined) {
            sequence.poses = poses;
        }
    }
    Ok(())
}

/// One round: poses of all sequences.
fn refined(context: &TrainContext, initial: &[Vec<Pose>]) -> anyhow::Result<Vec<Vec<Pose>>> {
    let options = context.options.refinement;
    let base = slow_base(context)?;
    let hold = Hold { rotation_weight: options.rotation_weight, translation_weight: options.translation_weight };
    let person = DressedPerson::new(&context.body, &context.sequences[0].betas);
    let frame_count = initial.iter().map(Vec::len).sum();
    let bar = context.progress.bar("refining the poses", frame_count);
    let poses = context.sequences.iter().zip(initial).map(|(sequence, initial)| {
        (initial.par_iter().enumerate())
            .map(|(index, initial)| {
                let pose = match sequence.capture.scan(index) {
                    Ok(frame) => {
                        person.refined(&frame, clothes(context, &base, &sequence.poses[index]), initial, hold)?
                    }
                    // Training tells of scans that it needs and cannot read.
                    Err(_) => initial.clone(),
                };
                bar.advance(1);
                Ok(pose)
            })
            .collect()
    });
    poses.collect()
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
