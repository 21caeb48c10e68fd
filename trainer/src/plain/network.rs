//! A multilayer perceptron as burn sees it, and its way to the runtime's.

use super::numbers;
use crate::options::NetworkOptions;
use crate::sampling::generator;
use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData, activation::relu};
use crease::encoding::PositionalEncoding;
use crease::network::{Layer, Mlp};
use rand::RngExt;

/// Linear layers with ReLU between them.
#[derive(Module, Debug)]
pub(super) struct Network {
    layers: Vec<Linear>,
}

impl Network {
    /// A network of `input_count` inputs and three outputs. Weights and biases are uniform within ±1/√inputs of their layer, from `seed`.
    pub(super) fn new(input_count: usize, options: &NetworkOptions, seed: u64, device: &Device) -> Self {
        let mut generator = generator(seed);
        let layer_count = options.layer_count.max(1);
        let layers = (0..layer_count)
            .map(|index| {
                let inputs = if index == 0 { input_count } else { options.width };
                let outputs = if index + 1 == layer_count { 3 } else { options.width };
                let bound = 1.0 / (inputs as f32).sqrt();
                let mut values =
                    |count| (0..count).map(|_| generator.random_range(-bound..bound)).collect::<Vec<f32>>();
                Linear {
                    weight: Param::from_data(TensorData::new(values(inputs * outputs), [inputs, outputs]), device),
                    bias: Some(Param::from_data(TensorData::new(values(outputs), [outputs]), device)),
                }
            })
            .collect();
        Self { layers }
    }

    /// (N, inputs) to (N, 3).
    pub(super) fn forward(&self, input: Tensor<2>) -> Tensor<2> {
        let mut value = input;
        for (index, layer) in self.layers.iter().enumerate() {
            value = layer.forward(if index == 0 { value } else { relu(value) });
        }
        value
    }

    /// The network for the runtime. burn stores weights as (inputs, outputs), the runtime as (outputs, inputs).
    pub(super) fn export(&self, level: usize, encoding: PositionalEncoding, output_scale: f32) -> Mlp {
        let layers = self
            .layers
            .iter()
            .map(|layer| Layer {
                weight: numbers(layer.weight.val().transpose()),
                bias: layer.bias.as_ref().map(|bias| numbers(bias.val())).unwrap_or_default(),
            })
            .collect();
        Mlp { level: level as u32, encoding, layers, output_scale }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ComputeDevice;
    use crate::plain::features::Features;
    use crate::plain::{scalar, test_devices, training_device};
    use crate::sampling::random_points;
    use burn::optim::{AdamConfig, GradientsParams};
    use crease::body::Pose;
    use crease::network::{Domain, Scratch};
    use crease::pose_feature::PoseMask;
    use glam::{Quat, Vec3A};

    fn import(mlp: &Mlp, device: &Device) -> Network {
        let tensor =
            |values: &[f32], shape: [usize; 2]| Tensor::<2>::from_data(TensorData::new(values.to_vec(), shape), device);
        let layers = mlp.layers.iter().map(|layer| Linear {
            weight: Param::from_tensor(tensor(&layer.weight, [layer.output_count(), layer.input_count()]).transpose()),
            bias: Some(Param::from_data(TensorData::new(layer.bias.clone(), [layer.bias.len()]), device)),
        });
        Network { layers: layers.collect() }
    }

    #[test]
    fn the_fixture_says_the_same_in_training_as_in_the_runtime() {
        let device = training_device(ComputeDevice::Cpu).unwrap();
        let file = include_bytes!("../../../tests/fixtures/tiny_plain.glb");
        let avatar = crease::avatar::Avatar::read(file, "tiny_plain.glb").unwrap();
        let mut animator = crease::animate::Animator::new(std::sync::Arc::new(avatar)).unwrap();
        let pose = crease::fixture::bent_pose();
        animator.animate(&pose, &crease::animate::Options::default());
        let avatar = animator.avatar();
        for (name, function) in [("f_d", &avatar.deformation), ("f_l", &avatar.laplacian)] {
            let crease::network::SurfaceFunction::Mlp(mlp) = function else { panic!("{name} is plain") };
            let domain = &animator.domains()[function.level()];
            let features = Features::new(mlp.encoding, pose.rotations.len());
            let (angles, length) = (Features::axis_angles(&pose), features.length());
            let mut rows = vec![0.0; length * domain.canonical.len()];
            for (i, row) in rows.chunks_exact_mut(length).enumerate() {
                features.fill(domain.canonical[i], domain.masks[i], &angles, row);
            }
            let input = Tensor::from_data(TensorData::new(rows, [domain.canonical.len(), length]), &device);
            let expected = numbers(import(mlp, &device).forward(input) * mlp.output_scale);
            let mut out = vec![Vec3A::ZERO; domain.canonical.len()];
            function.evaluate(domain, &pose, &mut Scratch::default(), &mut out);
            let scale = out.iter().map(|value| value.length()).fold(0.0, f32::max);
            assert!(scale > 0.0, "{name} says something");
            for (value, expected) in out.iter().zip(expected.chunks_exact(3)) {
                assert!(
                    value.distance(Vec3A::from_slice(expected)) < 1e-4 * scale,
                    "{name}: {value} against {expected:?}"
                );
            }
        }
    }

    #[test]
    fn forward_agrees_with_the_runtime() {
        let device = training_device(ComputeDevice::Cpu).unwrap();
        let encoding = PositionalEncoding { frequency_count: 4 };
        let domain = Domain {
            canonical: random_points(70, 1.0, 1),
            masks: (0..70).map(|i| PoseMask([0b1010, 0, 0b0110][i % 3])).collect(),
        };
        let mut pose = Pose::rest(4);
        for (joint, rotation) in pose.rotations.iter_mut().enumerate() {
            *rotation = Quat::from_rotation_x(0.3 + joint as f32) * Quat::from_rotation_z(0.5);
        }
        let features = Features::new(encoding, 4);
        let options = NetworkOptions { layer_count: 3, width: 20, learning_rate: 1e-3, epoch_count: 1 };
        let network = Network::new(features.length(), &options, 9, &device);
        let rows: Vec<f32> = (0..70)
            .flat_map(|i| {
                let mut row = vec![0.0; features.length()];
                features.fill(domain.canonical[i], domain.masks[i], &Features::axis_angles(&pose), &mut row);
                row
            })
            .collect();
        let input = Tensor::from_data(TensorData::new(rows, [70, features.length()]), &device);
        let expected = numbers(network.forward(input) * 2.5);
        let mut out = vec![Vec3A::ZERO; 70];
        network.export(0, encoding, 2.5).evaluate(&domain, &pose, &mut Scratch::default(), &mut out);
        for (value, expected) in out.iter().zip(expected.chunks_exact(3)) {
            assert!((*value - Vec3A::from_slice(expected)).length() < 1e-5, "{value} against {expected:?}");
        }
        // Negative case: another seed is another network.
        let other = Network::new(features.length(), &options, 10, &device);
        let mut different = out.clone();
        other.export(0, encoding, 2.5).evaluate(&domain, &pose, &mut Scratch::default(), &mut different);
        assert!((different[0] - out[0]).length() > 1e-3);
    }

    /// A small network, what it is given, and what it should say.
    fn lesson(device: &Device) -> (Network, Tensor<2>, Tensor<2>) {
        let options = NetworkOptions { layer_count: 3, width: 24, learning_rate: 1e-2, epoch_count: 1 };
        let flat = |count, seed| -> Vec<f32> {
            random_points(count, 1.0, seed).iter().flat_map(|point| point.to_array()).collect()
        };
        let input = Tensor::from_data(TensorData::new(flat(400, 1), [200, 6]), device);
        let wanted = Tensor::from_data(TensorData::new(flat(200, 2), [200, 3]), device);
        (Network::new(6, &options, 3, device), input, wanted)
    }

    fn energy(network: &Network, input: &Tensor<2>, wanted: &Tensor<2>) -> Tensor<1> {
        (network.forward(input.clone()) - wanted.clone()).square().mean()
    }

    #[test]
    fn the_energy_has_its_gradient_in_every_layer_on_every_device() {
        for (choice, device) in test_devices() {
            let (network, input, wanted) = lesson(&device);
            let gradients = energy(&network, &input, &wanted).backward();
            for (index, layer) in network.layers.iter().enumerate() {
                let gradient = numbers(layer.weight.val().grad(&gradients).unwrap());
                let largest = gradient.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
                assert!(largest > 1e-4, "{choice:?}: layer {index} learns");
                let (weights, shape) = (numbers(layer.weight.val()), layer.weight.val().dims());
                for entry in (0..weights.len()).step_by(weights.len() / 6) {
                    let step = 4e-3;
                    let [below, above] = [-step, step].map(|step| {
                        let (mut moved, mut weights) = (network.clone(), weights.clone());
                        weights[entry] += step;
                        moved.layers[index].weight = Param::from_data(TensorData::new(weights, shape), &device);
                        scalar(energy(&moved, &input, &wanted))
                    });
                    let error = gradient[entry] - (above - below) / (2.0 * step);
                    assert!(error.abs() < 0.05 * largest, "{choice:?}: layer {index}, entry {entry}: {error}");
                }
            }
        }
    }

    #[test]
    fn steps_of_adam_teach_the_same_on_every_device() {
        let learnt = test_devices().into_iter().map(|(choice, device)| {
            let (mut network, input, wanted) = lesson(&device);
            let before = scalar(energy(&network, &input, &wanted));
            let mut optimiser = AdamConfig::new().init();
            for _ in 0..60 {
                let gradients = energy(&network, &input, &wanted).backward();
                network = optimiser.step(1e-2, network.clone(), GradientsParams::from_grads(gradients, &network));
            }
            (choice, before, scalar(energy(&network, &input, &wanted)))
        });
        let learnt: Vec<_> = learnt.collect();
        let (_, first_before, first_after) = learnt[0];
        for (choice, before, after) in learnt {
            assert!(after < 0.6 * before, "{choice:?}: {before} to {after}");
            assert!((before / first_before - 1.0).abs() < 1e-4, "{choice:?}: {before} for {first_before}");
            assert!((after / first_after - 1.0).abs() < 0.02, "{choice:?}: {after} for {first_after}");
        }
    }
}
