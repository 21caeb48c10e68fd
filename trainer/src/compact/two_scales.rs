//! Regression on two scales of pose: what holds for all poses, and what holds near the training poses alone.
//!
//! A wide kernel with a large ridge learns the spatially smooth part of the targets: wrinkles seen at one pose say little about another
//! far from it, and a wrong wrinkle is worse than none. It listens to the joints of each region alone, and maybe to mirrored poses too.
//! A narrow kernel then learns what is left, and gives it back only near the poses where it was seen: near in all joints at once, for
//! folds hang on how the whole body moved, and a leg that looks the same in another dance wears others. Both are regions of the same
//! function; far from every training pose the wide part's mean remains.

use super::least_squares::conjugate_gradients;
use super::mirror::Mirror;
use super::regions::{WeightedRegion, merged, weighted_regions};
use super::regression::{COEFFICIENT_STEP, Prior, RegressionOptions, regress, rounded};
use crease::body::{Pose, Rig};
use crease::mesh::{Adjacency, Subdivision};
use crease::network::{Compact, Domain, Scratch};
use crease::pose_feature::PoseMask;
use glam::Vec3A;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The branch of one surface function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchOptions {
    /// Width of the blend between regions, in edges of level 0.
    pub blend_steps: usize,
    /// λ of the smooth part y of a field x, which minimises |y − x|² + λ/6 Σ |y_i − y_j|² over the edges; 0 takes the field as it is.
    pub smoothness: f32,
    /// Share of the smooth part that the wide regression is given. Where poses tell little, an estimate that is shrunk towards nothing is
    /// nearer than one that is not.
    pub shrinkage: f32,
    /// Whether the wide regression learns from every frame's mirror image too. Not for clothes that differ left to right.
    pub mirrored: bool,
    /// Whether places that listen to no joint, such as the head, keep the mean of what the wide regression leaves of them. It is the
    /// only thing that is said of them, and it is not smooth.
    pub keeps_rough_mean: bool,
    /// Regression of the smooth part.
    pub wide: RegressionOptions,
    /// Regression of what the wide one leaves; none where K is 0.
    pub narrow: RegressionOptions,
    /// What the narrow one learnt fades out where its greatest kernel falls from the second of these to the first; 0 and 0 let it count
    /// everywhere.
    #[serde(default)]
    pub fade: [f32; 2],
}

/// Learns a compact surface function of `level` from one field of values on its vertices for each pose, canonical frame.
///
/// `domains` are those of the levels of `subdivision`. Fails where mirrored poses are wanted of a body that is not symmetric.
pub fn regress_surface(
    level: usize,
    subdivision: &Subdivision,
    domains: &[Domain],
    rig: &Rig,
    poses: &[Pose],
    targets: &[Vec<Vec3A>],
    options: &BranchOptions,
) -> anyhow::Result<Compact> {
    let triangles = subdivision.triangles(level);
    let Domain { canonical, masks } = &domains[level];
    let adjacency = Adjacency::new(canonical.len(), triangles);
    // A region's border is as wide in metres on any level.
    let regions = weighted_regions(masks, &adjacency, options.blend_steps << (2 * level));
    let mirror = match options.mirrored {
        true => Some(Mirror::new(canonical, triangles, rig.rest_joints[0].x, &rig.joint_names)?),
        false => None,
    };
    Ok(regress_on_two_scales(level, &regions, &adjacency, poses, targets, mirror.as_ref(), options))
}

fn regress_on_two_scales(
    level: usize,
    regions: &[WeightedRegion],
    adjacency: &Adjacency,
    poses: &[Pose],
    targets: &[Vec<Vec3A>],
    mirror: Option<&Mirror>,
    options: &BranchOptions,
) -> Compact {
    let smooth = |field: &[Vec3A]| -> Vec<Vec3A> {
        smoothed(adjacency, field, options.smoothness).into_iter().map(|value| options.shrinkage * value).collect()
    };
    let mut wide_poses = poses.to_vec();
    let mut wide_targets: Vec<Vec<Vec3A>> = targets.par_iter().map(|field| smooth(field)).collect();
    if let Some(mirror) = mirror {
        wide_poses.extend(poses.iter().map(|pose| mirror.pose(pose)));
        wide_targets.par_extend(targets.par_iter().map(|field| smooth(&mirror.field(field))));
    }
    let wide = regress(level, regions, &wide_poses, &wide_targets, Prior::Mean, &options.wide);
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
    let mut merged = merged(regions);
    if !options.keeps_rough_mean {
        merged.retain(|region| region.mask != PoseMask::default());
    }
    let narrow = regress(level, &merged, poses, &left, Prior::Zero, &options.narrow);
    let fade = (options.fade[1] > 0.0).then_some(options.fade);
    joined(wide, narrow, fade)
}

/// The sum of two functions of the same level. The first one's centres begin with the second one's; to the rest the second is deaf.
/// The second one's regions recall, and fade where that is wanted.
fn joined(mut first: Compact, second: Compact, fade: Option<[f32; 2]>) -> Compact {
    let row_count = first.row_vertices.len() as u32;
    let (own, all) = (second.centre_count as usize, first.centre_count as usize);
    let first_recalling = first.regions.len();
    first.regions.extend(second.regions.into_iter().map(|mut region| {
        region.rows = (region.rows.0 + row_count, region.rows.1 + row_count);
        let rows = region.coefficient_from_kernel.chunks_exact(own);
        region.coefficient_from_kernel =
            rows.flat_map(|row| row.iter().copied().chain(std::iter::repeat_n(0.0, all - own))).collect();
        region
    }));
    first.row_vertices.extend(second.row_vertices);
    first.mean.extend(second.mean);
    first.basis.extend(second.basis);
    first.basis_step.extend(second.basis_step);
    recall(&mut first, first_recalling, own);
    for region in &mut first.regions[first_recalling..] {
        region.fade = fade.filter(|_| region.recalled_count() > 0);
    }
    first
}

/// Lets the regions from `first` on recall the poses of the first `count` centres.
fn recall(function: &mut Compact, first: usize, count: usize) {
    let centre_length = function.centres.len() / function.centre_count as usize;
    let poses = function.centres.chunks_exact(centre_length).take(count);
    let coefficients: Vec<Vec<Vec<f32>>> = poses.map(|numbers| function.coefficients(numbers)).collect();
    for (index, region) in function.regions.iter_mut().enumerate().skip(first) {
        let of_component =
            |k: usize| coefficients.iter().map(move |of_pose| rounded(of_pose[index][k], COEFFICIENT_STEP));
        region.recalled = (0..region.basis_count as usize).flat_map(of_component).collect();
    }
}

fn smoothed(adjacency: &Adjacency, field: &[Vec3A], smoothness: f32) -> Vec<Vec3A> {
    let mut smooth = field.to_vec();
    if smoothness == 0.0 {
        return smooth;
    }
    // λ/6: on a mesh of valence six, λ is that of the umbrella operator.
    let weight = smoothness / 6.0;
    let mut apply = |x: &[Vec3A], out: &mut [Vec3A]| {
        for (k, out) in out.iter_mut().enumerate() {
            *out = adjacency.of(k).iter().fold(x[k], |sum, &j| sum + weight * (x[k] - x[j as usize]));
        }
    };
    let inverse_diagonal: Vec<f32> =
        (0..field.len()).map(|k| 1.0 / (1.0 + weight * adjacency.of(k).len() as f32)).collect();
    conjugate_gradients(&mut apply, &inverse_diagonal, field, &mut smooth, 100, 1e-4);
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;
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
            smoothness: 30.0,
            shrinkage: 1.0,
            mirrored: false,
            keeps_rough_mean: true,
            wide: RegressionOptions { basis_count: 3, kernel_length: 2.0, ridge: 0.1, step: 1e-3 },
            narrow: RegressionOptions { basis_count: narrow, kernel_length: 0.5, ridge: 1e-3, step: 1e-3 },
            fade: [0.0; 2],
        };
        let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, None, &options);
        (mesh.positions, compact)
    }

    /// Σ over the rows of each vertex of their means.
    fn mean_field(compact: &Compact, count: usize) -> Vec<Vec3A> {
        let mut field = vec![Vec3A::ZERO; count];
        for (row, &vertex) in compact.row_vertices.iter().enumerate() {
            field[vertex as usize] += Vec3A::from_slice(&compact.mean[3 * row..]);
        }
        field
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
    fn what_the_narrow_part_learnt_fades_where_no_training_pose_is_near() {
        let mesh = sphere(1.0, 3);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let vertices = (0..mesh.positions.len() as u32).map(|vertex| (vertex, 1.0)).collect();
        let regions = [WeightedRegion { mask: PoseMask(0b10), vertices }];
        let poses: Vec<Pose> = (0..12).map(|t| pose(0.1 * t as f32)).collect();
        let targets: Vec<Vec<Vec3A>> = poses.iter().map(|_| target(&mesh.positions, 0.5)).collect();
        let at = |bend: f32, fade: [f32; 2]| {
            let options = BranchOptions { shrinkage: 0.0, fade, ..options(8) };
            let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, None, &options);
            rms(evaluate(&compact, mesh.positions.len(), bend).iter().map(|value| value.length()))
        };
        let fade = [0.2, 0.5];
        assert_eq!(at(0.55, fade), at(0.55, [0.0; 2]), "between training poses all of it counts");
        let beyond = at(1.6, [0.0; 2]);
        assert!(beyond > 0.01, "the kernel's far end says {beyond}");
        assert_eq!(at(1.6, fade), 0.0);
    }

    #[test]
    fn places_without_joints_keep_a_rough_mean_only_where_that_is_wanted() {
        let mesh = sphere(1.0, 3);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let halves = [PoseMask(0b10), PoseMask::default()].map(|mask| {
            let is_of_it = |&vertex: &u32| (mesh.positions[vertex as usize].x > 0.0) == (mask == PoseMask(0b10));
            let vertices = (0..mesh.positions.len() as u32).filter(is_of_it).map(|vertex| (vertex, 1.0)).collect();
            WeightedRegion { mask, vertices }
        });
        let poses: Vec<Pose> = (0..12).map(|t| pose(0.1 * t as f32)).collect();
        // Rough, and the same in all poses.
        let targets: Vec<Vec<Vec3A>> = vec![target(&mesh.positions, 0.5); 12];
        let roughness = |keeps_rough_mean: bool| {
            let options = BranchOptions { smoothness: 30.0, keeps_rough_mean, ..options(8) };
            let compact = regress_on_two_scales(0, &halves, &adjacency, &poses, &targets, None, &options);
            let values = evaluate(&compact, mesh.positions.len(), 0.5);
            let deaf = halves[1].vertices.iter().map(|&(vertex, _)| values[vertex as usize].z);
            rms(deaf.collect::<Vec<_>>().into_iter())
        };
        let (kept, left) = (roughness(true), roughness(false));
        assert!(kept > 0.9 && left < 0.15, "{kept} and {left}");
    }

    #[test]
    fn without_a_narrow_part_noise_is_never_learnt() {
        let (positions, compact) = trained(0);
        let near = evaluate(&compact, positions.len(), 0.5);
        let noise = rms(near.iter().map(|value| value.z));
        assert!(noise < 0.15, "{noise}");
        assert!(rms(target(&positions, 0.5).iter().map(|value| value.z)) > 0.9);
    }

    /// Poses of three joints, and a field that grows with the second one's bend on the side x > 0, and with the third one's on the other.
    fn sided(bends: &[(f32, f32)], positions: &[Vec3A]) -> (Vec<Pose>, Vec<Vec<Vec3A>>) {
        let pose = |&(left, right): &(f32, f32)| {
            let mut pose = Pose::rest(3);
            pose.rotations[1] = Quat::from_rotation_x(left);
            pose.rotations[2] = Quat::from_rotation_x(right);
            pose
        };
        let field = |&(left, right): &(f32, f32)| {
            positions.iter().map(|p| Vec3A::new(left * p.x.max(0.0) - right * p.x.min(0.0), 0.0, 0.0)).collect()
        };
        (bends.iter().map(pose).collect(), bends.iter().map(field).collect())
    }

    fn options(narrow: usize) -> BranchOptions {
        BranchOptions {
            blend_steps: 0,
            smoothness: 0.0,
            shrinkage: 1.0,
            mirrored: false,
            keeps_rough_mean: true,
            wide: RegressionOptions { basis_count: 6, kernel_length: 2.0, ridge: 1e-2, step: 1e-4 },
            narrow: RegressionOptions { basis_count: narrow, kernel_length: 0.4, ridge: 1e-3, step: 1e-4 },
            fade: [0.0; 2],
        }
    }

    #[test]
    fn one_side_teaches_the_other_where_mirrored_poses_are_learnt() {
        let mesh = sphere(1.0, 3);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let names = ["pelvis", "left_knee", "right_knee"].map(String::from);
        let mirror = Mirror::new(&mesh.positions, &mesh.triangles, 0.0, &names).unwrap();
        let vertices = (0..mesh.positions.len() as u32).map(|vertex| (vertex, 1.0)).collect();
        let regions = [WeightedRegion { mask: PoseMask(0b110), vertices }];
        let (poses, targets) = sided(&[(0.0, 0.0), (0.3, 0.0), (0.6, 0.0), (0.9, 0.0)], &mesh.positions);
        let (unseen, expected) = sided(&[(0.0, 0.6)], &mesh.positions);
        // Of a vector along x the mirror image points the other way.
        let expected: Vec<Vec3A> = expected[0].iter().map(|&value| -value).collect();
        let error = |mirror: Option<&Mirror>| {
            let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, mirror, &options(0));
            let mut values = vec![Vec3A::ZERO; expected.len()];
            compact.evaluate(&unseen[0], &mut Scratch::default(), &mut values);
            rms(values.iter().zip(&expected).map(|(a, b)| a.distance(*b)))
        };
        let (taught, untaught) = (error(Some(&mirror)), error(None));
        assert!(taught < 0.05 && untaught > 0.2, "{taught} {untaught}");
    }

    #[test]
    fn what_was_worn_in_one_dance_is_not_worn_in_another_that_moves_the_same_leg() {
        let mesh = sphere(1.0, 2);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let half = |mask, left: bool| WeightedRegion {
            mask: PoseMask(mask),
            vertices: (0..mesh.positions.len() as u32)
                .filter(|&v| (mesh.positions[v as usize].x > 0.0) == left)
                .map(|v| (v, 1.0))
                .collect(),
        };
        let regions = [half(0b010, true), half(0b100, false)];
        let (poses, targets) = sided(&[(0.0, 0.0), (0.2, 0.1), (0.4, 0.2), (0.6, 0.3)], &mesh.positions);
        let narrow_alone =
            BranchOptions { wide: RegressionOptions { basis_count: 0, ..options(3).wide }, ..options(3) };
        let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, None, &narrow_alone);
        let mean = mean_field(&compact, mesh.positions.len());
        let departure = |bends: (f32, f32)| {
            let (pose, _) = sided(&[bends], &mesh.positions);
            let mut values = vec![Vec3A::ZERO; mesh.positions.len()];
            compact.evaluate(&pose[0], &mut Scratch::default(), &mut values);
            rms(values.iter().zip(&mean).map(|(a, b)| a.distance(*b)))
        };
        let (same, other) = (departure((0.6, 0.3)), departure((0.6, 2.5)));
        assert!(same > 0.05 && other < 0.2 * same, "{same} {other}");
    }

    #[test]
    fn shrinking_keeps_a_share_of_what_is_smooth() {
        let mesh = sphere(1.0, 2);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let vertices = (0..mesh.positions.len() as u32).map(|vertex| (vertex, 1.0)).collect();
        let regions = [WeightedRegion { mask: PoseMask(0b110), vertices }];
        let (poses, targets) = sided(&[(0.2, 0.0), (0.2, 0.1), (0.2, 0.2)], &mesh.positions);
        let at_rest = |shrinkage: f32| {
            let options = BranchOptions { shrinkage, ..options(0) };
            let compact = regress_on_two_scales(0, &regions, &adjacency, &poses, &targets, None, &options);
            rms(mean_field(&compact, mesh.positions.len()).iter().map(|value| value.length()))
        };
        let share = at_rest(0.5) / at_rest(1.0);
        assert!((share - 0.5).abs() < 0.01, "{share}");
    }
}
