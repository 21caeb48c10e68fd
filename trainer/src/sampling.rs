//! Seeded random samples.

use crate::closest::SurfacePoint;
use crease::mesh::Triangle;
use glam::Vec3A;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The generator used everywhere in training and evaluation: the same numbers on every machine.
pub fn generator(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// `count` points spread over a mesh with equal probability for equal area.
pub fn area_uniform(positions: &[Vec3A], triangles: &[Triangle], count: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut total = 0.0;
    let cumulative: Vec<f64> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            total += f64::from((b - a).cross(c - a).length());
            total
        })
        .collect();
    let mut generator = generator(seed);
    (0..count)
        .map(|_| {
            let area = generator.random::<f64>() * total;
            let triangle = cumulative.partition_point(|&end| end <= area).min(triangles.len() - 1);
            let (r, s): (f32, f32) = (generator.random(), generator.random());
            let root = r.sqrt();
            SurfacePoint { triangle: triangle as u32, barycentric: [1.0 - root, root * (1.0 - s), root * s] }
        })
        .collect()
}

/// `count` points in the cube of half width `half_width` metres about the origin.
#[cfg(test)]
pub fn random_points(count: usize, half_width: f32, seed: u64) -> Vec<Vec3A> {
    let mut generator = generator(seed);
    (0..count)
        .map(|_| Vec3A::from_array(std::array::from_fn(|_| generator.random_range(-half_width..half_width))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_area() {
        let positions = [Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::new(4.0, 0.0, 0.0), Vec3A::new(0.0, 4.0, 0.0)];
        let triangles = [[0, 1, 2], [1, 3, 4], [1, 4, 2], [0, 0, 1]];
        let samples = area_uniform(&positions, &triangles, 40_000, 3);
        let inside = samples.iter().filter(|sample| sample.triangle == 0).count() as f32 / 40_000.0;
        assert!((inside - 1.0 / 16.0).abs() < 0.005, "a sixteenth of the area got {inside}");
        let centroid: Vec3A =
            samples.iter().map(|sample| sample.interpolate(&triangles, &positions)).sum::<Vec3A>() / 40_000.0;
        assert!(centroid.distance(Vec3A::new(4.0 / 3.0, 4.0 / 3.0, 0.0)) < 0.02, "{centroid}");
        assert!(samples.iter().all(|sample| sample.triangle != 3), "a triangle without area was sampled");
    }

    #[test]
    fn a_seed_decides() {
        let positions = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
        let sample = |seed| area_uniform(&positions, &[[0, 1, 2]], 10, seed);
        assert_eq!(sample(1), sample(1));
        assert_ne!(sample(1), sample(2));
    }
}
