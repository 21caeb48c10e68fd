//! Gradient descent on pairs of a surface point in a pose and the value wanted there.

use super::descent::Descent;
use super::features::Features;
use super::network::Network;
use super::training_device;
use crate::checkpoint::{Fingerprint, Keep};
use crate::context::TrainContext;
use crate::options::NetworkOptions;
use crate::targets::Target;
use anyhow::ensure;
use burn::tensor::{Device, Tensor, TensorData};
use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::network::Mlp;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// Training pairs of all frames.
#[derive(Default)]
pub(super) struct Pairs {
    targets: Vec<Target>,
    /// Index into `poses` for each target.
    frames: Vec<u32>,
    poses: Vec<Vec<[f32; 3]>>,
}

/// What [`Pairs::regress`] trains, and how; see [`Descent`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Regression<'a> {
    pub name: &'a str,
    pub title: &'a str,
    /// Subdivision level of the network's vertices.
    pub level: usize,
    pub network: &'a NetworkOptions,
    pub seed: u64,
    pub rate: fn(f64) -> f64,
}

impl Pairs {
    /// Appends the targets of one frame.
    pub fn push(&mut self, pose: &Pose, targets: impl IntoIterator<Item = Target>) {
        self.targets.extend(targets);
        self.frames.resize(self.targets.len(), self.poses.len() as u32);
        self.poses.push(Features::axis_angles(pose));
    }

    /// The trained network, and the mean energy (of standardised targets) over each epoch.
    pub fn regress(&self, context: &TrainContext, regression: Regression<'_>) -> anyhow::Result<(Mlp, Vec<f32>)> {
        let Regression { name, title, level, network, seed, rate } = regression;
        let device = training_device(context.options.device)?;
        let encoding = PositionalEncoding { frequency_count: context.options.frequency_count };
        let features = Features::new(encoding, context.rig.parents.len());
        let scale = root_mean_square(&self.targets);
        ensure!(scale > 0.0, "{title}: expected points of the scans near the base mesh, found none");

        let descent = Descent {
            name,
            title,
            inputs: self.inputs(context, name),
            options: network,
            input_count: features.length(),
            seed,
            item_count: self.targets.len(),
            items_a_step: context.options.laplacian.points_a_step,
            rate,
        };
        let step = |network: &Network, batch: &[u32], _: &mut Pcg64Mcg| {
            Ok(energy(network.forward(self.input(batch, features, &device)), &self.of(batch), scale))
        };
        let (network, history) = descent.run(context, &device, step, |mean| format!("energy {mean:.4}"))?;
        Ok((network.export(level, encoding, scale), history))
    }

    /// Everything that training on them depends on.
    fn inputs(&self, context: &TrainContext, name: &str) -> Fingerprint {
        let ingredients = context.ingredients(name).value(&(&self.frames, &self.poses));
        ingredients.bytes(&self.targets.to_bytes()).finish()
    }

    fn of(&self, batch: &[u32]) -> Vec<&Target> {
        batch.iter().map(|&index| &self.targets[index as usize]).collect()
    }

    fn input(&self, batch: &[u32], features: Features, device: &Device) -> Tensor<2> {
        let length = features.length();
        let mut input = vec![0.0; batch.len() * length];
        input.par_chunks_exact_mut(length).zip(batch).for_each(|(row, &index)| {
            let target = &self.targets[index as usize];
            let pose = &self.poses[self.frames[index as usize] as usize];
            features.fill(target.canonical, target.mask, pose, row);
        });
        Tensor::from_data(TensorData::new(input, [batch.len(), length]), device)
    }
}

/// The mean of μ |prediction − value / `scale`|² over a batch (E_l of paper Eq. PDD).
///
/// Values are in the canonical frame: where the blended matrix is a rotation, as it is away from joints, the length of the difference is that
/// in the posed frame.
fn energy(prediction: Tensor<2>, batch: &[&Target], scale: f32) -> Tensor<1> {
    let device = prediction.device();
    let count = batch.len();
    let wanted: Vec<f32> = batch.iter().flat_map(|target| (target.value / scale).to_array()).collect();
    let wanted = Tensor::<2>::from_data(TensorData::new(wanted, [count, 3]), &device);
    let weights: Vec<f32> = batch.iter().map(|target| target.weight / count as f32).collect();
    let weights = Tensor::<2>::from_data(TensorData::new(weights, [count, 1]), &device);
    ((prediction - wanted).square() * weights).sum()
}

/// Of the components of the values.
fn root_mean_square(targets: &[Target]) -> f32 {
    let sum: f64 = targets.iter().map(|target| f64::from(target.value.length_squared())).sum();
    (sum / (3 * targets.len()).max(1) as f64).sqrt() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ComputeDevice;
    use crate::plain::{numbers, scalar};
    use crate::sampling::random_points;
    use crease::pose_feature::PoseMask;
    use glam::Vec3A;

    fn targets() -> Vec<Target> {
        let target = |(i, value): (usize, Vec3A)| Target {
            canonical: Vec3A::ZERO,
            mask: PoseMask(0),
            value: value * 10.0,
            weight: 0.5 + i as f32,
        };
        random_points(4, 1.0, 1).into_iter().enumerate().map(target).collect()
    }

    #[test]
    fn the_energy_is_the_weighted_mean_of_squares_and_its_gradient_agrees() {
        let targets = targets();
        let batch: Vec<&Target> = targets.iter().collect();
        let device = training_device(ComputeDevice::Cpu).unwrap();
        let prediction = random_points(4, 1.0, 2);
        let value = |prediction: &[Vec3A]| {
            let flat: Vec<f32> = prediction.iter().flat_map(|p| p.to_array()).collect();
            let tensor = Tensor::<2>::from_data(TensorData::new(flat, [4, 3]), &device).require_grad();
            let total = energy(tensor.clone(), &batch, 10.0);
            let gradients = total.backward();
            (scalar(total), numbers(tensor.grad(&gradients).unwrap()))
        };
        let (total, gradient) = value(&prediction);
        let expected: f32 = prediction
            .iter()
            .zip(&targets)
            .map(|(p, t)| t.weight * (*p - t.value / 10.0).length_squared())
            .sum::<f32>()
            / 4.0;
        assert!((total - expected).abs() < 1e-5);
        for (row, axis) in [(0, 0), (1, 2), (3, 1)] {
            let [below, above] = [-1e-2, 1e-2].map(|step| {
                let mut moved = prediction.clone();
                moved[row][axis] += step;
                value(&moved).0
            });
            let difference = (above - below) / 2e-2;
            assert!((gradient[3 * row + axis] - difference).abs() < 1e-3, "{difference}");
        }
    }

    #[test]
    fn the_scale_standardises() {
        let targets = targets();
        let scale = root_mean_square(&targets);
        let sum: f32 = targets.iter().map(|target| (target.value / scale).length_squared()).sum();
        assert!((sum / 12.0 - 1.0).abs() < 1e-5);
        assert_eq!(root_mean_square(&[]), 0.0);
    }
}
