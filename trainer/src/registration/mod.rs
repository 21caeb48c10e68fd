//! Registration: shape and poses of a body from scans alone.
//!
//! One β, and θ_t, t_t for each frame, that bring the body's skin close to the scans. Cloth lies outside the skin, so a point outside pulls
//! less than one inside, and the less the farther it stands off. All terms are squares, and their derivatives are analytic:
//! Gauss–Newton steps on a few thousand points find a pose in tens of milliseconds.
//!
//! 1. [`start`](find_start) tries directions and arms on the first frame, unless a pose is given.
//! 2. Tracking predicts, fits and judges frame after frame; failing frames are tried again from behind.
//! 3. A second track comes from the last frame; each limb follows the better of the two.
//! 4. β is estimated from several frames jointly, all frames are refined with it, near the mean of their neighbours.

mod accuracy;
mod articulated;
mod dressed;
mod frame_fit;
mod keypoint_files;
mod keypoints;
mod limbs;
mod priors;
mod scan_term;
mod separation;
mod shape;
mod start;
mod system;
mod tracking;

pub use accuracy::{Accuracy, compare};
pub use dressed::{DressedPerson, Hold};
pub use keypoint_files::read_keypoints;
pub use keypoints::Keypoints;

use crate::progress::Progress;
use crate::sequence::{BodyParameters, Capture};
use anyhow::{Context, ensure};
use articulated::{ArticulatedBody, State};
use crease::body::{Body, Pose};
use frame_fit::Model;
use rayon::prelude::*;
use scan_term::{Cloud, Search};
use start::{find_start, stage};
use tracking::{Track, failing_frames};

/// Shape components that are estimated.
const SHAPE_COUNT: usize = 10;
/// Frames from which β is estimated.
const SHAPE_FRAME_COUNT: usize = 10;
/// Rounds of estimating β and refining all frames.
const ROUND_COUNT: usize = 2;

/// What may be known beforehand.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// A pose near that of the first frame.
    pub initial_pose: Option<Pose>,
    /// Joints, one entry a frame; empty for none.
    pub keypoints: Vec<Keypoints>,
}

/// The outcome.
#[derive(Clone, Debug)]
pub struct Registration {
    /// β and the poses.
    pub parameters: BodyParameters,
    /// Mean distance from scan to body of each frame, metres.
    pub distances: Vec<f64>,
    /// Frames that fit much worse than the others.
    pub failing: Vec<usize>,
}

/// Estimates shape and poses of `body` from all scans of `capture`.
///
/// Fails where a scan cannot be read, and where the hints do not fit the sequence.
pub fn register(capture: &Capture, body: &Body, hints: &Hints, progress: Progress) -> anyhow::Result<Registration> {
    let count = hints.keypoints.len();
    ensure!(
        count == 0 || count == capture.frame_count,
        "keypoints: expected one entry for each of {} frames, found {count}",
        capture.frame_count
    );
    let bar = progress.bar("reading the scans", capture.frame_count);
    let clouds = (0..capture.frame_count)
        .into_par_iter()
        .map(|index| {
            let scan = capture.scan(index).context(
                "every frame is registered: mend this one, or take it out, number the others anew and say so in sequence.json",
            )?;
            let cloud = Cloud::new(&scan);
            bar.advance(1);
            Ok(cloud)
        })
        .collect::<anyhow::Result<Vec<Cloud>>>()?;
    drop(bar);
    let model = Model::new(ArticulatedBody::new(body, SHAPE_COUNT));
    let track = Track { model: &model, clouds: &clouds, keypoints: &hints.keypoints };
    let start = first_state(&track, hints)?;
    let tracked = track.follow(&start, progress)?;
    let mut tracked = track.mend_limbs(&tracked, progress)?;
    for _ in 0..ROUND_COUNT {
        let betas = common_shape(&track, &tracked)?;
        tracked = track.refine(&tracked, &betas, progress)?;
        track.retry_backwards(&mut tracked)?;
    }
    Ok(Registration {
        parameters: BodyParameters {
            betas: tracked[0].state.betas.clone(),
            poses: tracked.iter().map(|frame| frame.state.pose.clone()).collect(),
        },
        distances: tracked.iter().map(|frame| frame.closeness.distance).collect(),
        failing: failing_frames(&tracked),
    })
}

/// The first frame's state, from the given pose or by search.
fn first_state(track: &Track, hints: &Hints) -> anyhow::Result<State> {
    let evidence = track.evidence(0, None);
    let Some(pose) = &hints.initial_pose else { return find_start(track.model, evidence) };
    let joints = track.model.body.joint_count();
    ensure!(
        pose.rotations.len() == joints,
        "initial pose: expected {joints} joints as the body has, found {}",
        pose.rotations.len()
    );
    let start = State { pose: pose.clone(), ..track.model.body.rest() };
    let stages = [stage(2_000, 0.2, 0.0, 10), stage(4_000, 0.08, 0.3, 12)];
    Ok(frame_fit::fit_frame(track.model, evidence, &start, &stages, true)?.0)
}

/// β from frames spread over those that do not fail.
fn common_shape(track: &Track, tracked: &[tracking::Tracked]) -> anyhow::Result<Vec<f32>> {
    let failing = failing_frames(tracked);
    let good: Vec<usize> = (0..tracked.len()).filter(|t| !failing.contains(t)).collect();
    let step = good.len().div_ceil(SHAPE_FRAME_COUNT).max(1);
    let chosen: Vec<usize> = good.into_iter().step_by(step).collect();
    let betas = tracked[0].state.betas.clone();
    let mut states: Vec<State> =
        chosen.iter().map(|&t| State { betas: betas.clone(), pose: tracked[t].state.pose.clone() }).collect();
    let evidence: Vec<_> = chosen.iter().map(|&t| track.evidence(t, None)).collect();
    let search = Search { point_count: 4_000, reach: 0.05, least_cosine: 0.5 };
    shape::fit_shape(track.model, &evidence, &mut states, &search, 8)?;
    let betas = states.into_iter().next().context("expected frames that fit, found none")?.betas;
    ensure!(
        betas.iter().all(|beta| beta.is_finite()),
        "the shape of the body: expected finite numbers, found {betas:?}"
    );
    Ok(betas)
}
