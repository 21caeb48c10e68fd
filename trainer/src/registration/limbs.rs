//! Limbs that were lost on the way: looked for anew at the end, followed backwards, and each taken from the better of the two tracks.
//!
//! A limb that was hidden behind the trunk may come out on the wrong side, and stay there: from then on the nearest surface is another one.
//! A track that comes from behind has not been through that. Which of the two tracks a limb follows is decided for the whole sequence
//! at once (Viterbi): where the scan shows the limb the closer track wins, where it does not the limb changes over where that turns it least.

use super::articulated::{State, difference};
use super::frame_fit::fit_frame;
use super::start::stage;
use super::tracking::{Track, Tracked};
use crate::progress::Progress;
use glam::Quat;
use rayon::prelude::*;
use std::array;

/// Joints of each limb, from the trunk outwards.
const LIMBS: [&[&str]; 4] = [
    &["left_collar", "left_shoulder", "left_elbow", "left_wrist", "left_hand"],
    &["right_collar", "right_shoulder", "right_elbow", "right_wrist", "right_hand"],
    &["left_hip", "left_knee", "left_ankle", "left_foot"],
    &["right_hip", "right_knee", "right_ankle", "right_foot"],
];
/// Where the left upper arm is looked for: about z (up, level, hanging) …
const LIFTS: [f32; 4] = [0.8, 0.0, -0.75, -1.3];
/// … and about y (forward, aside, back); the elbow bends about y. Radians; the right arm mirrors them.
const SWINGS: [f32; 3] = [-0.9, 0.0, 0.6];
const BENDS: [f32; 3] = [0.0, -0.8, -1.7];
/// Weight of a radian that a joint turns from frame to frame, squared, m².
const TURN_WEIGHT: f64 = 1e-4;

impl Track<'_> {
    /// `tracked` with each limb from there or from a second track, which starts at the last frame and goes backwards.
    pub fn mend_limbs(&self, tracked: &[Tracked], progress: Progress) -> anyhow::Result<Vec<Tracked>> {
        let Some(last) = tracked.len().checked_sub(1) else { return Ok(Vec::new()) };
        let start = self.look_for_arms(last, &tracked[last].state)?;
        let behind = self.follow_back(&start, progress)?;
        let mut states: Vec<State> = tracked.iter().map(|frame| frame.state.clone()).collect();
        for limb in LIMBS {
            let joints: Vec<usize> = limb.iter().filter_map(|name| self.model.body.joint(name)).collect();
            let candidates: Vec<[State; 2]> = (states.iter().zip(&behind))
                .map(|(state, behind)| [state.clone(), with_joints(state, &behind.state, &joints)])
                .collect();
            let energies: Vec<[f64; 2]> = candidates
                .par_iter()
                .enumerate()
                .map(|(t, candidates)| candidates.each_ref().map(|state| self.closeness(t, state).energy))
                .collect();
            let turn = |t: usize, from: usize, to: usize| {
                let rotations = |t: usize, choice: usize| &candidates[t][choice].pose.rotations;
                let angle = |&joint: &usize| difference(rotations(t + 1, to)[joint], rotations(t, from)[joint]);
                TURN_WEIGHT * joints.iter().map(|joint| f64::from(angle(joint).length_squared())).sum::<f64>()
            };
            let chosen = cheapest_path(&energies, turn);
            states =
                candidates.into_iter().zip(chosen).map(|(candidates, choice)| candidates[choice].clone()).collect();
        }
        let judged = |(t, state): (usize, State)| Tracked { closeness: self.closeness(t, &state), state };
        Ok(states.into_par_iter().enumerate().map(judged).collect())
    }

    /// The state of frame `t` with each arm where the scan shows it, if that is nearer than where it is.
    fn look_for_arms(&self, t: usize, state: &State) -> anyhow::Result<State> {
        let stages = [stage(1_000, 0.15, 0.0, 8), stage(2_500, 0.06, 0.4, 6)];
        let evidence = self.evidence(t, None);
        let mut best = fit_frame(self.model, evidence, state, &stages, false)?;
        for (side, limb) in [1.0, -1.0].into_iter().zip(LIMBS) {
            let [Some(shoulder), Some(elbow)] = [limb[1], limb[2]].map(|name| self.model.body.joint(name)) else {
                continue;
            };
            let mut starts = Vec::new();
            for lift in LIFTS {
                for swing in SWINGS {
                    for bend in BENDS {
                        let mut start = best.0.clone();
                        start.pose.rotations[shoulder] =
                            Quat::from_rotation_y(side * swing) * Quat::from_rotation_z(side * lift);
                        start.pose.rotations[elbow] = Quat::from_rotation_y(side * bend);
                        starts.push(start);
                    }
                }
            }
            let fitted = starts
                .par_iter()
                .map(|start| fit_frame(self.model, evidence, start, &stages, false))
                .collect::<anyhow::Result<Vec<_>>>()?;
            best = fitted
                .into_iter()
                .chain([best])
                .min_by(|a, b| a.1.energy.total_cmp(&b.1.energy))
                .expect("one at least");
        }
        Ok(best.0)
    }
}

/// `state` with the rotations of `joints` that `other` has.
fn with_joints(state: &State, other: &State, joints: &[usize]) -> State {
    let mut mixed = state.clone();
    for &joint in joints {
        mixed.pose.rotations[joint] = other.pose.rotations[joint];
    }
    mixed
}

/// One of two choices for each frame, so that their energies and the costs of `turn` (frame, choice there, choice in the next) are least in sum.
fn cheapest_path(energies: &[[f64; 2]], turn: impl Fn(usize, usize, usize) -> f64) -> Vec<usize> {
    let mut least = energies[0];
    let mut came_from: Vec<[usize; 2]> = Vec::with_capacity(energies.len() - 1);
    for (t, energy) in energies.iter().enumerate().skip(1) {
        let step: [(f64, usize); 2] = array::from_fn(|to| {
            let costs: [f64; 2] = array::from_fn(|from| least[from] + turn(t - 1, from, to));
            if costs[1] < costs[0] { (costs[1], 1) } else { (costs[0], 0) }
        });
        least = array::from_fn(|to| step[to].0 + energy[to]);
        came_from.push(step.map(|(_, from)| from));
    }
    let mut choice = usize::from(least[1] < least[0]);
    let mut path = vec![choice];
    for from in came_from.iter().rev() {
        choice = from[choice];
        path.push(choice);
    }
    path.reverse();
    path
}

#[cfg(test)]
mod tests {
    use super::super::articulated::ArticulatedBody;
    use super::super::frame_fit::Model;
    use super::super::scan_term::{Closeness, Cloud};
    use super::*;
    use crate::sampling::area_uniform;
    use crate::sequence::Frame;
    use crease::body::Body;
    use glam::Vec3A;

    /// The body with its left arm swung aside by `angle`, radians.
    fn swung(body: &ArticulatedBody, angle: f32) -> State {
        let mut state = body.rest();
        state.pose.rotations[16] = Quat::from_rotation_z(angle - 1.2);
        state.pose.rotations[17] = Quat::from_rotation_z(1.2);
        state
    }

    fn scan(body: &ArticulatedBody, state: &State, index: usize) -> Cloud {
        let posed = body.pose(state, false);
        let samples = area_uniform(&posed.vertices, body.triangles(), 5_000, index as u64);
        let points: Vec<Vec3A> =
            samples.iter().map(|sample| sample.interpolate(body.triangles(), &posed.vertices)).collect();
        let weights = vec![1.0; points.len()];
        Cloud::new(&Frame { index, points, normals: None, colours: None, weights, camera: None })
    }

    #[test]
    fn an_arm_that_was_lost_on_the_way_is_found_again() {
        let body = Body::read(include_bytes!("../../../assets/open_body.npz"), "the open body").unwrap();
        let model = Model::new(ArticulatedBody::new(&body, 2));
        let truth: Vec<State> = (0..6).map(|t| swung(&model.body, 0.15 * t as f32)).collect();
        let clouds: Vec<Cloud> = truth.iter().enumerate().map(|(t, state)| scan(&model.body, state, t)).collect();
        let track = Track { model: &model, clouds: &clouds, keypoints: &[] };
        // From frame 3 on the arm points up, where the scans have nothing.
        let lost = |t: usize, state: &State| if t < 3 { state.clone() } else { swung(&model.body, 2.4) };
        let tracked: Vec<Tracked> = (truth.iter().enumerate())
            .map(|(t, state)| Tracked { state: lost(t, state), closeness: Closeness::default() })
            .collect();
        let mended = track.mend_limbs(&tracked, Progress::Silent).unwrap();
        let hand = |state: &State| model.body.pose(state, false).joints[22];
        assert!(hand(&tracked[4].state).distance(hand(&truth[4])) > 0.5);
        for (t, (found, truth)) in mended.iter().zip(&truth).enumerate() {
            let distance = hand(&found.state).distance(hand(truth));
            assert!(distance < 0.04, "frame {t}: the hand is {distance} m off");
        }
    }

    #[test]
    fn the_path_follows_the_energy_and_changes_over_where_it_is_cheap() {
        // The first choice is right up to frame 2, the second from frame 5 on; between, nothing is seen.
        let energies = [[0.0, 9.0], [0.0, 9.0], [0.0, 9.0], [1.0, 1.0], [1.0, 1.0], [9.0, 0.0], [9.0, 0.0]];
        let turn = |t: usize, from: usize, to: usize| if from == to { 0.0 } else { [5.0, 5.0, 3.0, 1.0, 2.0, 5.0][t] };
        assert_eq!(cheapest_path(&energies, turn), [0, 0, 0, 0, 1, 1, 1]);
        assert_eq!(cheapest_path(&energies[..1], turn), [0]);
        // Where a change costs more than all it saves, the choice that is better on the whole stays.
        let dear = |_: usize, from: usize, to: usize| if from == to { 0.0 } else { 100.0 };
        assert_eq!(cheapest_path(&energies, dear), [0; 7]);
    }
}
