//! Gradient descent on one network, which can be left after any step and taken up again.

use super::network::Network;
use super::scalar;
use crate::checkpoint::{Fingerprint, Keep};
use crate::context::TrainContext;
use crate::options::NetworkOptions;
use crate::sampling::generator;
use anyhow::ensure;
use burn::module::Module;
use burn::optim::{AdamConfig, GradientsParams, ModuleOptimizer};
use burn::store::ModuleRecord;
use burn::tensor::{Bytes, Device, Tensor};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

/// What is descended on, and how it is called.
pub(super) struct Descent<'a> {
    /// Name of the state in a checkpoint.
    pub name: &'a str,
    /// Name of the stage for people.
    pub title: &'a str,
    /// Everything that the result depends on.
    pub inputs: Fingerprint,
    /// Shape and optimiser.
    pub options: &'a NetworkOptions,
    /// Numbers that the network takes for one point.
    pub input_count: usize,
    /// Seed of weights and of every draw.
    pub seed: u64,
    /// Things to learn from: an epoch passes over all, in a new order each time.
    pub item_count: usize,
    /// How many of them a step takes.
    pub items_a_step: usize,
    /// The learning rate as a share of the first, from the share of all steps that are done.
    pub rate: fn(f64) -> f64,
}

impl Descent<'_> {
    /// The network after all epochs, and the mean energy of each.
    ///
    /// `energy` is given the network, the items of a step, and the generator to draw from; `note` says an epoch's mean energy in words.
    /// Fails where `energy` does, where the energy is not finite, and where somebody asked to stop.
    pub(super) fn run(
        &self,
        context: &TrainContext,
        device: &Device,
        mut energy: impl FnMut(&Network, &[u32], &mut Pcg64Mcg) -> anyhow::Result<Tensor<1>>,
        note: impl Fn(f32) -> String,
    ) -> anyhow::Result<(Network, Vec<f32>)> {
        let epoch_count = self.options.epoch_count;
        let bar = context.progress.bar(self.title, epoch_count);
        let kept = context.checkpoint.state::<Bundle>(self.name, self.inputs);
        let mut state = match kept.and_then(|bundle| self.unpack(bundle, device)) {
            Some(state) => state,
            None => self.start(device),
        };
        bar.advance(state.position.epoch as u64);
        while state.position.epoch < epoch_count {
            if state.position.done == 0 {
                state.order.shuffle(&mut state.generator);
            }
            let end = (state.position.done + self.items_a_step.max(1)).min(state.order.len());
            let batch = &state.order[state.position.done..end];
            let total = energy(&state.network, batch, &mut state.generator)?;
            let gradients = GradientsParams::from_grads(total.backward(), &state.network);
            let all = (epoch_count * state.order.len()) as f64;
            let done = (state.position.epoch * state.order.len() + state.position.done) as f64 / all;
            let learning_rate = self.options.learning_rate * (self.rate)(done);
            state.network = state.optimiser.step(learning_rate, state.network, gradients);
            state.position.sum += scalar(total) * batch.len() as f32;
            state.position.done = end;
            if end == state.order.len() {
                let mean = state.position.sum / state.order.len() as f32;
                ensure!(mean.is_finite(), "{} diverged in epoch {}", self.title, state.position.epoch);
                state.position.end_epoch(mean);
                bar.note(note(mean));
                bar.advance(1);
            }
            context.checkpoint.keep_state(self.name, self.inputs, || state.pack())?;
        }
        context.checkpoint.keep_last_state(self.name, self.inputs, &state.pack())?;
        Ok((state.network, state.position.history))
    }

    fn start(&self, device: &Device) -> State {
        let mut generator = generator(self.seed);
        State {
            network: Network::new(self.input_count, self.options, generator.random(), device),
            optimiser: AdamConfig::new().init(),
            generator,
            order: (0..self.item_count as u32).collect(),
            position: Position::default(),
        }
    }

    /// None where the bundle is of another network or another number of items.
    fn unpack(&self, bundle: Bundle, device: &Device) -> Option<State> {
        let start = self.start(device);
        let (order, []) = bundle.order.as_chunks::<4>() else { return None };
        let order: Vec<u32> = order.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect();
        if order.len() != self.item_count || order.iter().any(|&item| item as usize >= self.item_count) {
            return None;
        }
        let record = ModuleRecord::from_bytes(Bytes::from_bytes_vec(bundle.network)).ok()?;
        Some(State {
            network: start.network.try_load_record(record).ok()?,
            optimiser: start.optimiser.from_bytes(Bytes::from_bytes_vec(bundle.optimiser)).ok()?,
            generator: serde_json::from_slice(&bundle.generator).ok()?,
            order,
            position: serde_json::from_slice(&bundle.position).ok()?,
        })
    }
}

/// Everything that the next step depends on.
struct State {
    network: Network,
    optimiser: ModuleOptimizer,
    generator: Pcg64Mcg,
    /// Items in this epoch's order.
    order: Vec<u32>,
    position: Position,
}

/// How far the descent is.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Position {
    /// Whole epochs done.
    epoch: usize,
    /// Items of this epoch done.
    done: usize,
    /// Of their energies.
    sum: f32,
    /// Mean energy of each epoch.
    history: Vec<f32>,
}

impl Position {
    fn end_epoch(&mut self, mean: f32) {
        self.history.push(mean);
        self.epoch += 1;
        self.done = 0;
        self.sum = 0.0;
    }
}

impl State {
    fn pack(&self) -> Bundle {
        const PLAIN: &str = "a state is plain data";
        Bundle {
            network: self.network.clone().into_record().into_bytes().expect(PLAIN).to_vec(),
            optimiser: self.optimiser.into_bytes().expect(PLAIN).to_vec(),
            generator: serde_json::to_vec(&self.generator).expect(PLAIN),
            order: self.order.iter().flat_map(|item| item.to_le_bytes()).collect(),
            position: serde_json::to_vec(&self.position).expect(PLAIN),
        }
    }
}

/// A state in bytes, part by part.
#[derive(Debug, PartialEq)]
struct Bundle {
    network: Vec<u8>,
    optimiser: Vec<u8>,
    generator: Vec<u8>,
    order: Vec<u8>,
    position: Vec<u8>,
}

impl Keep for Bundle {
    /// Each part after its length, 8 bytes, little endian.
    fn to_bytes(&self) -> Vec<u8> {
        let parts = [&self.network, &self.optimiser, &self.generator, &self.order, &self.position];
        let framed = parts.map(|part| [&(part.len() as u64).to_le_bytes(), part.as_slice()].concat());
        framed.concat()
    }

    fn from_bytes(mut bytes: &[u8]) -> Option<Self> {
        let mut part = || {
            let (length, rest) = bytes.split_first_chunk()?;
            let (part, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
            bytes = rest;
            Some(part.to_vec())
        };
        let [network, optimiser, generator, order, position] = [part()?, part()?, part()?, part()?, part()?];
        bytes.is_empty().then_some(Self { network, optimiser, generator, order, position })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundles_come_back_and_damaged_ones_do_not() {
        let bundle =
            Bundle { network: vec![1, 2], optimiser: vec![], generator: vec![3], order: vec![4; 9], position: vec![5] };
        let bytes = bundle.to_bytes();
        assert_eq!(Bundle::from_bytes(&bytes).unwrap(), bundle);
        assert_eq!(Bundle::from_bytes(&bytes[..bytes.len() - 1]), None);
        assert_eq!(Bundle::from_bytes(&[bytes.clone(), vec![0]].concat()), None);
        let mut long = bytes;
        long[..8].fill(0xff);
        assert_eq!(Bundle::from_bytes(&long), None);
    }

    #[test]
    fn generators_and_energies_survive_text_bit_for_bit() {
        let mut drawn = generator(7);
        let _: u64 = drawn.random();
        let mut back: Pcg64Mcg = serde_json::from_slice(&serde_json::to_vec(&drawn).unwrap()).unwrap();
        assert_eq!(back.random::<u64>(), drawn.random::<u64>());
        let position = Position { epoch: 3, done: 8, sum: 0.1, history: vec![1.0 / 3.0, f32::MIN_POSITIVE] };
        let back: Position = serde_json::from_slice(&serde_json::to_vec(&position).unwrap()).unwrap();
        assert_eq!(back, position);
    }
}
