//! Training in the paper's form: multilayer perceptrons by gradient descent, on the CPU or a GPU.

mod deformation;
mod descent;
mod energy;
mod features;
mod fitted;
mod gather;
mod laplacian;
mod network;
mod posed_network;
mod regression;
mod skinning;

pub use deformation::{Fit, PlainDeformation};
pub use fitted::{FittedDeformation, FittedLaplacian};
pub use laplacian::PlainLaplacian;

use crate::options::ComputeDevice;
use anyhow::bail;
use burn::tensor::{Device, Tensor, TensorData};
use glam::Vec3A;

/// The device of `choice`, with gradients. Fails where this build has no such backend.
pub fn training_device(choice: ComputeDevice) -> anyhow::Result<Device> {
    let device = match choice {
        ComputeDevice::Cpu => Device::flex(),
        #[cfg(feature = "vulkan")]
        ComputeDevice::Vulkan => Device::wgpu(burn::tensor::DeviceKind::DefaultDevice),
        #[cfg(feature = "cuda")]
        ComputeDevice::Cuda => Device::cuda(0),
        #[cfg(not(all(feature = "vulkan", feature = "cuda")))]
        other => bail!("device: expected cpu or a GPU of this build's features, found {other:?}"),
    };
    Ok(device.autodiff())
}

/// Every device that tests run on: the processor, and the GPU (or the adapter in software) where this build has one.
#[cfg(test)]
fn test_devices() -> Vec<(ComputeDevice, Device)> {
    let mut choices = vec![ComputeDevice::Cpu];
    if cfg!(feature = "vulkan") {
        choices.push(ComputeDevice::Vulkan);
    }
    choices.into_iter().map(|choice| (choice, training_device(choice).expect("this build has the device"))).collect()
}

/// The one number of a tensor.
fn scalar(tensor: Tensor<1>) -> f32 {
    numbers(tensor)[0]
}

/// Points or vectors as the rows of a tensor (N, 3).
fn rows_of(points: impl Iterator<Item = Vec3A>, device: &Device) -> Tensor<2> {
    let numbers: Vec<f32> = points.flat_map(|point| point.to_array()).collect();
    let count = numbers.len() / 3;
    Tensor::from_data(TensorData::new(numbers, [count, 3]), device)
}

/// All numbers of a tensor, row-major.
fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().as_slice::<f32>().expect("tensors here hold 32-bit floats").to_vec()
}
