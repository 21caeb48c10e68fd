//! Kernel ridge regression of a surface function on masked poses, cut to its strongest components.
//!
//! For a region with training residuals D (frames × values, mean removed) and kernel matrix 𝒦 the prediction at a pose with kernel
//! vector κ is κᵀ(𝒦 + λI)⁻¹D. Its values at the training poses, F = 𝒦(𝒦 + λI)⁻¹D, span all it can say; their K leading right singular
//! vectors are the basis b_k, and c = κᵀ(𝒦 + λI)⁻¹D b.

use super::regions::WeightedRegion;
use crease::body::Pose;
use crease::network::{Compact, Region, matern, six_numbers};
use crease::pose_feature::PoseMask;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::Vec3A;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How the branch interpolates between training poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegressionOptions {
    /// K, basis functions for each region.
    pub basis_count: usize,
    /// Kernel length as a multiple of the training poses' rms distance from their mean, within a region's mask.
    pub kernel_length: f32,
    /// λ, relative to the kernel's value 1 at a centre.
    pub ridge: f64,
    /// Greatest step of the tables, in the function's unit. The coefficients are about 1, so this bounds the rounding of a value.
    pub step: f32,
}

/// What a region's values are before any basis function is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prior {
    /// The mean over all training poses.
    Mean,
    /// Zero; the mean only where a region listens to no joint, and so can say nothing else.
    Zero,
}

/// Learns a compact surface function from one field of values on the vertices of `level` for each training pose.
///
/// `targets[t]` are the values at pose t, canonical frame, in the function's unit.
pub fn regress(
    level: usize,
    regions: &[WeightedRegion],
    poses: &[Pose],
    targets: &[Vec<Vec3A>],
    prior: Prior,
    options: &RegressionOptions,
) -> Compact {
    let joint_count = poses[0].rotations.len();
    let centres: Vec<f32> = poses.iter().flat_map(six_numbers).collect();
    let trained: Vec<TrainedRegion> =
        regions.par_iter().map(|region| train_region(region, &centres, joint_count, targets, prior, options)).collect();
    let mut compact = Compact {
        level: level as u32,
        centre_count: poses.len() as u32,
        centres,
        regions: Vec::new(),
        row_vertices: Vec::new(),
        mean: Vec::new(),
        basis: Vec::new(),
        basis_step: Vec::new(),
    };
    for (region, trained) in regions.iter().zip(trained) {
        let first_row = compact.row_vertices.len() as u32;
        compact.row_vertices.extend(region.vertices.iter().map(|&(vertex, _)| vertex));
        compact.mean.extend(trained.mean);
        compact.basis.extend(trained.basis);
        compact.basis_step.extend(trained.basis_step);
        compact.regions.push(Region {
            mask: region.mask,
            rows: (first_row, compact.row_vertices.len() as u32),
            basis_count: trained.basis_count as u32,
            kernel_length: trained.kernel_length,
            coefficient_from_kernel: trained.coefficient_from_kernel,
            recalled: Vec::new(),
            fade: None,
        });
    }
    compact
}

struct TrainedRegion {
    kernel_length: f32,
    basis_count: usize,
    coefficient_from_kernel: Vec<f32>,
    mean: Vec<f32>,
    basis: Vec<i8>,
    basis_step: Vec<f32>,
}

fn train_region(
    region: &WeightedRegion,
    centres: &[f32],
    joint_count: usize,
    targets: &[Vec<Vec3A>],
    prior: Prior,
    options: &RegressionOptions,
) -> TrainedRegion {
    let frame_count = targets.len();
    let row_count = region.vertices.len();
    let features = masked_features(centres, joint_count, region.mask);
    let spread = rms_spread(&features, frame_count);
    let basis_count = if spread < 1e-6 { 0 } else { options.basis_count.min(frame_count - 1) };
    let mut mean = vec![Vec3A::ZERO; row_count];
    if prior == Prior::Mean || spread < 1e-6 {
        for target in targets {
            for (mean, &(vertex, _)) in mean.iter_mut().zip(&region.vertices) {
                *mean += target[vertex as usize] / frame_count as f32;
            }
        }
    }
    let weighted_mean = mean.iter().zip(&region.vertices).flat_map(|(&mean, &(_, weight))| (mean * weight).to_array());
    let kernel_length = (options.kernel_length * spread).max(1e-6);
    let mut trained = TrainedRegion {
        kernel_length,
        basis_count,
        coefficient_from_kernel: Vec::new(),
        mean: weighted_mean.map(|value| rounded(value, power_of_two(options.step))).collect(),
        basis: Vec::new(),
        basis_step: Vec::new(),
    };
    if basis_count == 0 {
        return trained;
    }

    let residual = Mat::<f64>::from_fn(frame_count, 3 * row_count, |t, i| {
        let (vertex, weight) = region.vertices[i / 3];
        f64::from(weight * (targets[t][vertex as usize] - mean[i / 3])[i % 3])
    });
    let width = features.len() / frame_count;
    let kernel = Mat::<f64>::from_fn(frame_count, frame_count, |i, j| {
        let distance_squared: f32 =
            (0..width).map(|k| (features[i * width + k] - features[j * width + k]).powi(2)).sum();
        f64::from(matern(distance_squared.sqrt() / kernel_length))
    });
    let regularised =
        Mat::from_fn(frame_count, frame_count, |i, j| kernel[(i, j)] + if i == j { options.ridge } else { 0.0 });
    let inverse = regularised
        .llt(Side::Lower)
        .expect("a Matérn kernel matrix plus a ridge is positive definite")
        .solve(Mat::<f64>::identity(frame_count, frame_count));
    let hat = &kernel * &inverse;
    let gram = &residual * residual.transpose();
    let fitted_gram = &hat * &gram * hat.transpose();
    let eigen = fitted_gram.self_adjoint_eigen(Side::Lower).expect("a finite symmetric matrix has eigenvectors");
    // Ascending eigenvalues: the strongest components are last.
    let component = |k: usize| frame_count - 1 - k;
    let scale: Vec<f64> =
        (0..basis_count).map(|k| eigen.S()[component(k)].max(0.0).sqrt() / (frame_count as f64).sqrt()).collect();
    // What the tables round away needs no coefficients.
    let weakest = WEAKEST_COMPONENT * f64::from(options.step) * (3.0 * row_count as f64).sqrt();
    let basis_count = scale.iter().take_while(|&&scale| scale > weakest).count();
    trained.basis_count = basis_count;
    let leading = Mat::<f64>::from_fn(frame_count, basis_count, |t, k| eigen.U()[(t, component(k))]);
    let frame_from_component = hat.transpose() * &leading;
    // Unit-norm basis columns are residualᵀ · frame_from_component / σ; the stored basis is times σ/√frames, so that c is about 1.
    let basis = residual.transpose() * &frame_from_component;
    let basis = Mat::<f64>::from_fn(3 * row_count, basis_count, |i, k| basis[(i, k)] / (frame_count as f64).sqrt());
    let onto_basis = &inverse * &gram * &frame_from_component;
    for k in 0..basis_count {
        let sigma_squared = (scale[k] * scale[k] * frame_count as f64).max(1e-30);
        for t in 0..frame_count {
            let coefficient = onto_basis[(t, k)] * (frame_count as f64).sqrt() / sigma_squared;
            trained.coefficient_from_kernel.push(rounded(coefficient as f32, COEFFICIENT_STEP));
        }
    }
    trained.basis_step =
        (0..basis_count).map(|k| quantisation_step((0..3 * row_count).map(|i| basis[(i, k)]), options.step)).collect();
    trained.basis = (0..row_count)
        .flat_map(|row| (0..basis_count).flat_map(move |k| (0..3).map(move |axis| (row, k, axis))))
        .map(|(row, k, axis)| quantise(basis[(3 * row + axis, k)], trained.basis_step[k]))
        .collect();
    trained
}

/// Numbers of the masked joints: (poses, masked joints × 6).
fn masked_features(centres: &[f32], joint_count: usize, mask: PoseMask) -> Vec<f32> {
    let joints: Vec<usize> = mask.joints().filter(|&joint| joint < joint_count).collect();
    centres
        .chunks_exact(6 * joint_count)
        .flat_map(|pose| joints.iter().flat_map(move |&joint| pose[6 * joint..6 * joint + 6].iter().copied()))
        .collect()
}

fn rms_spread(features: &[f32], frame_count: usize) -> f32 {
    let width = features.len() / frame_count;
    let mut sum = 0.0;
    for k in 0..width {
        let column = || (0..frame_count).map(|t| features[t * width + k]);
        let mean = column().sum::<f32>() / frame_count as f32;
        sum += column().map(|x| (x - mean).powi(2)).sum::<f32>();
    }
    (sum / frame_count as f32).sqrt()
}

/// `wanted`, so that all tables are as coarse and weak ones take few bits; more where a signed byte does not reach, but then the step
/// that leaves the least error: outliers are clipped where finer steps for the rest gain more.
fn quantisation_step(values: impl Iterator<Item = f64> + Clone, wanted: f32) -> f32 {
    let largest = values.clone().fold(0.0f64, |m, v| m.max(v.abs()));
    let wanted = f64::from(wanted);
    let error =
        |step: f64| -> f64 { values.clone().map(|v| (v - f64::from(quantise(v, step as f32)) * step).powi(2)).sum() };
    (0..8)
        .map(|i| (largest / 127.0 * 0.8f64.powi(i)).max(wanted))
        .min_by(|a, b| error(*a).total_cmp(&error(*b)))
        .unwrap_or(wanted) as f32
}

/// A component whose rms on the vertices is a smaller share of the tables' step is left out.
const WEAKEST_COMPONENT: f64 = 0.25;

/// Step of M's entries. Coefficients are about 1 and a kernel vector of a few neighbours is about 1 long, so this is a hundredth of a
/// basis function.
pub const COEFFICIENT_STEP: f32 = 1.0 / 64.0;

/// The largest power of two up to `step`: its multiples are half-precision numbers with few bits, which pack well.
fn power_of_two(step: f32) -> f32 {
    step.log2().floor().exp2()
}

/// The multiple of `step` nearest to `value`.
pub fn rounded(value: f32, step: f32) -> f32 {
    (value / step).round() * step
}

fn quantise(value: f64, step: f32) -> i8 {
    (value / f64::from(step)).round().clamp(-127.0, 127.0) as i8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::network::Scratch;
    use glam::{Quat, Vec3};

    const FRAME_COUNT: usize = 9;
    const VERTEX_COUNT: usize = 40;

    fn pose(bend: f32, twist: f32) -> Pose {
        let mut pose = Pose::rest(3);
        pose.rotations[1] = Quat::from_rotation_x(bend);
        pose.rotations[2] = Quat::from_rotation_z(twist);
        pose.translation = Vec3::X * bend;
        pose
    }

    fn training_poses() -> Vec<Pose> {
        (0..FRAME_COUNT).map(|t| pose(0.15 * t as f32, (0.8 * t as f32).sin())).collect()
    }

    /// A smooth field of vertex and of joint 1's angle.
    fn truth(bend: f32) -> Vec<Vec3A> {
        (0..VERTEX_COUNT)
            .map(|v| {
                let phase = 0.3 * v as f32;
                Vec3A::new((phase + bend).sin(), (phase - 2.0 * bend).cos(), 0.5 + bend * phase.sin())
            })
            .collect()
    }

    fn whole(mask: u32) -> WeightedRegion {
        WeightedRegion { mask: PoseMask(mask), vertices: (0..VERTEX_COUNT as u32).map(|v| (v, 1.0)).collect() }
    }

    fn options(basis_count: usize) -> RegressionOptions {
        RegressionOptions { basis_count, kernel_length: 1.0, ridge: 1e-4, step: 1e-3 }
    }

    fn train(mask: u32, basis_count: usize) -> Compact {
        let targets: Vec<Vec<Vec3A>> = (0..FRAME_COUNT).map(|t| truth(0.15 * t as f32)).collect();
        regress(0, &[whole(mask)], &training_poses(), &targets, Prior::Mean, &options(basis_count))
    }

    fn largest_error(compact: &Compact, pose: &Pose, truth: &[Vec3A]) -> f32 {
        let mut values = vec![Vec3A::ZERO; VERTEX_COUNT];
        compact.evaluate(pose, &mut Scratch::default(), &mut values);
        values.iter().zip(truth).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }

    #[test]
    fn training_poses_give_their_targets_back_and_poses_between_come_close() {
        let compact = train(0b010, FRAME_COUNT - 1);
        for (t, pose) in training_poses().iter().enumerate() {
            let error = largest_error(&compact, pose, &truth(0.15 * t as f32));
            assert!(error < 0.03, "frame {t}: {error}");
        }
        assert!(largest_error(&compact, &pose(0.525, 0.0), &truth(0.525)) < 0.06);
    }

    #[test]
    fn more_functions_leave_less_error() {
        let error = |basis_count| largest_error(&train(0b010, basis_count), &training_poses()[7], &truth(1.05));
        let errors = [1, 2, 4].map(error);
        assert!(errors[0] > 2.0 * errors[1] && errors[1] > errors[2], "{errors:?}");
    }

    #[test]
    fn a_region_without_joints_keeps_the_mean() {
        let compact = train(0, 4);
        assert!(compact.basis.is_empty());
        let mean: Vec<Vec3A> = (0..VERTEX_COUNT)
            .map(|v| (0..FRAME_COUNT).map(|t| truth(0.15 * t as f32)[v]).sum::<Vec3A>() / FRAME_COUNT as f32)
            .collect();
        assert!(largest_error(&compact, &pose(2.0, 1.0), &mean) < 1e-3, "a step of the tables");
    }

    #[test]
    fn far_from_training_the_mean_comes_back() {
        let compact = train(0b110, 4);
        let mut far = pose(0.0, 0.0);
        far.rotations[1] = Quat::from_rotation_y(std::f32::consts::PI);
        far.rotations[2] = Quat::from_rotation_x(std::f32::consts::PI);
        let mut values = vec![Vec3A::ZERO; VERTEX_COUNT];
        compact.evaluate(&far, &mut Scratch::default(), &mut values);
        for (v, value) in values.iter().enumerate() {
            let mean = Vec3A::from_slice(&compact.mean[3 * v..]);
            assert!(value.distance(mean) < 0.3, "vertex {v}: {value}, mean {mean}");
        }
    }
}
