//! f_l in compact form: fit the finest mesh to every scan, take its operator Laplacian, regress it on the pose.
//!
//! δ must be what the reconstruction's own operator measures: then solving gives the fitted mesh back. Tables stand on a coarser level;
//! δ there is the least-squares choice whose Loop refinement is closest to the finest level's.

use super::frame_fit::PreparedScan;
use super::least_squares::conjugate_gradients;
use super::regions::weighted_regions;
use super::surface_fit::{fit_surface, refine_to_finest, restrict_from_finest};
use super::two_scales::regress_on_two_scales;
use crate::context::{LaplacianTrainer, Sample, TrainContext};
use crate::targets::{base_surface, offsets, operator_laplacian};
use crease::avatar::Form;
use crease::body::Pose;
use crease::mesh::{Adjacency, Scheme, Subdivision};
use crease::network::{Compact, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;

/// Trains f_l by fits and regression.
pub struct CompactLaplacian;

impl LaplacianTrainer for CompactLaplacian {
    fn train(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<SurfaceFunction> {
        Ok(SurfaceFunction::Compact(self.regress(context, &self.fit(context, deformation)?)))
    }
}

impl CompactLaplacian {
    /// Canonical δ of every training frame on the level of f_l's tables, 1/m.
    pub fn fit(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        let level = context.options.compact.laplacian_level as usize;
        let bar = context.progress.bar("fitting the detail", context.samples.len());
        context
            .samples
            .par_iter()
            .map(|&sample| {
                let base = offsets(context, deformation, sample);
                let inputs = context.frame_ingredients("detail", sample)?.points(&base).finish();
                let fit = || fitted_laplacian(context, deformation, sample, level);
                let target = context.checkpoint.remember(&sample.name("detail"), inputs, fit);
                bar.advance(1);
                target
            })
            .collect()
    }

    /// f_l from the δ that [`Self::fit`] gives.
    pub fn regress(&self, context: &TrainContext, targets: &[Vec<Vec3A>]) -> Compact {
        let options = &context.options.compact;
        let level = options.laplacian_level as usize;
        let poses: Vec<Pose> = context.samples.iter().map(|&sample| context.pose(sample).clone()).collect();
        let adjacency = Adjacency::new(context.subdivision.vertex_count(level), context.subdivision.triangles(level));
        // A region's border is as wide in metres on any level.
        let blend_steps = options.laplacian.blend_steps << (2 * level);
        let regions = weighted_regions(&context.domains[level].masks, &adjacency, blend_steps);
        regress_on_two_scales(level, &regions, &adjacency, &poses, targets, &options.laplacian)
    }
}

/// Canonical δ on the vertices of `level` for one training frame.
fn fitted_laplacian(
    context: &TrainContext,
    deformation: &SurfaceFunction,
    sample: Sample,
    level: usize,
) -> anyhow::Result<Vec<Vec3A>> {
    let options = &context.options;
    let subdivision = &context.subdivision;
    let finest = subdivision.level_count();
    let scan = PreparedScan::new(context, sample)?;
    let mut surface = base_surface(context, deformation, sample);
    let base = surface.finest().to_vec();
    let fitted = fit_surface(
        subdivision,
        &context.finest_adjacency,
        options.scheme,
        finest,
        &base,
        &base,
        &scan.oriented(),
        &options.compact.detail_fit,
    )?;

    let wanted = match options.form {
        Form::Absolute => fitted,
        Form::Relative => fitted.iter().zip(&base).map(|(&fitted, &base)| fitted - base).collect(),
    };
    let mut delta = operator_laplacian(context, &base, &wanted);
    for delta in &mut delta {
        *delta = delta.clamp_length_max(options.compact.clamp);
    }
    let mut coarse = coarsen(&context.subdivision, level, &delta);
    for (delta, rotation) in coarse.iter_mut().zip(surface.rotations(subdivision, level)) {
        *delta = rotation.inverse() * *delta;
    }
    Ok(coarse)
}

/// The field on `level` whose Loop refinement is closest to `field` on the finest level.
pub(super) fn coarsen(subdivision: &Subdivision, level: usize, field: &[Vec3A]) -> Vec<Vec3A> {
    let b = restrict_from_finest(subdivision, Scheme::Loop, level, field.to_vec());
    let ones = restrict_from_finest(subdivision, Scheme::Loop, level, vec![Vec3A::ONE; field.len()]);
    let inverse_diagonal: Vec<f32> = ones.iter().map(|one| 1.0 / one.x).collect();
    let mut coarse: Vec<Vec3A> = b.iter().zip(&inverse_diagonal).map(|(&b, &m)| b * m).collect();
    let mut apply = |x: &[Vec3A], out: &mut [Vec3A]| {
        let refined = refine_to_finest(subdivision, Scheme::Loop, level, x);
        out.copy_from_slice(&restrict_from_finest(subdivision, Scheme::Loop, level, refined));
    };
    conjugate_gradients(&mut apply, &inverse_diagonal, &b, &mut coarse, 30, 1e-4);
    coarse
}
