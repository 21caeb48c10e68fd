//! One shape for several frames: the poses are eliminated from the joint normal equations.

use super::articulated::State;
use super::frame_fit::{Evidence, Model, frame_system};
use super::priors::add_shape_prior;
use super::scan_term::Search;
use super::system::System;
use anyhow::Context;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;

/// Relative to the diagonal.
const DAMPING: f64 = 1e-3;

/// Moves the poses of all frames and their common β by `step_count` Gauss–Newton steps. All states must have the same β.
pub fn fit_shape(
    model: &Model,
    evidence: &[Evidence],
    states: &mut [State],
    search: &Search,
    step_count: usize,
) -> anyhow::Result<()> {
    for _ in 0..step_count {
        let systems = evidence
            .par_iter()
            .zip(&*states)
            .map(|(&evidence, state)| Ok(frame_system(model, evidence, state, search, true)?.0))
            .collect::<anyhow::Result<Vec<System>>>()?;
        let steps = joint_steps(model, &systems, &states[0].betas).context("the shape of the body")?;
        for (state, step) in states.iter_mut().zip(steps) {
            *state = model.body.moved(state, &step);
        }
    }
    Ok(())
}

/// The step of every frame, β's part common to all.
fn joint_steps(model: &Model, systems: &[System], betas: &[f32]) -> anyhow::Result<Vec<Vec<f64>>> {
    let (poses, shapes) = (model.body.pose_unknowns(), model.body.shape_count());
    let mut prior = System::new(shapes);
    // Each frame's terms are means over its points; the prior is for one frame.
    add_shape_prior(betas, 0, model.priors.shape, &mut prior);
    let mut reduced = Mat::<f64>::from_fn(shapes, shapes, |i, j| prior.hessian(i, j));
    let mut right = Mat::<f64>::from_fn(shapes, 1, |i, _| -prior.gradient(i));
    let eliminated = systems
        .par_iter()
        .map(|system| {
            let damped = |i: usize, j: usize| {
                system.hessian(i, j) * if i == j { 1.0 + DAMPING } else { 1.0 } + if i == j { 1e-12 } else { 0.0 }
            };
            let factor = Mat::<f64>::from_fn(poses, poses, damped).llt(Side::Lower).ok()?;
            let coupling = Mat::<f64>::from_fn(poses, shapes, |i, k| system.hessian(i, poses + k));
            let gradient = Mat::<f64>::from_fn(poses, 1, |i, _| -system.gradient(i));
            let by_shape = factor.solve(&coupling);
            let by_gradient = factor.solve(&gradient);
            let own = Mat::<f64>::from_fn(shapes, shapes, |i, j| damped(poses + i, poses + j));
            let own_right = Mat::<f64>::from_fn(shapes, 1, |i, _| -system.gradient(poses + i));
            let matrix = own - coupling.transpose() * &by_shape;
            let right = own_right - coupling.transpose() * &by_gradient;
            Some((matrix, right, by_shape, by_gradient))
        })
        .collect::<Option<Vec<_>>>()
        .context("expected frames that determine the pose, found a singular one")?;
    let share = 1.0 / systems.len() as f64;
    for (matrix, own, _, _) in &eliminated {
        reduced += matrix * faer::Scale(share);
        right += own * faer::Scale(share);
    }
    let factor = reduced.llt(Side::Lower).ok().context("expected scans that determine β, found none")?;
    let shape = factor.solve(&right);
    let steps = eliminated.iter().map(|(_, _, by_shape, by_gradient)| {
        let pose = by_gradient - by_shape * &shape;
        (0..poses).map(|i| pose[(i, 0)]).chain((0..shapes).map(|k| shape[(k, 0)])).collect()
    });
    Ok(steps.collect())
}
