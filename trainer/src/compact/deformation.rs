//! f_d in compact form: fit the base to every scan, take the offsets back to the T-pose, regress them on the pose.

use super::frame_fit::PreparedScan;
use super::regions::weighted_regions;
use super::regression::regress;
use super::surface_fit::{FitOptions, fit_surface};
use crate::context::{DeformationTrainer, Sample, TrainContext};
use crease::animate::PosedSurface;
use crease::body::Pose;
use crease::network::SurfaceFunction;
use glam::Vec3A;
use rayon::prelude::*;

/// Trains f_d by fits and regression.
pub struct CompactDeformation;

impl DeformationTrainer for CompactDeformation {
    fn train(&self, context: &TrainContext) -> anyhow::Result<SurfaceFunction> {
        let options = &context.options.compact;
        let zero = vec![Vec3A::ZERO; context.rig.rest.len()];
        let coarse = fit_all(context, "fitting the base, coarse", &zero, &options.coarse_fit)?;
        let mean = mean_field(&coarse);
        let fine = fit_all(context, "fitting the base", &mean, &options.base_fit)?;
        let poses: Vec<Pose> = context.samples.iter().map(|&sample| context.pose(sample).clone()).collect();
        let regions = weighted_regions(&context.domains[0].masks, &context.adjacency, options.deformation.blend_steps);
        Ok(SurfaceFunction::Compact(regress(0, &regions, &poses, &fine, &options.deformation)))
    }
}

/// Canonical offsets of every training frame; the fit starts from `offsets` and stays smooth relative to them.
fn fit_all(
    context: &TrainContext,
    title: &str,
    offsets: &[Vec3A],
    options: &FitOptions,
) -> anyhow::Result<Vec<Vec<Vec3A>>> {
    let bar = context.progress.bar(title, context.samples.len());
    context
        .samples
        .par_iter()
        .map(|&sample| {
            let fitted = fit_offsets(context, sample, offsets, options);
            bar.advance(1);
            fitted
        })
        .collect()
}

fn fit_offsets(
    context: &TrainContext,
    sample: Sample,
    offsets: &[Vec3A],
    options: &FitOptions,
) -> anyhow::Result<Vec<Vec3A>> {
    let scan = PreparedScan::new(context, sample)?;
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
    let rotations = surface.rotations(&context.subdivision, 0);
    Ok((0..fitted.len()).map(|k| offsets[k] + rotations[k].inverse() * (fitted[k] - posed[k])).collect())
}

fn mean_field(fields: &[Vec<Vec3A>]) -> Vec<Vec3A> {
    let mut mean = vec![Vec3A::ZERO; fields[0].len()];
    for field in fields {
        for (mean, value) in mean.iter_mut().zip(field) {
            *mean += *value / fields.len() as f32;
        }
    }
    mean
}
