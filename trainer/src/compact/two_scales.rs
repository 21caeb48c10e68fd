//! Regression on two scales of pose: what holds for all poses, and what holds near the training poses alone.
//!
//! A wide kernel with a large ridge learns the spatially smooth part of the targets: wrinkles seen at one pose say little about another
//! far from it, and a wrong wrinkle is worse than none. A narrow kernel then learns what is left, and gives it back only near the
//! poses where it was seen. Both are regions of the same function; far from every training pose the wide part's mean remains.

use super::least_squares::conjugate_gradients;
use super::regions::WeightedRegion;
use super::regression::{Prior, RegressionOptions, regress};
use crease::body::Pose;
use crease::laplacian::{apply_topological, apply_topological_transposed, reciprocal_valences};
use crease::mesh::Adjacency;
use crease::network::{Compact, Scratch};
use glam::Vec3A;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The branch of one surface function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchOptions {
    /// Width of the blend between regions, in edges of level 0.
    pub blend_steps: usize,
    /// λ of the smooth part y of a field x, which minimises |y − x|² + λ |L y|²; 0 takes the field as it is.
    pub smoothness: f32,
    /// Regression of the smooth part.
    pub wide: RegressionOptions,
    /// Regression of what the wide one leaves; none where K is 0.
    pub narrow: RegressionOptions,
}

/// Learns a compact surface function; arguments as of [`regress`], `adjacency` that of `level`.
pub fn regress_on_two_scales(
    level: usize,
    regions: &[WeightedRegion],
    adjacency: &Adjacency,
    poses: &[Pose],
    targets: &[Vec<Vec3A>],
    options: &BranchOptions,
) -> Compact {
    let smooth: Vec<Vec<Vec3A>> =
        targets.par_iter().map(|field| smoothed(adjacency, field, options.smoothness)).collect();
    let wide = regress(level, regions, poses, &smooth, Prior::Mean, &options.wide);
    if options.narrow.basis_count == 0 {
        return wide;
    }
    let left: Vec<Vec<Vec3A>> = (targets.par_iter().zip(poses))
        .map(|(target, pose)| {
            let mut values = vec![Vec3A::ZERO; target.len()];
            wide.evaluate(pose, &mut Scratch::default(), &mut values);
            target.iter().zip(&values).map(|(&target, &value)| target - value).collect()
        })
        .collect();
    joined(wide, regress(level, regions, poses, &left, Prior::Zero, &options.narrow))
}

/// The sum of two functions of the same level and centres.
fn joined(mut first: Compact, second: Compact) -> Compact {
    let row_count = first.row_vertices.len() as u32;
    first.regions.extend(second.regions.into_iter().map(|mut region| {
        region.rows = (region.rows.0 + row_count, region.rows.1 + row_count);
        region
    }));
    first.row_vertices.extend(second.row_vertices);
    first.mean.extend(second.mean);
    first.basis.extend(second.basis);
    first.basis_step.extend(second.basis_step);
    first
}

fn smoothed(adjacency: &Adjacency, field: &[Vec3A], smoothness: f32) -> Vec<Vec3A> {
    let mut smooth = field.to_vec();
    if smoothness == 0.0 {
        return smooth;
    }
    let reciprocal_valences = reciprocal_valences(adjacency);
    let mut once = vec![Vec3A::ZERO; field.len()];
    let mut apply = |x: &[Vec3A], out: &mut [Vec3A]| {
        apply_topological(adjacency, x, &mut once);
        apply_topological_transposed(adjacency, &reciprocal_valences, &once, out);
        out.iter_mut().zip(x).for_each(|(out, x)| *out = *out * smoothness + *x);
    };
    // L's own diagonal is 1, and that of LᵀL a little more.
    let inverse_diagonal = vec![1.0 / (1.0 + 1.2 * smoothness); field.len()];
    conjugate_gradients(&mut apply, &inverse_diagonal, field, &mut smooth, 100, 1e-4);
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;
    use crease::pose_feature::PoseMask;
    use glam::Quat;

    fn pose(bend: f32) -> Pose {
        let mut pose = Pose::rest(2);
        pose.rotations[1] = Quat::from_rotation_x(bend);
        pose
    }

    /// On a sphere, level 0: a constant along x that all poses share, a wave over the surface along y that grows with the bend, and noise
    /// along z that comes and goes.
    fn target(positions: &[Vec3A], bend: f32) -> Vec<Vec3A> {
        let noise = |k: usize| if (k as u32).wrapping_mul(2_654_435_761) >> 16 & 1 == 0 { 1.0 } else { -1.0 };
        positions.iter().enumerate().map(|(k, p)| Vec3A::new(1.0, bend * p.x, (3.0 * bend).sin() * noise(k))).collect()
    }

    fn trained(narrow: usize) -> (Vec<Vec3A>, Compact) {
        let mesh = sphere(1.0, 3);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let vertices = (0..mesh.positions.len() as u32).map(|vertex| (vertex, 1.0)).collect();
        let regions = [WeightedRegion { mask: PoseMask(0b10), vertices }];
        let poses: Vec<Pose> = (0..12).map(|t| pose(0.1 * t as f32)).collect();
        let targets: Vec<Vec<Vec3A>> = (0..12).map(|t| target(&mesh.positions, 0.1 * t as f32)).collect();
        let options = BranchOptions {
            blend_steps: 0,
            smoothness: 1000.0,
            wide: RegressionOptions { basis_count: 3, kernel_length: 2.0, ridge: 0.1, step: 1e-3 },
            narrow: RegressionOptions { basis_count: narrow, kernel_length: 0.5, ridge: 1e-3, step: 1e-3 },
        };
        let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, &options);
        (mesh.positions, compact)
    }

    fn evaluate(compact: &Compact, count: usize, bend: f32) -> Vec<Vec3A> {
        let mut values = vec![Vec3A::ZERO; count];
        compact.evaluate(&pose(bend), &mut Scratch::default(), &mut values);
        values
    }

    fn rms(values: impl ExactSizeIterator<Item = f32>) -> f32 {
        let count = values.len() as f32;
        (values.map(|value| value * value).sum::<f32>() / count).sqrt()
    }

    #[test]
    fn training_poses_come_back_whole_and_far_poses_keep_the_smooth_part_alone() {
        let (positions, compact) = trained(8);
        let near = evaluate(&compact, positions.len(), 0.5);
        let error = rms(near.iter().zip(target(&positions, 0.5)).map(|(a, b)| a.distance(b)));
        assert!(error < 0.05, "{error}");
        let far = evaluate(&compact, positions.len(), std::f32::consts::PI);
        let shared = rms(far.iter().map(|value| value.x - 1.0));
        assert!(shared < 0.02, "what all poses share stays: {shared}");
        let noise = rms(far.iter().map(|value| value.z));
        assert!(noise < 0.15, "the noise is gone: {noise}");
    }

    #[test]
    fn without_a_narrow_part_noise_is_never_learnt() {
        let (positions, compact) = trained(0);
        let near = evaluate(&compact, positions.len(), 0.5);
        let noise = rms(near.iter().map(|value| value.z));
        assert!(noise < 0.15, "{noise}");
        assert!(rms(target(&positions, 0.5).iter().map(|value| value.z)) > 0.9);
    }
}
