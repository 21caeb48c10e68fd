//! What of the reconstruction can be varied without fitting anew: anchors and operator.

use super::super::Fits;
use super::{Add, Runs};
use crate::compact::{CompactCotangent, CompactLaplacian};
use crate::context::{Sample, TrainContext, spread_anchors};
use crate::evaluate::{Measures, evaluate_meshes};
use crate::progress::Progress;
use crate::refinement::refine_poses;
use crate::targets::base_surface;
use crate::train::{Facts, assemble};
use crease::animate::{Animator, Options};
use crease::avatar::{Avatar, Form};
use crease::network::SurfaceFunction;
use glam::Vec3A;
use std::sync::Arc;
use std::time::Instant;

/// Five hundred and fewer distort the paper's reconstructions.
const ANCHOR_COUNTS: [usize; 6] = [100, 200, 500, 800, 1200, 2000];

/// Anchors in number, spread alike, for f_l relative to the base and as it is in the paper.
pub fn anchors(runs: &Runs, add: &mut Add) -> anyhow::Result<()> {
    let (mut context, fits) = fitted(runs)?;
    let frames = runs.test.indices(context.sequences[0].capture.frame_count)?;
    let level = context.level_count();
    for form in [Form::Relative, Form::Absolute] {
        context.options.form = form;
        let laplacian = uniform_angle(&context, &fits)?;
        for count in ANCHOR_COUNTS {
            let triangles = context.subdivision.triangles(level);
            context.anchors = spread_anchors(&context.domains[level].canonical, triangles, count);
            let avatar = avatar(&context, &fits, laplacian.clone())?;
            let (detailed, _) = uniform_angle_avatar(&context, avatar, &frames)?;
            let name = match form {
                Form::Relative => "relative",
                Form::Absolute => "absolute",
            };
            add(&format!("{count}, {name} form"), None, Some(detailed), None);
        }
    }
    Ok(())
}

/// The uniform-angle operator, and the cotangents of each frame's base in its place from the fits to the solve.
pub fn operators(runs: &Runs, add: &mut Add) -> anyhow::Result<()> {
    let (context, fits) = fitted(runs)?;
    let frames = runs.test.indices(context.sequences[0].capture.frame_count)?;
    let base = |frame| Ok(base_surface(&context, &fits.deformation, Sample { sequence: 0, frame }).finest().to_vec());
    let (base, _) = timed(&context, &frames, base)?;
    let avatar = avatar(&context, &fits, uniform_angle(&context, &fits)?)?;
    let (measures, milliseconds) = uniform_angle_avatar(&context, avatar, &frames)?;
    add("uniform angle", Some(base), Some(measures), Some(milliseconds));
    let (measures, milliseconds) = cotangent(&context, &fits, &frames)?;
    add("cotangent", None, Some(measures), Some(milliseconds));
    Ok(())
}

/// How close the cotangent operator comes, and the milliseconds of a frame.
fn cotangent(context: &TrainContext, fits: &Fits, frames: &[usize]) -> anyhow::Result<(Measures, f64)> {
    let own = CompactCotangent;
    let deltas = own.measure(context, &fits.deformation, &fits.surfaces)?;
    let laplacian = SurfaceFunction::Compact(own.regress(context, &deltas)?);
    let reconstruction = own.reconstruction(context)?;
    timed(context, frames, |frame| {
        let sample = Sample { sequence: 0, frame };
        own.surface(context, &fits.deformation, &laplacian, &reconstruction, sample)
    })
}

/// The same of the uniform-angle operator, as `animate` has it.
fn uniform_angle_avatar(context: &TrainContext, avatar: Avatar, frames: &[usize]) -> anyhow::Result<(Measures, f64)> {
    let mut animator = Animator::new(Arc::new(avatar))?;
    let options = Options { liveliness: 0.0, ..Options::default() };
    let poses = &context.sequences[0].poses;
    timed(context, frames, |frame| Ok(animator.animate(&poses[frame], &options).to_vec()))
}

/// How close the meshes of `surface` come, and how many milliseconds one takes on the mean.
fn timed(
    context: &TrainContext,
    frames: &[usize],
    mut surface: impl FnMut(usize) -> anyhow::Result<Vec<Vec3A>>,
) -> anyhow::Result<(Measures, f64)> {
    let mut seconds = 0.0;
    let triangles = context.subdivision.triangles(context.level_count());
    let measures = evaluate_meshes(&context.sequences[0], frames, triangles, |frame| {
        let begin = Instant::now();
        let surface = surface(frame);
        seconds += begin.elapsed().as_secs_f64();
        surface
    })?;
    Ok((measures, 1e3 * seconds / frames.len().max(1) as f64))
}

fn fitted(runs: &Runs) -> anyhow::Result<(TrainContext, Fits)> {
    let mut context = runs.compact.prepare(Progress::Bars)?;
    refine_poses(&mut context)?;
    let fits = Fits::new(&context)?;
    Ok((context, fits))
}

fn uniform_angle(context: &TrainContext, fits: &Fits) -> anyhow::Result<SurfaceFunction> {
    let deltas = CompactLaplacian.measure(context, &fits.deformation, &fits.surfaces)?;
    Ok(SurfaceFunction::Compact(CompactLaplacian.regress(context, &deltas)?))
}

fn avatar(context: &TrainContext, fits: &Fits, laplacian: SurfaceFunction) -> anyhow::Result<Avatar> {
    let facts = Facts { name: context.sequences[0].capture.name.clone(), ..Facts::default() };
    assemble(context, &facts, fits.deformation.clone(), laplacian, fits.appearance.clone())
}
