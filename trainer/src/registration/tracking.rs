//! From frame to frame: predicted, fitted, judged; where that fails, again from the neighbours on either side.

use super::articulated::{State, difference};
use super::frame_fit::{Evidence, Model, Stage, closeness, fit_frame};
use super::keypoints::Keypoints;
use super::priors::Expected;
use super::scan_term::{Closeness, Cloud};
use super::start::stage;
use crate::progress::Progress;
use crease::rotation::quat_from_axis_angle;
use rayon::prelude::*;

/// Share of the last change that is expected again.
const INERTIA: f32 = 0.6;
/// Weight of a radian between a pose and the expected one, squared, m² …
const ROTATION_WEIGHT: f64 = 1.5e-5;
/// … and of a metre.
const TRANSLATION_WEIGHT: f64 = 1e-3;
/// A prediction is doubted where it leads this much farther from the scan than the frame before was.
const ALARM_RATIO: f64 = 1.3;
/// A frame fails where its distance to the scan is this many times the median …
const FAILURE_RATIO: f64 = 1.5;
/// … and this much beyond it, metres.
const FAILURE_EXCESS: f64 = 0.004;

/// One frame's fit.
#[derive(Clone, Debug)]
pub struct Tracked {
    /// Shape and pose.
    pub state: State,
    /// How close it is to the scan.
    pub closeness: Closeness,
}

/// Everything that tracking reads.
pub struct Track<'a> {
    /// The body.
    pub model: &'a Model<'a>,
    /// One cloud a frame.
    pub clouds: &'a [Cloud],
    /// Joints that are known, one entry a frame; empty for none.
    pub keypoints: &'a [Keypoints],
}

fn tracking_stages() -> [Stage; 2] {
    [stage(1_000, 0.15, 0.2, 4), stage(2_500, 0.06, 0.4, 6)]
}

fn final_stages() -> [Stage; 1] {
    [stage(5_000, 0.05, 0.5, 6)]
}

impl Track<'_> {
    /// What is known of frame `t`.
    pub fn evidence<'b>(&'b self, t: usize, expected: Option<&'b Expected>) -> Evidence<'b> {
        Evidence { cloud: &self.clouds[t], keypoints: self.keypoints.get(t), expected }
    }

    /// Follows the body from `start` through all frames, then once more backwards through those that fail.
    pub fn follow(&self, start: &State, progress: Progress) -> anyhow::Result<Vec<Tracked>> {
        let mut tracked = self.follow_through(0..self.clouds.len(), start, progress, "following the body")?;
        self.retry_backwards(&mut tracked)?;
        Ok(tracked)
    }

    /// Follows the body from `start` in the last frame back to the first.
    pub fn follow_back(&self, start: &State, progress: Progress) -> anyhow::Result<Vec<Tracked>> {
        let mut tracked = self.follow_through((0..self.clouds.len()).rev(), start, progress, "following it back")?;
        tracked.reverse();
        Ok(tracked)
    }

    /// Follows the body from `start` through `frames`, each a neighbour of the one before.
    fn follow_through(
        &self,
        frames: impl ExactSizeIterator<Item = usize>,
        start: &State,
        progress: Progress,
        title: &str,
    ) -> anyhow::Result<Vec<Tracked>> {
        let bar = progress.bar(title, frames.len());
        let mut tracked: Vec<Tracked> = Vec::with_capacity(frames.len());
        for t in frames {
            tracked.push(self.next(t, start, &tracked)?);
            bar.advance(1);
        }
        Ok(tracked)
    }

    /// How close `state` is to frame `t`.
    pub fn closeness(&self, t: usize, state: &State) -> Closeness {
        let [.., last] = tracking_stages();
        closeness(self.model, self.evidence(t, None), state, &last.search)
    }

    /// Frame `t` after those that were `tracked` before it, the latest last, or from `start`.
    fn next(&self, t: usize, start: &State, tracked: &[Tracked]) -> anyhow::Result<Tracked> {
        match tracked {
            [] => self.fit(t, start, None),
            [near] => self.fit(t, &near.state, Some(&near.state)),
            [.., far, near] => self.step(t, &near.state, &far.state, near.closeness.distance),
        }
    }

    /// Frame `t` from its neighbour and the neighbour's neighbour, on one side: as they move on, or, where that leaves the scan much farther
    /// off than is `usual` (metres), from where the neighbour is.
    fn step(&self, t: usize, near: &State, far: &State, usual: f64) -> anyhow::Result<Tracked> {
        let predicted = predict(near, far);
        let moved = self.fit(t, &predicted, Some(&predicted))?;
        if moved.closeness.distance < ALARM_RATIO * usual {
            return Ok(moved);
        }
        let stayed = self.fit(t, near, Some(near))?;
        Ok(if stayed.closeness.energy < moved.closeness.energy { stayed } else { moved })
    }

    fn fit(&self, t: usize, start: &State, expected: Option<&State>) -> anyhow::Result<Tracked> {
        let expected = expected.map(|state| near(state, 1.0));
        let evidence = self.evidence(t, expected.as_ref());
        let (state, closeness) = fit_frame(self.model, evidence, start, &tracking_stages(), false)?;
        Ok(Tracked { state, closeness })
    }

    /// Frames that fail are fitted again, coming from behind; the better fit stays.
    pub fn retry_backwards(&self, tracked: &mut [Tracked]) -> anyhow::Result<()> {
        let failing = failing_frames(tracked);
        for &t in failing.iter().rev() {
            let fitted = match tracked.get(t + 1..) {
                None | Some([]) => continue,
                Some([near]) => self.fit(t, &near.state, Some(&near.state))?,
                Some([near, far, ..]) => self.step(t, &near.state, &far.state, 0.0)?,
            };
            if fitted.closeness.energy < tracked[t].closeness.energy {
                tracked[t] = fitted;
            }
        }
        Ok(())
    }

    /// Fits every frame once more with more points, near the mean of its neighbours: `betas` are everyone's.
    pub fn refine(&self, tracked: &[Tracked], betas: &[f32], progress: Progress) -> anyhow::Result<Vec<Tracked>> {
        let bar = progress.bar("refining", tracked.len());
        (0..tracked.len())
            .into_par_iter()
            .map(|t| {
                let mut start = tracked[t].state.clone();
                start.betas = betas.to_vec();
                let expected = match (t.checked_sub(1).and_then(|t| tracked.get(t)), tracked.get(t + 1)) {
                    (Some(before), Some(after)) => near(&halfway(&before.state, &after.state), 2.0),
                    (Some(one), None) | (None, Some(one)) => near(&one.state, 0.5),
                    (None, None) => near(&start, 0.0),
                };
                let evidence = self.evidence(t, Some(&expected));
                let (state, closeness) = fit_frame(self.model, evidence, &start, &final_stages(), false)?;
                bar.advance(1);
                Ok(Tracked { state, closeness })
            })
            .collect()
    }
}

/// Frames much farther from their scan than most.
pub fn failing_frames(tracked: &[Tracked]) -> Vec<usize> {
    let mut distances: Vec<f64> = tracked.iter().map(|frame| frame.closeness.distance).collect();
    distances.sort_by(f64::total_cmp);
    let median = distances[distances.len() / 2];
    let limit = (FAILURE_RATIO * median).max(median + FAILURE_EXCESS);
    // A distance that is not a number fails too.
    let fails = |distance: f64| distance > limit || distance.is_nan();
    (0..tracked.len()).filter(|&t| fails(tracked[t].closeness.distance)).collect()
}

fn near(state: &State, strength: f64) -> Expected {
    Expected {
        rotations: state.pose.rotations.clone(),
        translation: state.pose.translation,
        rotation_weight: strength * ROTATION_WEIGHT,
        translation_weight: strength * TRANSLATION_WEIGHT,
    }
}

/// One more step of the same kind as from `far` to `near`.
fn predict(near: &State, far: &State) -> State {
    let mut next = near.clone();
    for (rotation, &earlier) in next.pose.rotations.iter_mut().zip(&far.pose.rotations) {
        *rotation = quat_from_axis_angle(INERTIA * difference(*rotation, earlier)) * *rotation;
    }
    next.pose.translation += INERTIA * (near.pose.translation - far.pose.translation);
    next
}

fn halfway(a: &State, b: &State) -> State {
    State { betas: a.betas.clone(), pose: crease::motion::interpolate(&a.pose, &b.pose, 0.5) }
}
