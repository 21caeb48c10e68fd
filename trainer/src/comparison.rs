//! One mesh against one frame's true surface, point by point.

use crate::closest::{ClosestPoint, SurfacePoint};
use crate::evaluate::Measures;
use crate::nearest::NearestPoints;
use crate::normals::unit_normals;
use crate::sampling::area_uniform;
use crate::sequence::GroundTruth;
use crease::mesh::Triangle;
use glam::Vec3A;
use rayon::prelude::*;

/// Area-uniform samples of the mesh in the mesh-to-scan distance.
pub const MESH_SAMPLE_COUNT: usize = 100_000;
const MESH_SAMPLE_SEED: u64 = 0;

/// What was found for each point of the ground truth, and for each sample of the mesh.
pub struct Comparison {
    /// The closest point on the mesh's triangles.
    pub closest: Vec<SurfacePoint>,
    /// Distance to it, metres: positive where the truth lies outside the mesh, negative where it lies inside.
    pub gaps: Vec<f32>,
    /// Cosine between the true normal and the interpolated vertex normal there.
    pub cosines: Vec<f32>,
    /// Distance of each of [`MESH_SAMPLE_COUNT`] samples of the mesh to the tangent plane of the nearest true point, metres.
    pub to_planes: Vec<f32>,
}

impl Comparison {
    /// Compares a mesh (metres, outward triangles). Fails on one without triangles.
    pub fn new(positions: &[Vec3A], triangles: &[Triangle], ground_truth: &GroundTruth) -> anyhow::Result<Self> {
        Self::with_normals(positions, triangles, &unit_normals(positions, triangles), ground_truth)
    }

    fn with_normals(
        positions: &[Vec3A],
        triangles: &[Triangle],
        normals: &[Vec3A],
        ground_truth: &GroundTruth,
    ) -> anyhow::Result<Self> {
        let closest = ClosestPoint::new(positions, triangles)?.query_all(&ground_truth.points);
        let (mut gaps, mut cosines) = (Vec::with_capacity(closest.len()), Vec::with_capacity(closest.len()));
        for ((surface, &point), &true_normal) in closest.iter().zip(&ground_truth.points).zip(&ground_truth.normals) {
            let gap = point - surface.interpolate(triangles, positions);
            let normal = surface.interpolate(triangles, normals).normalize_or_zero();
            gaps.push(gap.length().copysign(gap.dot(normal)));
            cosines.push(normal.dot(true_normal));
        }

        let nearest = NearestPoints::new(&ground_truth.points);
        let samples = area_uniform(positions, triangles, MESH_SAMPLE_COUNT, MESH_SAMPLE_SEED);
        let to_plane = |sample: &SurfacePoint| {
            let position = sample.interpolate(triangles, positions);
            let index = nearest.one(position).index as usize;
            (position - ground_truth.points[index]).dot(ground_truth.normals[index]).abs()
        };
        let to_planes = samples.par_iter().with_min_len(256).map(to_plane).collect();
        Ok(Self { closest, gaps, cosines, to_planes })
    }

    /// Means over all points.
    pub fn measures(&self) -> Measures {
        let mean = |values: &[f32], of: fn(f32) -> f32| {
            values.iter().map(|&value| f64::from(of(value))).sum::<f64>() / values.len() as f64
        };
        Measures {
            scan_to_mesh_cm: 100.0 * mean(&self.gaps, f32::abs),
            mesh_to_scan_cm: 100.0 * mean(&self.to_planes, |distance| distance),
            nc: mean(&self.cosines, |cosine| cosine),
        }
    }

    /// The mean gap around each of the mesh's `vertex_count` vertices, metres; none where no true point is near.
    pub fn gaps_at_vertices(&self, vertex_count: usize, triangles: &[Triangle]) -> Vec<Option<f32>> {
        let mut sums = vec![[0.0f32; 2]; vertex_count];
        for (closest, gap) in self.closest.iter().zip(&self.gaps) {
            for (vertex, weight) in triangles[closest.triangle as usize].iter().zip(closest.barycentric) {
                let sum = &mut sums[*vertex as usize];
                *sum = [sum[0] + weight * gap, sum[1] + weight];
            }
        }
        sums.iter().map(|&[gap, weight]| (weight > 0.0).then(|| gap / weight)).collect()
    }
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

    fn measured(positions: &[Vec3A], triangles: &[Triangle], normals: &[Vec3A], truth: &GroundTruth) -> Measures {
        Comparison::with_normals(positions, triangles, normals, truth).unwrap().measures()
    }

    /// Measures a sphere whose vertex normals are exact.
    fn measure_sphere(mesh_radius: f32, inward: bool, truth_radius: f32) -> Measures {
        let mesh = sphere(mesh_radius, 5);
        let sign = if inward { -1.0 } else { 1.0 };
        let normals: Vec<Vec3A> = mesh.positions.iter().map(|point| point.normalize() * sign).collect();
        measured(&mesh.positions, &mesh.triangles, &normals, &truth(truth_radius))
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
        let measures = measured(&mesh.positions, &mesh.triangles, &normals, &half);
        assert!(measures.scan_to_mesh_cm < 0.01, "all that was seen is there: {measures:?}");
        assert!(measures.mesh_to_scan_cm > 1.0, "half of the mesh has no counterpart: {measures:?}");
    }

    #[test]
    fn gaps_are_positive_where_the_truth_lies_outside() {
        let mesh = sphere(0.49, 5);
        for (radius, sign) in [(0.5, 1.0), (0.48, -1.0)] {
            let comparison = Comparison::new(&mesh.positions, &mesh.triangles, &truth(radius)).unwrap();
            assert!(comparison.gaps.iter().all(|gap| (gap * sign - 0.01).abs() < 3e-4), "{radius}");
            let at_vertices = comparison.gaps_at_vertices(mesh.positions.len(), &mesh.triangles);
            assert!(at_vertices.iter().flatten().all(|gap| (gap * sign - 0.01).abs() < 3e-4), "{radius}");
            assert!(at_vertices.iter().flatten().count() > at_vertices.len() / 2);
        }
    }
}
