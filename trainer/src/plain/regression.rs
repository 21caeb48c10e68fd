//! Gradient descent on pairs of a surface point in a pose and the value wanted there.

use super::descent::{Descent, Material};
use super::features::Features;
use super::network::Network;
use super::{rows_of, training_device};
use crate::checkpoint::{Fingerprint, Ingredients, Keep};
use crate::context::TrainContext;
use crate::options::NetworkOptions;
use crate::resident::Resident;
use crate::targets::Target;
use anyhow::ensure;
use burn::tensor::{Device, Tensor, TensorData};
use crease::encoding::PositionalEncoding;
use crease::network::Mlp;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::sync::Arc;

/// Training pairs of all frames, which are read when they are needed.
pub(super) struct Pairs<'a> {
    targets: Resident<'a, Vec<Target>>,
    poses: Vec<Vec<[f32; 3]>>,
    /// Pairs of each frame.
    counts: Vec<u32>,
    /// Root mean square of the components of their values.
    scale: f32,
    /// Of all of them.
    fingerprint: Fingerprint,
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

impl<'a> Pairs<'a> {
    /// The pairs that `read` gives for each of the context's frames, always the same; all are read once now.
    pub fn read(
        context: &TrainContext,
        title: &str,
        read: impl Fn(usize) -> anyhow::Result<Vec<Target>> + Sync + 'a,
    ) -> anyhow::Result<Self> {
        let samples = &context.samples;
        let size = |targets: &Vec<Target>| size_of_val(targets.as_slice());
        // The other half is the pool's.
        let targets = Resident::new(samples.len(), context.options.memory_bytes() / 2, size, read);
        let bar = context.progress.bar(title, samples.len());
        let (mut counts, mut sum, mut all) = (Vec::new(), 0.0, Ingredients::new("pairs"));
        // As many at a time as there are threads: whole frames side by side leave none of them idle.
        let indices: Vec<usize> = (0..samples.len()).collect();
        for some in indices.chunks(rayon::current_num_threads()) {
            let frames = some.par_iter().map(|&index| targets.get(index)).collect::<anyhow::Result<Vec<_>>>()?;
            for frame in frames {
                counts.push(frame.len() as u32);
                sum = frame.iter().fold(sum, |sum, target| sum + f64::from(target.value.length_squared()));
                all = all.bytes(&frame.to_bytes());
                bar.advance(1);
            }
        }
        let count: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        Ok(Self {
            targets,
            poses: samples.iter().map(|&sample| Features::axis_angles(context.pose(sample))).collect(),
            counts,
            scale: (sum / (3 * count).max(1) as f64).sqrt() as f32,
            fingerprint: all.finish(),
        })
    }

    /// The trained network, and the mean energy (of standardised targets) over each epoch.
    pub fn regress(&self, context: &TrainContext, regression: Regression<'_>) -> anyhow::Result<(Mlp, Vec<f32>)> {
        let Regression { name, title, level, network, seed, rate } = regression;
        let device = training_device(context.options.device)?;
        let encoding = PositionalEncoding { frequency_count: context.options.frequency_count };
        let features = Features::new(encoding, context.rig.parents.len());
        ensure!(self.scale > 0.0, "{title}: expected points of the scans near the base mesh, found none");
        let descent = Descent {
            name,
            title,
            inputs: context.ingredients(name).value(&self.poses).bytes(&self.fingerprint.0).finish(),
            options: network,
            input_count: features.length(),
            seed,
            items_a_step: context.options.laplacian.points_a_step,
            items_a_pool: context.options.memory_bytes() / 2 / size_of::<Target>(),
            rate,
        };
        let lessons = Lessons { pairs: self, features, device: device.clone() };
        let (network, history) = descent.run(context, &device, &lessons)?;
        Ok((network.export(level, encoding, self.scale), history))
    }
}

/// Pairs as a network is shown them.
struct Lessons<'a> {
    pairs: &'a Pairs<'a>,
    features: Features,
    device: Device,
}

/// Pairs of several frames in memory.
struct Pool {
    /// Number of the first pair of each frame.
    starts: Vec<u32>,
    frames: Vec<(u32, Arc<Vec<Target>>)>,
}

impl Pool {
    /// A pair, and the frame that it is of.
    fn at(&self, item: u32) -> (u32, &Target) {
        let place = self.starts.partition_point(|&start| start <= item) - 1;
        let (frame, targets) = &self.frames[place];
        (*frame, &targets[(item - self.starts[place]) as usize])
    }
}

impl Material for Lessons<'_> {
    type Model = Network;
    type Pool = Pool;

    fn model(&self, network: Network) -> Network {
        network
    }

    fn part_sizes(&self) -> &[u32] {
        &self.pairs.counts
    }

    fn pool(&self, parts: &[u32]) -> anyhow::Result<Pool> {
        let read = |&part: &u32| Ok((part, self.pairs.targets.get(part as usize)?));
        let starts = parts.iter().scan(0, |end, &part| {
            let start = *end;
            *end += self.pairs.counts[part as usize];
            Some(start)
        });
        Ok(Pool { starts: starts.collect(), frames: parts.par_iter().map(read).collect::<anyhow::Result<_>>()? })
    }

    fn energy(
        &self,
        network: &Network,
        pool: &Pool,
        items: &[u32],
        _: f64,
        _: &mut Pcg64Mcg,
    ) -> anyhow::Result<Tensor<1>> {
        let length = self.features.length();
        let mut input = vec![0.0; items.len() * length];
        input.par_chunks_exact_mut(length).zip(items).for_each(|(row, &item)| {
            let (frame, target) = pool.at(item);
            self.features.fill(target.canonical, target.mask, &self.pairs.poses[frame as usize], row);
        });
        let input = Tensor::from_data(TensorData::new(input, [items.len(), length]), &self.device);
        let targets: Vec<&Target> = items.iter().map(|&item| pool.at(item).1).collect();
        Ok(energy(network.forward(input), &targets, self.pairs.scale))
    }

    fn note(&self, mean: f32) -> String {
        format!("energy {mean:.4}")
    }
}

/// The mean of μ |prediction − value / `scale`|² over a batch (E_l of paper Eq. PDD).
///
/// Values are in the canonical frame: where the blended matrix is a rotation, as it is away from joints, the length of the difference is that
/// in the posed frame.
fn energy(prediction: Tensor<2>, batch: &[&Target], scale: f32) -> Tensor<1> {
    let device = prediction.device();
    let count = batch.len();
    let wanted = rows_of(batch.iter().map(|target| target.value / scale), &device);
    let weights: Vec<f32> = batch.iter().map(|target| target.weight / count as f32).collect();
    let weights = Tensor::<2>::from_data(TensorData::new(weights, [count, 1]), &device);
    ((prediction - wanted).square() * weights).sum()
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
    fn pools_number_their_pairs_through() {
        let targets = targets();
        let frames =
            vec![(5, Arc::new(targets[..1].to_vec())), (9, Arc::new(Vec::new())), (2, Arc::new(targets[1..].to_vec()))];
        let pool = Pool { starts: vec![0, 1, 1], frames };
        let expected = [(5, 0), (2, 1), (2, 2), (2, 3)].map(|(frame, index): (u32, usize)| (frame, &targets[index]));
        assert_eq!([0, 1, 2, 3].map(|item| pool.at(item)), expected);
    }
}
