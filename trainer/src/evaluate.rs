//! How close a mesh is to the ground truth: two distances and the normal consistency.

use crate::closest::ClosestPoint;
use crate::nearest::NearestPoints;
use crate::sampling::area_uniform;
use crate::sequence::{GroundTruth, Sequence};
use crease::animate::{Animator, Options, Stage};
use crease::avatar::Avatar;
use crease::mesh::{Triangle, vertex_normals};
use glam::Vec3A;
use rayon::prelude::*;
use std::sync::Arc;

/// Area-uniform samples of the mesh in the mesh-to-scan distance.
pub const MESH_SAMPLE_COUNT: usize = 100_000;
const MESH_SAMPLE_SEED: u64 = 0;

/// Closeness to the ground truth; means over points, then over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Mean distance from ground-truth points to the closest point on the mesh's triangles, cm.
    pub scan_to_mesh_cm: f64,
    /// Mean over [`MESH_SAMPLE_COUNT`] area-uniform samples of the mesh of the distance to the tangent plane of the nearest
    /// ground-truth point, cm. (Distance to the point itself has a floor that comes from the sampling alone.)
    pub mesh_to_scan_cm: f64,
    /// Mean cosine between ground-truth normals and the interpolated vertex normal at the closest surface point, signed.
    pub nc: f64,
}

impl Measures {
    /// Over frames.
    fn mean(all: &[Self]) -> Self {
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
    let mut normals = vec![Vec3A::ZERO; positions.len()];
    vertex_normals(positions, triangles, &mut normals);
    measure_with_normals(positions, triangles, &normals, ground_truth)
}

fn measure_with_normals(
    positions: &[Vec3A],
    triangles: &[Triangle],
    normals: &[Vec3A],
    ground_truth: &GroundTruth,
) -> anyhow::Result<Measures> {
    let closest = ClosestPoint::new(positions, triangles)?;
    let found = closest.query_all(&ground_truth.points);
    let (mut distance, mut cosine) = (0.0, 0.0);
    for ((surface, point), normal) in found.iter().zip(&ground_truth.points).zip(&ground_truth.normals) {
        distance += f64::from(surface.interpolate(triangles, positions).distance(*point));
        cosine += f64::from(surface.interpolate(triangles, normals).normalize_or_zero().dot(*normal));
    }

    let nearest = NearestPoints::new(&ground_truth.points);
    let samples = area_uniform(positions, triangles, MESH_SAMPLE_COUNT, MESH_SAMPLE_SEED);
    let to_planes: Vec<f32> = samples
        .par_iter()
        .with_min_len(256)
        .map(|sample| {
            let position = sample.interpolate(triangles, positions);
            let index = nearest.one(position).index as usize;
            (position - ground_truth.points[index]).dot(ground_truth.normals[index]).abs()
        })
        .collect();

    let count = ground_truth.points.len() as f64;
    Ok(Measures {
        scan_to_mesh_cm: 100.0 * distance / count,
        mesh_to_scan_cm: 100.0 * to_planes.iter().map(|&d| f64::from(d)).sum::<f64>() / samples.len() as f64,
        nc: cosine / count,
    })
}

/// Measures body, base and detailed mesh of `avatar` on `frames` of `sequence`, each at the finest subdivision level.
///
/// `each_frame` is called once for every frame done. Fails where a frame has no ground truth.
pub fn evaluate(
    avatar: Arc<Avatar>,
    sequence: &Sequence,
    frames: &[usize],
    mut each_frame: impl FnMut(),
) -> anyhow::Result<Evaluation> {
    let mut animator = Animator::new(avatar)?;
    let triangles = animator.triangles().to_vec();
    let mut of_stages = [Vec::new(), Vec::new(), Vec::new()];
    for &frame in frames {
        let ground_truth = sequence.capture.ground_truth(frame)?;
        for (of_stage, stage) in of_stages.iter_mut().zip([Stage::Body, Stage::Base, Stage::Detailed]) {
            let options = Options { stage, ..Options::default() };
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
/// Fails where a frame has no ground truth.
pub fn evaluate_meshes(
    sequence: &Sequence,
    frames: &[usize],
    triangles: &[Triangle],
    surface: impl Fn(usize) -> Vec<Vec3A>,
) -> anyhow::Result<Measures> {
    let measure = |&frame: &usize| measure(&surface(frame), triangles, &sequence.capture.ground_truth(frame)?);
    Ok(Measures::mean(&frames.iter().map(measure).collect::<anyhow::Result<Vec<_>>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{sphere, sphere_points};

    fn truth(radius: f32) -> GroundTruth {
        let points = sphere_points(20_000, radius, 5);
        let normals = points.iter().map(|point| point.normalize()).collect();
        GroundTruth { points, normals }
    }

    /// Measures a sphere whose vertex normals are exact.
    fn measure_sphere(mesh_radius: f32, inward: bool, truth_radius: f32) -> Measures {
        let mesh = sphere(mesh_radius, 5);
        let sign = if inward { -1.0 } else { 1.0 };
        let normals: Vec<Vec3A> = mesh.positions.iter().map(|point| point.normalize() * sign).collect();
        measure_with_normals(&mesh.positions, &mesh.triangles, &normals, &truth(truth_radius)).unwrap()
    }

    #[test]
    fn a_sphere_matches_itself() {
        let measures = measure_sphere(0.5, false, 0.5);
        assert!(measures.scan_to_mesh_cm < 0.01, "{measures:?}");
        assert!(measures.mesh_to_scan_cm < 0.02, "{measures:?}");
        assert!(measures.nc > 0.9999, "{measures:?}");
    }

    #[test]
    fn an_offset_of_one_centimetre_measures_one_centimetre() {
        for radius in [0.49, 0.51] {
            let measures = measure_sphere(radius, false, 0.5);
            assert!((measures.scan_to_mesh_cm - 1.0).abs() < 0.02, "{measures:?}");
            assert!((measures.mesh_to_scan_cm - 1.0).abs() < 0.02, "{measures:?}");
            assert!(measures.nc > 0.9999);
        }
    }

    #[test]
    fn the_tangent_plane_has_no_sampling_floor() {
        let mesh = sphere(0.5, 5);
        let truth = truth(0.5);
        let nearest = NearestPoints::new(&truth.points);
        let samples = area_uniform(&mesh.positions, &mesh.triangles, 5_000, 0);
        let to_points = samples
            .iter()
            .map(|sample| nearest.one(sample.interpolate(&mesh.triangles, &mesh.positions)).squared_distance.sqrt())
            .sum::<f32>()
            / 50.0;
        assert!(to_points > 0.3, "distance to the points themselves would measure {to_points} cm for a perfect mesh");
        assert!(measure_sphere(0.5, false, 0.5).mesh_to_scan_cm < 0.02);
    }

    #[test]
    fn normals_are_signed() {
        let measures = measure_sphere(0.5, true, 0.5);
        assert!(measures.nc < -0.9999, "an inward surface must not pass: {measures:?}");
    }

    #[test]
    fn the_directions_differ_where_one_surface_lacks_a_part() {
        let mesh = sphere(0.5, 5);
        let mut half = truth(0.5);
        let keep: Vec<usize> = (0..half.points.len()).filter(|&i| half.points[i].y > 0.0).collect();
        half.points = keep.iter().map(|&i| half.points[i]).collect();
        half.normals = keep.iter().map(|&i| half.normals[i]).collect();
        let normals: Vec<Vec3A> = mesh.positions.iter().map(|point| point.normalize()).collect();
        let measures = measure_with_normals(&mesh.positions, &mesh.triangles, &normals, &half).unwrap();
        assert!(measures.scan_to_mesh_cm < 0.01, "all that was seen is there: {measures:?}");
        assert!(measures.mesh_to_scan_cm > 1.0, "half of the mesh has no counterpart: {measures:?}");
    }
}
