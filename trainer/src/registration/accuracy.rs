//! How far registered bodies are from the true ones.

use crate::sequence::{BodyParameters, Camera};
use crate::visibility::visible_vertices;
use anyhow::ensure;
use crease::body::{Body, Pose, Rig, posed_from_rest};
use glam::Vec3A;
use rayon::prelude::*;
use serde::Serialize;

/// Means over points and frames, mm.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Accuracy {
    /// Distance between corresponding vertices.
    pub vertices_mm: f64,
    /// The same over the vertices that the camera sees of the true body, if there is a camera.
    pub seen_vertices_mm: Option<f64>,
    /// Distance between corresponding joints.
    pub joints_mm: f64,
    /// Mean vertex distance of each frame.
    pub frames_mm: Vec<f64>,
    /// Mean distance of each joint, by name.
    pub by_joint_mm: Vec<(String, f64)>,
}

/// Compares `found` with `truth`, frame by frame.
pub fn compare(
    body: &Body,
    found: &BodyParameters,
    truth: &BodyParameters,
    camera: Option<&Camera>,
) -> anyhow::Result<Accuracy> {
    ensure!(
        found.poses.len() == truth.poses.len(),
        "frames: expected {} as in the true body, found {}",
        truth.poses.len(),
        found.poses.len()
    );
    let rigs = [found, truth].map(|parameters| body.shaped(&parameters.betas));
    let frames: Vec<FrameError> = (0..truth.poses.len())
        .into_par_iter()
        .map(|t| {
            let [(vertices, joints), (true_vertices, true_joints)] =
                [posed(&rigs[0], &found.poses[t]), posed(&rigs[1], &truth.poses[t])];
            let seen = camera.map(|camera| visible_vertices(camera, &true_vertices, &body.triangles));
            let seen: Option<Vec<f64>> = seen.map(|seen| {
                let pairs = vertices.iter().zip(&true_vertices).zip(seen);
                pairs.filter(|pair| pair.1).map(|((a, b), _)| f64::from(a.distance(*b))).collect()
            });
            FrameError {
                vertices: mean(&distances(&vertices, &true_vertices)),
                seen: seen.map(|seen| mean(&seen)),
                joints: distances(&joints, &true_joints),
            }
        })
        .collect();
    let over_frames = |value: &dyn Fn(&FrameError) -> f64| 1e3 * mean(&frames.iter().map(value).collect::<Vec<_>>());
    let by_joint: Vec<(String, f64)> =
        (0..body.parents.len()).map(|j| (body.joint_names[j].clone(), over_frames(&|f| f.joints[j]))).collect();
    Ok(Accuracy {
        vertices_mm: over_frames(&|frame| frame.vertices),
        seen_vertices_mm: camera.map(|_| over_frames(&|frame| frame.seen.unwrap_or_default())),
        joints_mm: over_frames(&|frame| mean(&frame.joints)),
        frames_mm: frames.iter().map(|frame| 1e3 * frame.vertices).collect(),
        by_joint_mm: by_joint,
    })
}

struct FrameError {
    vertices: f64,
    seen: Option<f64>,
    joints: Vec<f64>,
}

fn distances(a: &[Vec3A], b: &[Vec3A]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| f64::from(a.distance(*b))).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn posed(rig: &Rig, pose: &Pose) -> (Vec<Vec3A>, Vec<Vec3A>) {
    let transforms = posed_from_rest(rig, pose);
    let joints = transforms.iter().zip(&rig.rest_joints).map(|(a, &joint)| a.transform_point3a(joint)).collect();
    (rig.posed(pose, &transforms), joints)
}
