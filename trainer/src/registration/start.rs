//! The first frame: which way the person faces and what the arms do, by trying.

use super::articulated::State;
use super::frame_fit::{Evidence, Model, Stage, fit_frame};
use super::scan_term::Search;
use glam::{Quat, Vec3, Vec3A};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Directions of the face that are tried.
const TURN_COUNT: usize = 8;
/// How far the left arm hangs from a T (about z, radians), and how far its elbow bends (about y): T, A, I and casual. The right arm mirrors it.
const ARMS: [[f32; 2]; 4] = [[0.0, 0.0], [-0.75, -0.1], [-1.3, -0.1], [-1.15, -0.6]];
/// Starts that are followed to the end.
const FINALISTS: usize = 4;
/// Share of the points taken for stray ones at the feet and at the top of the head.
const STRAY: f32 = 0.01;
/// A body is about so thick: what a camera sees of it lies half of this before its middle, metres.
const THICKNESS: f32 = 0.2;
/// β_0 is not guessed beyond this.
const TALLEST: f32 = 2.5;

/// A near upright person in the first frame: the state with the least energy of many starts.
pub fn find_start(model: &Model, evidence: Evidence) -> anyhow::Result<State> {
    let quick = [stage(600, 0.25, -1.0, 5)];
    let thorough = [stage(1_500, 0.15, 0.0, 10), stage(3_000, 0.08, 0.3, 10)];
    let mut tried = starts(model, evidence)
        .par_iter()
        .map(|start| fit_frame(model, evidence, start, &quick, false))
        .collect::<anyhow::Result<Vec<_>>>()?;
    tried.sort_by(|a, b| a.1.energy.total_cmp(&b.1.energy));
    tried.truncate(FINALISTS);
    let finalists = tried
        .par_iter()
        .map(|(state, _)| fit_frame(model, evidence, state, &thorough, true))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let best = finalists.into_iter().min_by(|a, b| a.1.energy.total_cmp(&b.1.energy));
    Ok(best.expect("several starts are tried").0)
}

/// A stage of registration.
pub fn stage(point_count: usize, reach: f32, least_cosine: f32, step_count: usize) -> Stage {
    Stage { search: Search { point_count, reach, least_cosine }, step_count }
}

fn starts(model: &Model, evidence: Evidence) -> Vec<State> {
    let body = &model.body;
    let points = &evidence.cloud.points;
    let mut heights: Vec<f32> = points.iter().map(|point| point.y).collect();
    heights.sort_by(f32::total_cmp);
    let stray = (heights.len() as f32 * STRAY) as usize;
    let (bottom, top) = (heights[stray], heights[heights.len() - 1 - stray]);
    let mut middle = points.iter().sum::<Vec3A>() / points.len() as f32;
    if let Some(camera) = &evidence.cloud.camera {
        let away = (middle - camera.position()) * Vec3A::new(1.0, 0.0, 1.0);
        middle += away.normalize_or_zero() * (0.5 * THICKNESS);
    }
    let mut rest = body.rest();
    let height = |state: &State| {
        let posed = body.pose(state, false);
        let ys = || posed.vertices.iter().map(|vertex| vertex.y);
        (ys().fold(f32::INFINITY, f32::min), ys().fold(f32::NEG_INFINITY, f32::max))
    };
    let (low, high) = height(&rest);
    if let Some(beta) = rest.betas.first_mut() {
        *beta = 1.0;
        let (lower, higher) = height(&rest);
        let growth = (higher - lower) - (high - low);
        let wanted = ((top - bottom) - (high - low)) / growth;
        rest.betas[0] = if growth.abs() > 1e-3 { wanted.clamp(-TALLEST, TALLEST) } else { 0.0 };
    }
    let (low, _) = height(&rest);
    let pelvis = body.pose(&rest, false).joints[0];
    rest.pose.translation = Vec3::new(middle.x - pelvis.x, bottom - low, middle.z - pelvis.z);

    let mut starts = Vec::new();
    for turn in 0..TURN_COUNT {
        for [hang, bend] in ARMS {
            let mut start = rest.clone();
            start.pose.rotations[0] = Quat::from_rotation_y(TAU * turn as f32 / TURN_COUNT as f32);
            let turns = [
                ("left_shoulder", Quat::from_rotation_z(hang)),
                ("right_shoulder", Quat::from_rotation_z(-hang)),
                ("left_elbow", Quat::from_rotation_y(bend)),
                ("right_elbow", Quat::from_rotation_y(-bend)),
            ];
            for (name, rotation) in turns {
                if let Some(joint) = body.joint(name) {
                    start.pose.rotations[joint] = rotation;
                }
            }
            starts.push(start);
        }
    }
    starts
}
