//! f_d's network, and the poses that are learnt beside it.

use super::network::Network;
use super::skinning::Skinning;
use burn::module::{Module, Param};
use burn::tensor::{Device, Int, Tensor, TensorData};

/// A network, and steps from the given poses where those are learnt too.
#[derive(Module, Debug)]
pub(super) struct PosedNetwork {
    pub network: Network,
    /// Steps of every frame's pose (frames, [`Skinning::unknowns`]), in units of its scale: Adam goes as far in a number of any size, and
    /// poses have a rate of their own.
    steps: Option<Param<Tensor<2>>>,
}

impl PosedNetwork {
    /// A network alone.
    pub fn new(network: Network) -> Self {
        Self { network, steps: None }
    }

    /// With poses of `frame_count` frames, of which none is moved yet.
    pub fn with_poses(network: Network, frame_count: usize, joint_count: usize, device: &Device) -> Self {
        let shape = [frame_count, Skinning::unknowns(joint_count)];
        let nothing = TensorData::new(vec![0.0_f32; shape[0] * shape[1]], shape);
        Self { network, steps: Some(Param::from_data(nothing, device)) }
    }

    /// Steps of the poses of `frames` times `scale`; none where poses are not learnt.
    pub fn steps(&self, frames: &[u32], scale: f32, device: &Device) -> Option<Tensor<2>> {
        let steps = self.steps.as_ref()?;
        let frames: Vec<i32> = frames.iter().map(|&frame| frame as i32).collect();
        let count = frames.len();
        let frames = Tensor::<1, Int>::from_data(TensorData::new(frames, [count]), device);
        Some(steps.val().select(0, frames) * scale)
    }
}
