//! How far the coefficients of a compact function go, in training and on other motions.

use crease::body::Pose;
use crease::network::{Compact, six_numbers};

/// The largest magnitude of any coefficient of each region.
pub type Ranges = Vec<f32>;

/// Over the training poses themselves.
pub fn training_ranges(function: &Compact) -> Ranges {
    let length = function.centres.len() / (function.centre_count as usize).max(1);
    ranges(function, function.centres.chunks_exact(length.max(1)).map(<[f32]>::to_vec))
}

/// Over `poses`.
pub fn motion_ranges(function: &Compact, poses: &[Pose]) -> Ranges {
    ranges(function, poses.iter().map(|pose| six_numbers(pose).collect()))
}

/// The largest ratio of `found` to `training` over the regions that have coefficients.
pub fn largest_ratio(found: &[f32], training: &[f32]) -> f32 {
    found.iter().zip(training).filter(|(_, training)| **training > 0.0).map(|(a, b)| a / b).fold(0.0, f32::max)
}

fn ranges(function: &Compact, poses: impl Iterator<Item = Vec<f32>>) -> Ranges {
    let mut largest = vec![0.0f32; function.regions.len()];
    for numbers in poses {
        for (largest, coefficients) in largest.iter_mut().zip(function.coefficients(&numbers)) {
            *largest = coefficients.iter().fold(*largest, |m, c| m.max(c.abs()));
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{bent_pose, compact_avatar};
    use crease::network::SurfaceFunction;
    use glam::Quat;
    use rand::{RngExt, SeedableRng};

    fn function() -> Compact {
        match compact_avatar().laplacian {
            SurfaceFunction::Compact(compact) => compact,
            SurfaceFunction::Mlp(_) => panic!("the fixture has tables"),
        }
    }

    /// c = M κ and each entry of κ lies in 0 .. 1, so no pose whatever takes c beyond the sum of M's row.
    fn bounds(function: &Compact) -> Ranges {
        let row_sum = |row: &[f32]| row.iter().map(|value| value.abs()).sum::<f32>();
        let centres = function.centre_count as usize;
        let rows = function.regions.iter().map(|region| region.coefficient_from_kernel.chunks_exact(centres));
        rows.map(|rows| rows.map(row_sum).fold(0.0, f32::max)).collect()
    }

    #[test]
    fn random_poses_stay_within_the_bound_and_near_the_training_range() {
        let function = function();
        let mut random = rand_pcg::Pcg32::seed_from_u64(3);
        let poses: Vec<Pose> = (0..500)
            .map(|_| {
                let mut pose = Pose::rest(24);
                for rotation in &mut pose.rotations {
                    let [x, y, z, w] = [0; 4].map(|_| random.random_range(-1.0f32..1.0));
                    *rotation = Quat::from_xyzw(x, y, z, w + 1e-3).normalize();
                }
                pose
            })
            .collect();
        let (found, training) = (motion_ranges(&function, &poses), training_ranges(&function));
        for ((found, bound), region) in found.iter().zip(bounds(&function)).zip(&function.regions) {
            assert!(*found <= bound, "mask {}: {found}", region.mask.0);
        }
        let ratio = largest_ratio(&found, &training);
        assert!(ratio > 0.0 && ratio < 1.5, "{ratio}");
    }

    #[test]
    fn the_training_range_is_what_the_training_poses_reach() {
        let function = function();
        let poses = [Pose::rest(24), bent_pose()];
        let found = motion_ranges(&function, &poses);
        for (a, b) in found.iter().zip(training_ranges(&function)) {
            assert!((a - b).abs() < 1e-5);
        }
        assert!((largest_ratio(&[0.5, 3.0], &[1.0, 2.0]) - 1.5).abs() < 1e-6);
        assert_eq!(largest_ratio(&[7.0], &[0.0]), 0.0, "a region that has no coefficients");
    }
}
