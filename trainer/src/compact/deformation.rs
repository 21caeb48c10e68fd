//! f_d in compact form: fit the base to every scan, take the offsets back to the T-pose, regress them on the pose.

use super::frame_fit::PreparedScan;
use super::surface_fit::{FitOptions, coverage, fit_surface};
use super::two_scales::{BranchOptions, regress_surface};
use super::views::{View, fuse, resolvable, seen};
use crate::context::{DeformationTrainer, Sample, TrainContext, TrainedDeformation};
use anyhow::ensure;
use crease::animate::PosedSurface;
use crease::network::{Compact, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;

/// Regression holds the fits to all frames in memory, several MB each, and the file keeps what it needs of every one.
pub const GREATEST_FRAME_COUNT: usize = 2000;

/// Trains f_d by fits and regression.
pub struct CompactDeformation;

impl DeformationTrainer for CompactDeformation {
    fn train(&self, context: &TrainContext) -> anyhow::Result<TrainedDeformation> {
        Ok(SurfaceFunction::Compact(self.regress(context, &self.fit(context)?)?).into())
    }
}

impl CompactDeformation {
    /// Canonical offsets of every training frame on level 0, metres.
    ///
    /// Fails where there are more than [`GREATEST_FRAME_COUNT`].
    pub fn fit(&self, context: &TrainContext) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        let count = context.samples.len();
        ensure!(
            count <= GREATEST_FRAME_COUNT,
            "frames: expected at most {GREATEST_FRAME_COUNT} where fits to all of them are compared, found {count}: \
             take every {}th with --frames ::{}, or train with --preset paper, which reads frames as they come",
            count.div_ceil(GREATEST_FRAME_COUNT),
            count.div_ceil(GREATEST_FRAME_COUNT)
        );
        let options = &context.options.compact;
        let zero = vec![Vec3A::ZERO; context.rig.rest.len()];
        let coarse = fit_all(context, "fitting the base, coarse", "coarse", |_| &zero, &options.coarse_fit)?;
        // Folds that stay for a whole sequence are in its mean, and smoothing spares them.
        let means: Vec<Vec<Vec3A>> = (0..context.sequences.len())
            .map(|sequence| {
                let own = coarse.iter().zip(&context.samples).filter(|(_, sample)| sample.sequence == sequence);
                mean_field(own.map(|(field, _)| field))
            })
            .collect();
        fit_all(context, "fitting the base", "base", |sample| &means[sample.sequence], &options.base_fit)
    }

    /// f_d from the offsets that [`Self::fit`] gives.
    pub fn regress(&self, context: &TrainContext, offsets: &[Vec<Vec3A>]) -> anyhow::Result<Compact> {
        self.regress_with(context, offsets, &context.options.compact.deformation)
    }

    /// [`Self::regress`] by a branch of one's own.
    pub fn regress_with(
        &self,
        context: &TrainContext,
        offsets: &[Vec<Vec3A>],
        options: &BranchOptions,
    ) -> anyhow::Result<Compact> {
        let TrainContext { subdivision, domains, rig, .. } = context;
        regress_surface(0, subdivision, domains, rig, &context.poses(), offsets, options)
    }
}

/// Canonical offsets of every training frame, views fused; the fit starts from a sample's `start` and stays smooth relative to it.
fn fit_all<'a>(
    context: &TrainContext,
    title: &str,
    name: &str,
    start: impl Fn(Sample) -> &'a Vec<Vec3A> + Sync,
    options: &FitOptions,
) -> anyhow::Result<Vec<Vec<Vec3A>>> {
    let bar = context.progress.bar(title, context.samples.len());
    let views = context
        .samples
        .par_iter()
        .map(|&sample| {
            let start = start(sample);
            let inputs = context.frame_ingredients(name, sample)?.points(start).finish();
            let fit = || fit_offsets(context, sample, start, options);
            let fitted = context.checkpoint.remember(&sample.name(name), inputs, fit);
            bar.advance(1);
            fitted
        })
        .collect::<anyhow::Result<Vec<View>>>()?;
    Ok(fuse(views, &context.adjacency))
}

fn fit_offsets(
    context: &TrainContext,
    sample: Sample,
    offsets: &[Vec3A],
    options: &FitOptions,
) -> anyhow::Result<View> {
    let scan = PreparedScan::new(context, sample)?;
    let options = &scan.fit_options(context, options);
    let mut surface = PosedSurface::new(&context.subdivision);
    surface.pose(
        &context.rig,
        offsets,
        context.pose(sample),
        &context.subdivision,
        context.options.scheme,
        context.subdivision.level_count(),
    );
    let posed = surface.positions(0).to_vec();
    let fitted = fit_surface(
        &context.subdivision,
        &context.adjacency,
        context.options.scheme,
        0,
        &posed,
        &posed,
        &scan.oriented(),
        options,
    )?;
    let seen = match scan.is_view {
        false => None,
        true => {
            let (subdivision, scheme) = (&context.subdivision, context.options.scheme);
            let coverage = coverage(subdivision, scheme, 0, &fitted, &scan.oriented(), options)?;
            Some(seen(&coverage, &resolvable(context, 0)))
        }
    };
    let rotations = surface.rotations(&context.subdivision, 0);
    let values = (0..fitted.len()).map(|k| offsets[k] + rotations[k].inverse() * (fitted[k] - posed[k])).collect();
    Ok(View { values, seen })
}

/// The mean over all fields; empty without any.
fn mean_field<'a>(fields: impl Iterator<Item = &'a Vec<Vec3A>> + Clone) -> Vec<Vec3A> {
    let count = fields.clone().count();
    let mut mean = vec![Vec3A::ZERO; fields.clone().next().map_or(0, Vec::len)];
    for field in fields {
        for (mean, value) in mean.iter_mut().zip(field) {
            *mean += *value / count as f32;
        }
    }
    mean
}
