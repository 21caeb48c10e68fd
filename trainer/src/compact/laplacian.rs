//! f_l in compact form: fit the finest mesh to every scan, take its operator Laplacian, regress it on the pose.
//!
//! δ must be what the reconstruction's own operator measures: then solving gives the fitted mesh back. Tables stand on a coarser level;
//! δ there is the least-squares choice whose Loop refinement is closest to the finest level's.

use super::frame_fit::PreparedScan;
use super::least_squares::conjugate_gradients;
use super::surface_fit::{FitOptions, coverage, fit_surface, refine_to_finest, restrict_from_finest};
use super::two_scales::{BranchOptions, regress_surface};
use super::views::{View, fuse, resolvable, seen};
use crate::context::{LaplacianTrainer, Sample, TrainContext};
use crate::options::TrainOptions;
use crate::targets::{base_surface, offsets, operator_laplacian};
use crease::animate::PosedSurface;
use crease::avatar::Form;
use crease::mesh::{Adjacency, Scheme, Subdivision};
use crease::network::{Compact, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;

/// Trains f_l by fits and regression.
pub struct CompactLaplacian;

impl LaplacianTrainer for CompactLaplacian {
    fn train(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<SurfaceFunction> {
        Ok(SurfaceFunction::Compact(self.regress(context, &self.fit(context, deformation)?)?))
    }
}

impl CompactLaplacian {
    /// Canonical δ of every training frame on the level of f_l's tables, 1/m.
    pub fn fit(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        let views = each_sample(context, "fitting the detail", |index| {
            let sample = context.samples[index];
            let base = offsets(context, deformation, sample);
            let inputs = context.frame_ingredients("detail", sample)?.points(&base).finish();
            context.checkpoint.remember(&sample.name("detail"), inputs, || {
                let surface = fitted_surface(context, deformation, sample)?;
                Ok(laplacian(context, deformation, sample, &surface))
            })
        })?;
        Ok(fused(context, views))
    }

    /// The finest mesh fitted to the scan of every training frame, metres, from the base that `deformation` gives; what a camera saw of
    /// it is on the level of f_l's tables.
    pub fn fit_surfaces(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<Vec<View>> {
        each_sample(context, "fitting the detail", |index| fitted_surface(context, deformation, context.samples[index]))
    }

    /// What [`Self::fit`] gives where `surfaces` have been fitted already, maybe from another base.
    pub fn measure(
        &self,
        context: &TrainContext,
        deformation: &SurfaceFunction,
        surfaces: &[View],
    ) -> anyhow::Result<Vec<Vec<Vec3A>>> {
        measure_each(context, "measuring the detail", surfaces, |sample, fitted| {
            laplacian(context, deformation, sample, fitted)
        })
    }

    /// f_l from the δ that [`Self::fit`] gives.
    pub fn regress(&self, context: &TrainContext, targets: &[Vec<Vec3A>]) -> anyhow::Result<Compact> {
        regress_on_tables(context, targets, &branch(&context.options))
    }
}

/// The branch of f_l. In the absolute form what all poses share is nowhere but in f_l, so it keeps the mean whole.
pub(super) fn branch(options: &TrainOptions) -> BranchOptions {
    match options.form {
        Form::Relative => options.compact.laplacian,
        Form::Absolute => BranchOptions { shrinkage: 1.0, keeps_rough_mean: true, ..options.compact.laplacian },
    }
}

/// A function on the level of f_l's tables from its values in every training frame.
pub(super) fn regress_on_tables(
    context: &TrainContext,
    targets: &[Vec<Vec3A>],
    options: &BranchOptions,
) -> anyhow::Result<Compact> {
    let level = context.laplacian_level();
    let TrainContext { subdivision, domains, rig, .. } = context;
    regress_surface(level, subdivision, domains, rig, &context.poses(), targets, options)
}

/// What `measure` finds between the base and the fitted surface of every training frame, on the level of f_l's tables; what one did not see
/// is taken from those that did.
pub(super) fn measure_each(
    context: &TrainContext,
    title: &str,
    surfaces: &[View],
    measure: impl Fn(Sample, &View) -> View + Sync,
) -> anyhow::Result<Vec<Vec<Vec3A>>> {
    let views = each_sample(context, title, |index| Ok(measure(context.samples[index], &surfaces[index])))?;
    Ok(fused(context, views))
}

/// A field for every training frame, in parallel.
fn each_sample(
    context: &TrainContext,
    title: &str,
    field: impl Fn(usize) -> anyhow::Result<View> + Sync,
) -> anyhow::Result<Vec<View>> {
    let bar = context.progress.bar(title, context.samples.len());
    let done = |index| {
        let field = field(index);
        bar.advance(1);
        field
    };
    (0..context.samples.len()).into_par_iter().map(done).collect()
}

/// δ of all frames, what one did not see taken from those that did.
fn fused(context: &TrainContext, views: Vec<View>) -> Vec<Vec<Vec3A>> {
    let level = context.laplacian_level();
    let adjacency = Adjacency::new(context.subdivision.vertex_count(level), context.subdivision.triangles(level));
    fuse(views, &adjacency)
}

/// The finest mesh fitted to the scan of one training frame.
fn fitted_surface(context: &TrainContext, deformation: &SurfaceFunction, sample: Sample) -> anyhow::Result<View> {
    let scan = PreparedScan::new(context, sample)?;
    let options = scan.fit_options(context, &context.options.compact.detail_fit);
    let surface = base_surface(context, deformation, sample);
    let values = fit_surface(
        &context.subdivision,
        &context.finest_adjacency,
        context.options.scheme,
        context.level_count(),
        surface.finest(),
        surface.finest(),
        &scan.oriented(),
        &options,
    )?;
    let seen = match scan.is_view {
        false => None,
        true => {
            let coverage = coverage_on_tables(context, &values, &scan, &options)?;
            Some(seen(&coverage, &resolvable(context, context.laplacian_level())))
        }
    };
    Ok(View { values, seen })
}

/// Weight of the scan points on each vertex of the level of f_l's tables, for a surface of the finest level.
fn coverage_on_tables(
    context: &TrainContext,
    surface: &[Vec3A],
    scan: &PreparedScan,
    options: &FitOptions,
) -> anyhow::Result<Vec<f32>> {
    let (subdivision, scheme) = (&context.subdivision, context.options.scheme);
    let level = context.laplacian_level();
    let finest = coverage(subdivision, scheme, subdivision.level_count(), surface, &scan.oriented(), options)?;
    let finest = finest.into_iter().map(Vec3A::splat).collect();
    Ok(restrict_from_finest(subdivision, scheme, level, finest).iter().map(|weight| weight.x).collect())
}

/// Canonical δ on the level of f_l's tables: what takes the base of one training frame to the `fitted` mesh.
fn laplacian(context: &TrainContext, deformation: &SurfaceFunction, sample: Sample, fitted: &View) -> View {
    let triangles = context.subdivision.triangles(context.level_count());
    canonical_delta(context, deformation, sample, fitted, |base, wanted| {
        operator_laplacian(&context.finest_adjacency, triangles, base, wanted)
    })
}

/// What `operator` measures on the base of one training frame, its first argument, of the field that f_l stands for, its second.
pub(super) fn canonical_delta(
    context: &TrainContext,
    deformation: &SurfaceFunction,
    sample: Sample,
    fitted: &View,
    operator: impl Fn(&[Vec3A], &[Vec3A]) -> Vec<Vec3A>,
) -> View {
    let options = &context.options;
    let mut surface = base_surface(context, deformation, sample);
    let base = surface.finest();
    let wanted = match options.form {
        Form::Absolute => fitted.values.clone(),
        Form::Relative => fitted.values.iter().zip(base).map(|(&fitted, &base)| fitted - base).collect(),
    };
    let mut delta = operator(base, &wanted);
    for delta in &mut delta {
        *delta = delta.clamp_length_max(options.compact.clamp);
    }
    View { values: on_tables(context, &mut surface, &delta), seen: fitted.seen.clone() }
}

/// A field of posed vectors on the finest level of `surface`, in the canonical frame and on the level of f_l's tables.
pub(super) fn on_tables(context: &TrainContext, surface: &mut PosedSurface, field: &[Vec3A]) -> Vec<Vec3A> {
    let level = context.laplacian_level();
    let mut coarse = coarsen(&context.subdivision, level, field);
    for (value, rotation) in coarse.iter_mut().zip(surface.rotations(&context.subdivision, level)) {
        *value = rotation.inverse() * *value;
    }
    coarse
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
