//! The compact form: per region of the surface, value(v) = mean(v) + Σ_k c_k(θ̄) b_k(v).
//!
//! Q(v) never changes and θ̄ takes few distinct values, so the trunk (mean and basis) is tabulated once for each vertex and only the
//! branch c runs every frame, once a region. Neighbouring regions overlap with weights that sum to one (folded into the tables), so
//! that the value is continuous over the surface.
//!
//! Far from all training poses κ falls to zero and the mean remains: nearest to the truth in the mean, and as smooth as no cloth is. A
//! region that recalls gives such poses, as far as liveliness asks for it, the coefficients of the training poses nearest to them:
//! c = n M κ + liveliness f C w, where C holds the coefficients at the training poses and w_i = κ_i² / (Σ κ² + ε). What was learnt fades
//! where no training pose is near: n rises from 0 to 1 as max κ passes through the region's `fade`, and f = 1 − n. Such a region
//! takes κ to the power 4.6 ℓ in place of 2, so that w falls with the distance alike however long its kernel is: the mean of many poses
//! would be smooth again. A region that does not fade has n = 1 and f = (1 − max κ)².

use super::Scratch;
use crate::pose_feature::PoseMask;
use crate::rig::Pose;
use crate::rotation::six_numbers_from_quat;
use crate::threads::for_rows;
use glam::Vec3A;

/// A region: the rows `rows.0 .. rows.1` of the tables, one pose mask, one branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Joints that the branch listens to.
    pub mask: PoseMask,
    /// First row and one past the last.
    pub rows: (u32, u32),
    /// K: basis functions of this region; none where the mask is empty and the mean says all.
    pub basis_count: u32,
    /// Length of the kernel in the space of masked six-number rotations.
    pub kernel_length: f32,
    /// (K, centres) row-major, M: c = `coefficient_from_kernel` · κ(θ̄), κ_i = Matérn-3/2 of the distance to centre i.
    pub coefficient_from_kernel: Vec<f32>,
    /// (K, recalled centres) row-major, C: c at the first centres, which poses far from training recall; empty where they recall nothing.
    pub recalled: Vec<f32>,
    /// Greatest κ among the recalled centres up to which nothing counts that was learnt, and from which on it counts in full; none
    /// where it always counts.
    pub fade: Option<[f32; 2]>,
}

/// Trunk tables and branches.
#[derive(Clone, Debug, PartialEq)]
pub struct Compact {
    /// Level on whose vertices the tables stand.
    pub level: u32,
    /// Poses of training: (centres, joints, 6) rotations as their first two columns.
    pub centres: Vec<f32>,
    /// Number of centres.
    pub centre_count: u32,
    /// The regions; their row ranges follow each other.
    pub regions: Vec<Region>,
    /// Vertex that each row adds to.
    pub row_vertices: Vec<u32>,
    /// (rows, 3): mean, in the function's unit.
    pub mean: Vec<f32>,
    /// Region after region, (rows, K, 3): basis as small integers.
    pub basis: Vec<i8>,
    /// Region after region, (K): size of one step of `basis`, in the function's unit.
    pub basis_step: Vec<f32>,
}

impl Compact {
    /// [`Self::evaluate_lively`] without any liveliness.
    pub fn evaluate(&self, pose: &Pose, scratch: &mut Scratch, out: &mut [Vec3A]) {
        self.evaluate_lively(pose, 0.0, scratch, out);
    }

    /// See [`super::SurfaceFunction::evaluate_lively`]; `out` has one entry for each vertex of the level.
    pub fn evaluate_lively(&self, pose: &Pose, liveliness: f32, scratch: &mut Scratch, out: &mut [Vec3A]) {
        let Scratch { pose_numbers, kernel, recall, factors, row_values, .. } = scratch;
        pose_numbers.clear();
        pose_numbers.extend(six_numbers(pose));
        kernel.resize(self.centre_count as usize, 0.0);
        factors.clear();
        let mut steps = self.basis_step.as_slice();
        for region in &self.regions {
            let region_steps = steps.split_off(..region.basis_count as usize).unwrap_or_default();
            let mut learnt = 1.0;
            if !region_steps.is_empty() {
                region.kernel(&self.centres, pose_numbers, kernel);
                let shares = region.shares(kernel);
                learnt = shares.learnt;
                region.recall_weights(kernel, liveliness * shares.recalled, recall);
            }
            for (k, &step) in region_steps.iter().enumerate() {
                let coefficient = learnt * region.coefficient(k, kernel) + weighted(&region.recalled, k, recall);
                factors.extend([step * coefficient; 3]);
            }
        }
        row_values.resize(self.row_vertices.len(), Vec3A::ZERO);
        for_rows(row_values, |first, values| self.put_rows(first, factors, values));
        out.fill(Vec3A::ZERO);
        for (&vertex, value) in self.row_vertices.iter().zip(row_values) {
            out[vertex as usize] += *value;
        }
    }

    /// What the rows from `first` on add to their vertices. `factors` are those of all regions, three for each basis function.
    fn put_rows(&self, first: usize, mut factors: &[f32], values: &mut [Vec3A]) {
        let mut basis = self.basis.as_slice();
        for region in &self.regions {
            let rows = region.rows.0 as usize..region.rows.1 as usize;
            let row_length = 3 * region.basis_count as usize;
            let region_factors = factors.split_off(..row_length).unwrap_or_default();
            let region_basis = basis.split_off(..row_length * rows.len()).unwrap_or_default();
            for row in rows.start.max(first)..rows.end.min(first + values.len()) {
                let mean = Vec3A::from_slice(&self.mean[3 * row..]);
                let basis = &region_basis[row_length * (row - rows.start)..][..row_length];
                values[row - first] = mean + weighted_sum(basis, region_factors);
            }
        }
    }
}

impl Compact {
    /// c of each region, without any liveliness, at a pose that is given as [`six_numbers`]; the training poses are the rows of `centres`.
    pub fn coefficients(&self, pose_numbers: &[f32]) -> Vec<Vec<f32>> {
        let mut kernel = vec![0.0; self.centre_count as usize];
        let of_region = |region: &Region| {
            region.kernel(&self.centres, pose_numbers, &mut kernel);
            let learnt = region.shares(&kernel).learnt;
            (0..region.basis_count as usize).map(|k| learnt * region.coefficient(k, &kernel)).collect()
        };
        self.regions.iter().map(of_region).collect()
    }
}

/// A pose as centres are: (joints, 6), the first two columns of each rotation.
pub fn six_numbers(pose: &Pose) -> impl Iterator<Item = f32> {
    pose.rotations.iter().flat_map(|&rotation| six_numbers_from_quat(rotation))
}

impl Region {
    /// κ: Matérn-3/2 of the distance between the masked rotations of a pose and of each centre.
    fn kernel(&self, centres: &[f32], pose_numbers: &[f32], kernel: &mut [f32]) {
        let centre_length = pose_numbers.len();
        kernel.fill(0.0);
        for joint in self.mask.joints() {
            let numbers = &pose_numbers[6 * joint..6 * joint + 6];
            for (squared, centre) in kernel.iter_mut().zip(centres.chunks_exact(centre_length)) {
                let centre = &centre[6 * joint..6 * joint + 6];
                *squared += numbers.iter().zip(centre).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
            }
        }
        for value in kernel {
            *value = matern(value.sqrt() / self.kernel_length);
        }
    }

    /// (M κ)_k.
    fn coefficient(&self, k: usize, kernel: &[f32]) -> f32 {
        weighted(&self.coefficient_from_kernel, k, kernel)
    }

    /// How many centres are recalled: the first ones.
    pub fn recalled_count(&self) -> usize {
        self.recalled.len() / (self.basis_count as usize).max(1)
    }

    /// How much of what was learnt counts, n, and how much a lively pose recalls, f.
    fn shares(&self, kernel: &[f32]) -> Shares {
        let recalled = &kernel[..self.recalled_count()];
        let largest = recalled.iter().fold(0.0f32, |largest, &value| largest.max(value));
        match self.fade {
            None => Shares { learnt: 1.0, recalled: (1.0 - largest).powi(2) },
            Some([nothing, full]) => {
                let t = ((largest - nothing) / (full - nothing)).clamp(0.0, 1.0);
                let learnt = t * t * (3.0 - 2.0 * t);
                Shares { learnt, recalled: 1.0 - learnt }
            }
        }
    }

    /// `share` · w; nothing where there is nothing to recall.
    fn recall_weights(&self, kernel: &[f32], share: f32, weights: &mut Vec<f32>) {
        let recalled = if share == 0.0 { 0 } else { self.recalled_count() };
        let kernel = &kernel[..recalled];
        let power = if self.fade.is_some() { RECALL_POWER * self.kernel_length } else { 2.0 };
        weights.clear();
        weights.extend(kernel.iter().map(|&value| value.powf(power)));
        let scale = share / (weights.iter().sum::<f32>() + LEAST_RECALL);
        weights.iter_mut().for_each(|weight| *weight *= scale);
    }
}

/// See [`Region::shares`].
struct Shares {
    learnt: f32,
    recalled: f32,
}

/// Power of κ in w over the kernel's length: far away w falls by e with every eighth of the distance's unit.
const RECALL_POWER: f32 = 4.6;

/// ε: poses whose sum of powers is no more than this recall little, so that nothing is divided by nothing.
const LEAST_RECALL: f32 = 1e-30;

/// Σ_i of row `k` of a matrix times `weights`, which are as long as its rows.
fn weighted(matrix: &[f32], k: usize, weights: &[f32]) -> f32 {
    let row = &matrix[k * weights.len()..][..weights.len()];
    row.iter().zip(weights).map(|(a, b)| a * b).sum()
}

/// Matérn-3/2 kernel of a distance in units of the kernel's length; 1 at 0.
pub fn matern(distance: f32) -> f32 {
    let ratio = 3f32.sqrt() * distance;
    (1.0 + ratio) * (-ratio).exp()
}

/// Σ_k of three consecutive entries of `basis` times their factors (one factor an entry).
///
/// Twelve sums side by side: a multiple of three axes and of four lanes, so that the compiler makes vector instructions of it.
fn weighted_sum(basis: &[i8], factors: &[f32]) -> Vec3A {
    let (basis, basis_rest) = basis.as_chunks::<12>();
    let (factors, factors_rest) = factors.as_chunks::<12>();
    let mut sums = [0.0f32; 12];
    for (basis, factors) in basis.iter().zip(factors) {
        for i in 0..12 {
            sums[i] += f32::from(basis[i]) * factors[i];
        }
    }
    for (i, (&basis, &factor)) in basis_rest.iter().zip(factors_rest).enumerate() {
        sums[i] += f32::from(basis) * factor;
    }
    Vec3A::from_array([0, 1, 2].map(|axis| sums[axis] + sums[axis + 3] + sums[axis + 6] + sums[axis + 9]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    /// Two overlapping regions over four vertices, three joints, two centres, five basis functions.
    fn example() -> Compact {
        let region = |mask, rows, basis_count: u32, scale: f32| Region {
            mask: PoseMask(mask),
            rows,
            basis_count,
            kernel_length: 0.8,
            coefficient_from_kernel: (0..2 * basis_count).map(|i| scale * (i as f32 - 4.0)).collect(),
            recalled: Vec::new(),
            fade: None,
        };
        let centre =
            |angle: f32| [0.0, angle, -angle].into_iter().flat_map(|a| six_numbers_from_quat(Quat::from_rotation_x(a)));
        Compact {
            level: 0,
            centres: centre(0.2).chain(centre(1.0)).collect(),
            centre_count: 2,
            regions: vec![region(0b010, (0, 3), 5, 0.3), region(0, (3, 3), 0, 0.0), region(0b110, (3, 5), 4, 0.5)],
            row_vertices: vec![0, 1, 2, 2, 3],
            mean: (0..15).map(|i| 0.01 * i as f32).collect(),
            basis: (0..69).map(|i| (i * 37 % 255 - 127) as i8).collect(),
            basis_step: (0..9).map(|i| 0.001 * (1 + i) as f32).collect(),
        }
    }

    fn pose(second: f32, third: f32) -> Pose {
        Pose {
            rotations: vec![Quat::from_rotation_y(0.4), Quat::from_rotation_x(second), Quat::from_rotation_z(third)],
            translation: Vec3::ZERO,
        }
    }

    /// value(v) = Σ over rows of v: mean + Σ_k c_k step_k b_k, straight from the definitions in f64.
    fn naive(compact: &Compact, pose: &Pose) -> Vec<[f64; 3]> {
        let (mut first_step, mut first_basis) = (0, 0);
        let mut out = vec![[0.0; 3]; 4];
        for region in &compact.regions {
            let k_count = region.basis_count as usize;
            let kernel: Vec<f64> = (0..compact.centre_count as usize)
                .map(|centre| {
                    let mut squared = 0.0;
                    for joint in region.mask.joints() {
                        let numbers = six_numbers_from_quat(pose.rotations[joint]);
                        for i in 0..6 {
                            let difference = numbers[i] - compact.centres[(centre * 3 + joint) * 6 + i];
                            squared += f64::from(difference).powi(2);
                        }
                    }
                    let ratio = (3.0 * squared).sqrt() / f64::from(region.kernel_length);
                    (1.0 + ratio) * (-ratio).exp()
                })
                .collect();
            for row in region.rows.0 as usize..region.rows.1 as usize {
                for axis in 0..3 {
                    let mut value = f64::from(compact.mean[3 * row + axis]);
                    for k in 0..k_count {
                        let mut c = 0.0;
                        for (i, kernel) in kernel.iter().enumerate() {
                            c += f64::from(region.coefficient_from_kernel[k * 2 + i]) * kernel;
                        }
                        value += c
                            * f64::from(compact.basis_step[first_step + k])
                            * f64::from(compact.basis[first_basis + 3 * k + axis]);
                    }
                    out[compact.row_vertices[row] as usize][axis] += value;
                }
                first_basis += 3 * k_count;
            }
            first_step += k_count;
        }
        out
    }

    #[test]
    fn agrees_with_the_definition() {
        let compact = example();
        for pose in [pose(0.0, 0.0), pose(0.2, -0.2), pose(1.3, 2.0)] {
            let mut out = vec![Vec3A::NAN; 4];
            compact.evaluate(&pose, &mut Scratch::default(), &mut out);
            for (value, expected) in out.iter().zip(naive(&compact, &pose)) {
                for axis in 0..3 {
                    assert!((f64::from(value[axis]) - expected[axis]).abs() < 1e-5, "{value} for {expected:?}");
                }
            }
        }
    }

    /// The example with another kernel length; its regions recall both centres.
    fn recalling(kernel_length: f32) -> Compact {
        let mut compact = example();
        compact.regions.iter_mut().for_each(|region| region.kernel_length = kernel_length);
        let of_centres: Vec<_> =
            compact.centres.chunks_exact(18).map(|numbers| compact.coefficients(numbers)).collect();
        for (r, region) in compact.regions.iter_mut().enumerate() {
            region.recalled =
                (0..region.basis_count as usize).flat_map(|k| of_centres.iter().map(move |c| c[r][k])).collect();
        }
        compact
    }

    /// A pose of the kind that the example's centres are.
    fn turned(angle: f32) -> Pose {
        Pose { rotations: [0.0, angle, -angle].map(Quat::from_rotation_x).to_vec(), translation: Vec3::ZERO }
    }

    fn evaluate(compact: &Compact, pose: &Pose, liveliness: f32) -> Vec<Vec3A> {
        let mut out = vec![Vec3A::NAN; 4];
        compact.evaluate_lively(pose, liveliness, &mut Scratch::default(), &mut out);
        out
    }

    /// The greatest distance between two fields.
    fn apart(a: &[Vec3A], b: &[Vec3A]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }

    #[test]
    fn a_lively_function_recalls_the_nearest_training_pose() {
        let compact = recalling(0.8);
        let again = apart(&evaluate(&compact, &turned(1.0), 1.0), &evaluate(&compact, &turned(1.0), 0.0));
        assert!(again < 1e-4, "a training pose is as it was learnt: {again}");
        // So far that κ is nearly nothing for either centre, but nearer to the second one.
        let far = recalling(0.15);
        let learnt = evaluate(&far, &turned(1.0), 0.0);
        let departure = |liveliness: f32| apart(&evaluate(&far, &turned(2.0), liveliness), &learnt);
        let (calm, half, lively) = (departure(0.0), departure(0.5), departure(1.0));
        assert!(lively < 0.05 * calm && (half / calm - 0.5).abs() < 0.05, "{calm} {half} {lively}");
    }

    #[test]
    fn what_was_learnt_fades_between_its_bounds_and_is_recalled_instead() {
        let whole = recalling(0.8);
        let mut fading = whole.clone();
        fading.regions.iter_mut().for_each(|region| region.fade = Some([0.2, 0.6]));
        let mut means = whole.clone();
        means.basis.fill(0);
        let near = turned(1.05);
        assert_eq!(
            evaluate(&fading, &near, 1.0),
            evaluate(&whole, &near, 0.0),
            "all of it counts, nothing is recalled"
        );
        let far = turned(2.8);
        assert!(apart(&evaluate(&whole, &far, 0.0), &evaluate(&means, &far, 0.0)) > 1e-3, "the kernel's far end");
        assert_eq!(evaluate(&fading, &far, 0.0), evaluate(&means, &far, 0.0), "nothing of it counts");
        let coefficients = fading.coefficients(&six_numbers(&far).collect::<Vec<_>>());
        assert!(coefficients.iter().flatten().all(|&c| c == 0.0), "{coefficients:?}");
        let learnt = evaluate(&whole, &turned(1.0), 0.0);
        let (calm, lively) =
            (apart(&evaluate(&fading, &far, 0.0), &learnt), apart(&evaluate(&fading, &far, 1.0), &learnt));
        assert!(lively < 0.2 * calm, "{lively} of {calm}");
        // Between the bounds it is between the two, and no step is seen.
        let steps: Vec<_> = (0..200).map(|i| evaluate(&fading, &turned(1.0 + 0.01 * i as f32), 0.0)).collect();
        let greatest = steps.windows(2).map(|pair| apart(&pair[0], &pair[1])).fold(0.0, f32::max);
        assert!(greatest < 0.05 * apart(&steps[0], &steps[199]), "{greatest}");
    }

    #[test]
    fn what_is_endlessly_far_is_finite() {
        let compact = recalling(1e-3);
        let mut out = vec![Vec3A::NAN; 4];
        compact.evaluate_lively(&pose(2.0, 2.0), 1.0, &mut Scratch::default(), &mut out);
        assert!(out.iter().all(|value| value.is_finite()), "{out:?}");
    }

    #[test]
    fn a_region_listens_to_its_mask_alone() {
        let compact = example();
        let evaluate = |pose: &Pose| {
            let mut out = vec![Vec3A::ZERO; 4];
            compact.evaluate(pose, &mut Scratch::default(), &mut out);
            out
        };
        let (before, after) = (evaluate(&pose(0.5, 0.0)), evaluate(&pose(0.5, 0.9)));
        assert_eq!(before[..2], after[..2], "rows of the first region only");
        assert_ne!(before[2], after[2], "a row of each");
        assert_ne!(before[3], after[3], "a row of the second region");
    }
}
