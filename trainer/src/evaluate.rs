//! How close a mesh is to the ground truth: two distances and the normal consistency.

use crate::comparison::Comparison;
use crate::sequence::{GroundTruth, Sequence};
use crease::animate::{Animator, Options, Stage};
use crease::avatar::Avatar;
use crease::mesh::Triangle;
use glam::Vec3A;
use std::sync::Arc;

/// Closeness to the ground truth; means over points, then over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Mean distance from ground-truth points to the closest point on the mesh's triangles, cm.
    pub scan_to_mesh_cm: f64,
    /// Mean over [`crate::comparison::MESH_SAMPLE_COUNT`] area-uniform samples of the mesh of the distance to the tangent plane of the nearest
    /// ground-truth point, cm. (Distance to the point itself has a floor that comes from the sampling alone.)
    pub mesh_to_scan_cm: f64,
    /// Mean cosine between ground-truth normals and the interpolated vertex normal at the closest surface point, signed.
    pub nc: f64,
}

impl Measures {
    /// Over frames; zeros without any.
    pub fn mean(all: &[Self]) -> Self {
        let mean = |value: fn(&Self) -> f64| all.iter().map(value).sum::<f64>() / all.len().max(1) as f64;
        Self {
            scan_to_mesh_cm: mean(|measures| measures.scan_to_mesh_cm),
            mesh_to_scan_cm: mean(|measures| measures.mesh_to_scan_cm),
            nc: mean(|measures| measures.nc),
        }
    }
}

/// Measures of the three stages of an avatar over several frames.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Evaluation {
    /// How many frames were measured.
    pub frames: usize,
    /// The skinned body.
    pub body: Measures,
    /// The base mesh.
    pub base: Measures,
    /// The detailed mesh.
    pub detailed: Measures,
}

/// Measures one mesh (metres, outward triangles) against one frame's ground truth.
///
/// Fails on a mesh without triangles.
pub fn measure(positions: &[Vec3A], triangles: &[Triangle], ground_truth: &GroundTruth) -> anyhow::Result<Measures> {
    Ok(Comparison::new(positions, triangles, ground_truth)?.measures())
}

/// Measures body, base and detailed mesh of `avatar` on `frames` of `sequence`, each at the finest subdivision level.
///
/// `liveliness` is [`Options::liveliness`]: 0 measures what is likeliest, 1 what a page shows. `each_frame` is called once for every frame
/// done. Fails where a frame has no ground truth.
pub fn evaluate(
    avatar: Arc<Avatar>,
    sequence: &Sequence,
    frames: &[usize],
    liveliness: f32,
    mut each_frame: impl FnMut(),
) -> anyhow::Result<Evaluation> {
    let mut animator = Animator::new(avatar)?;
    let triangles = animator.triangles().to_vec();
    let mut of_stages = [Vec::new(), Vec::new(), Vec::new()];
    for &frame in frames {
        let ground_truth = sequence.capture.ground_truth(frame)?;
        for (of_stage, stage) in of_stages.iter_mut().zip([Stage::Body, Stage::Base, Stage::Detailed]) {
            let options = Options { stage, liveliness, ..Options::default() };
            let positions = animator.animate(&sequence.poses[frame], &options);
            of_stage.push(measure(positions, &triangles, &ground_truth)?);
        }
        each_frame();
    }
    let [body, base, detailed] = of_stages.map(|of_stage| Measures::mean(&of_stage));
    Ok(Evaluation { frames: frames.len(), body, base, detailed })
}

/// Measures the meshes (metres, outward `triangles`) that `surface` gives for `frames` of `sequence`.
///
/// Fails where a frame has no ground truth, and where `surface` does.
pub fn evaluate_meshes(
    sequence: &Sequence,
    frames: &[usize],
    triangles: &[Triangle],
    mut surface: impl FnMut(usize) -> anyhow::Result<Vec<Vec3A>>,
) -> anyhow::Result<Measures> {
    let measure = |&frame: &usize| measure(&surface(frame)?, triangles, &sequence.capture.ground_truth(frame)?);
    Ok(Measures::mean(&frames.iter().map(measure).collect::<anyhow::Result<Vec<_>>>()?))
}
