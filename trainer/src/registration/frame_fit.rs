//! One frame: Gauss–Newton steps on scan, priors and hints, coarse to fine.

use super::articulated::{ArticulatedBody, State};
use super::keypoints::{Keypoints, add_keypoints};
use super::priors::{Expected, PriorWeights, add_expected, add_pose_prior, add_shape_prior};
use super::scan_term::{Closeness, Cloud, Search, Surface, scan_system};
use super::separation::{Proxies, add_separation};
use super::system::System;

/// Levenberg's and Marquardt's damping, relative to the diagonal.
const DAMPING: f64 = 1e-3;
/// No joint turns further in one step, radians.
const LONGEST_TURN: f64 = 0.35;
/// A step shorter than this in every unknown ends a stage (radians, metres, units of β).
const SHORTEST_STEP: f64 = 5e-4;

/// A round of steps with one way of finding counterparts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// How counterparts are found.
    pub search: Search,
    /// At most so many steps.
    pub step_count: usize,
}

/// What does not change from frame to frame.
pub struct Model<'a> {
    /// The body.
    pub body: ArticulatedBody<'a>,
    /// Its surface.
    pub surface: Surface,
    /// Balls that keep its parts from each other.
    pub proxies: Proxies,
    /// Weights of the priors.
    pub priors: PriorWeights,
}

impl<'a> Model<'a> {
    /// Prepares a body.
    pub fn new(body: ArticulatedBody<'a>) -> Self {
        let surface = Surface::new(&body);
        let proxies = Proxies::new(&body);
        Self { body, surface, proxies, priors: PriorWeights::default() }
    }
}

/// What is known of one frame.
#[derive(Clone, Copy)]
pub struct Evidence<'a> {
    /// Its scan.
    pub cloud: &'a Cloud,
    /// Joints or their pictures, if given.
    pub keypoints: Option<&'a Keypoints>,
    /// A pose that it should be near.
    pub expected: Option<&'a Expected>,
}

/// The state after `stages`, starting from `start`, and how close it is. β moves too where `with_shape`.
pub fn fit_frame(
    model: &Model,
    evidence: Evidence,
    start: &State,
    stages: &[Stage],
    with_shape: bool,
) -> anyhow::Result<(State, Closeness)> {
    let mut state = start.clone();
    for stage in stages {
        for _ in 0..stage.step_count {
            let (mut system, _) = frame_system(model, evidence, &state, &stage.search, with_shape)?;
            if with_shape {
                add_shape_prior(&state.betas, model.body.pose_unknowns(), model.priors.shape, &mut system);
            }
            let step = bounded(system.step(DAMPING), 3 * model.body.joint_count());
            state = model.body.moved(&state, &step);
            if step.iter().all(|x| x.abs() < SHORTEST_STEP) {
                break;
            }
        }
    }
    let last = stages.last().map_or(Closeness::default(), |stage| closeness(model, evidence, &state, &stage.search));
    Ok((state, last))
}

/// Normal equations of everything but the shape prior at `state`; the energy is of the scan and of the pose prior.
pub fn frame_system(
    model: &Model,
    evidence: Evidence,
    state: &State,
    search: &Search,
    with_shape: bool,
) -> anyhow::Result<(System, Closeness)> {
    let body = &model.body;
    let unknowns = body.pose_unknowns() + if with_shape { body.shape_count() } else { 0 };
    let posed = body.pose(state, with_shape);
    let (mut system, mut closeness) =
        scan_system(&posed, &model.surface, body.triangles(), evidence.cloud, search, unknowns)?;
    closeness.energy += add_pose_prior(body, state, &model.priors, &mut system);
    closeness.energy += add_separation(&posed, &model.proxies, &mut system);
    if let Some(keypoints) = evidence.keypoints {
        closeness.energy += add_keypoints(&posed, keypoints, &mut system);
    }
    if let Some(expected) = evidence.expected {
        add_expected(state, expected, &mut system);
    }
    Ok((system, closeness))
}

/// How close `state` is, and its energy as of [`frame_system`]; infinite where that fails.
pub fn closeness(model: &Model, evidence: Evidence, state: &State, search: &Search) -> Closeness {
    frame_system(model, evidence, state, search, false)
        .map_or(Closeness { energy: f64::INFINITY, distance: f64::INFINITY }, |(_, closeness)| closeness)
}

/// The step, shortened as a whole so that no rotation is longer than [`LONGEST_TURN`].
fn bounded(mut step: Vec<f64>, rotation_count: usize) -> Vec<f64> {
    let longest = step[..rotation_count].chunks(3).map(|r| (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).sqrt());
    let longest = longest.fold(0.0, f64::max);
    if longest > LONGEST_TURN {
        step.iter_mut().for_each(|x| *x *= LONGEST_TURN / longest);
    }
    step
}
