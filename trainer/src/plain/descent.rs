//! Gradient descent on one model, which can be left after any step and taken up again.

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

/// What a network learns from: items in parts, of which as many as fit are looked at together.
pub(super) trait Material {
    /// What learns: the network, and what is learnt beside it.
    type Model: Module;
    /// Parts in memory.
    type Pool;

    /// The model that has learnt nothing, of a network that has not.
    fn model(&self, network: Network) -> Self::Model;

    /// Items of each part.
    fn part_sizes(&self) -> &[u32];

    /// Reads parts.
    fn pool(&self, parts: &[u32]) -> anyhow::Result<Self::Pool>;

    /// The mean energy of a step's items, which are numbered through the pool's parts in their order. `done` is the share of all steps before
    /// this one.
    fn energy(
        &self,
        model: &Self::Model,
        pool: &Self::Pool,
        items: &[u32],
        done: f64,
        generator: &mut Pcg64Mcg,
    ) -> anyhow::Result<Tensor<1>>;

    /// A mean energy in words.
    fn note(&self, mean: f32) -> String;
}

/// How to descend, and how it is called.
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
    /// How many items a step takes.
    pub items_a_step: usize,
    /// How many items a pool has at most, if it has more than one part.
    pub items_a_pool: usize,
    /// The learning rate as a share of the first, from the share of all steps that are done.
    pub rate: fn(f64) -> f64,
}

impl Descent<'_> {
    /// The model after all epochs, and the mean energy of each. An epoch passes over all items: pool by pool, each shuffled, of parts in
    /// random order.
    ///
    /// Fails where `material` does, where the energy is not finite, and where somebody asked to stop.
    pub(super) fn run<M: Material>(
        &self,
        context: &TrainContext,
        device: &Device,
        material: &M,
    ) -> anyhow::Result<(M::Model, Vec<f32>)> {
        let sizes = material.part_sizes();
        let item_count: u64 = sizes.iter().map(|&size| u64::from(size)).sum();
        let all = self.options.epoch_count as u64 * item_count;
        let bar = context.progress.bar(self.title, all as usize);
        let kept = context.checkpoint.state::<Bundle>(self.name, self.inputs);
        let mut state = match kept.and_then(|bundle| self.unpack(bundle, device, material)) {
            Some(state) => state,
            None => self.start(device, material),
        };
        bar.advance(state.position.items_done(item_count));
        let mut pool: Option<(usize, M::Pool)> = None;
        while state.position.epoch < self.options.epoch_count {
            let first = state.position.first_part;
            let is_whole = self.pool_end(sizes, &state.parts, 0) == state.parts.len();
            if first == 0 && state.position.done == 0 && !is_whole {
                state.parts.shuffle(&mut state.generator);
                pool = None;
            }
            let end = self.pool_end(sizes, &state.parts, first);
            let parts = &state.parts[first..end];
            if state.position.done == 0 {
                let count: u32 = parts.iter().map(|&part| sizes[part as usize]).sum();
                if state.order.len() != count as usize {
                    state.order = (0..count).collect();
                }
                state.order.shuffle(&mut state.generator);
            }
            let pool = match &mut pool {
                Some((start, pool)) if *start == first => pool,
                other => {
                    // The one before goes first: two would need twice the memory.
                    *other = None;
                    &mut other.insert((first, material.pool(parts)?)).1
                }
            };
            let until = (state.position.done + self.items_a_step.max(1)).min(state.order.len());
            let items = &state.order[state.position.done..until];
            let done = state.position.items_done(item_count) as f64 / all as f64;
            let total = material.energy(&state.model, pool, items, done, &mut state.generator)?;
            let gradients = GradientsParams::from_grads(total.backward(), &state.model);
            let learning_rate = self.options.learning_rate * (self.rate)(done);
            state.model = state.optimiser.step(learning_rate, state.model, gradients);
            let count = items.len() as u64;
            state.position.step(scalar(total), count, until);
            bar.advance(count);
            if until == state.order.len() {
                state.position.end_pool(end);
            }
            if state.position.first_part == state.parts.len() {
                let mean = state.position.end_epoch(item_count);
                ensure!(mean.is_finite(), "{} diverged in epoch {}", self.title, state.position.epoch - 1);
                bar.note(format!("epoch {}: {}", state.position.epoch, material.note(mean)));
            }
            context.checkpoint.keep_state(self.name, self.inputs, || state.pack())?;
        }
        context.checkpoint.keep_last_state(self.name, self.inputs, &state.pack())?;
        context.log.energies(self.title, &state.position.history);
        Ok((state.model, state.position.history))
    }

    /// Where the pool ends that starts with `parts[first]`.
    fn pool_end(&self, sizes: &[u32], parts: &[u32], first: usize) -> usize {
        let mut count = 0;
        let fits = |&&part: &&u32| {
            count += sizes[part as usize] as usize;
            count <= self.items_a_pool
        };
        first + parts[first..].iter().take_while(fits).count().max(1)
    }

    fn start<M: Material>(&self, device: &Device, material: &M) -> State<M::Model> {
        let mut generator = generator(self.seed);
        let sizes = material.part_sizes();
        State {
            model: material.model(Network::new(self.input_count, self.options, generator.random(), device)),
            optimiser: AdamConfig::new().init(),
            generator,
            parts: (0..sizes.len() as u32).filter(|&part| sizes[part as usize] > 0).collect(),
            order: Vec::new(),
            position: Position::default(),
        }
    }

    /// None where the bundle is of another model or of other items.
    fn unpack<M: Material>(&self, bundle: Bundle, device: &Device, material: &M) -> Option<State<M::Model>> {
        let start = self.start(device, material);
        let (parts, order) = (numbers(&bundle.parts)?, numbers(&bundle.order)?);
        let position: Position = serde_json::from_slice(&bundle.position).ok()?;
        let all_parts = sorted(&parts) == start.parts && position.first_part <= parts.len();
        if !all_parts || sorted(&order).into_iter().ne(0..order.len() as u32) || position.done > order.len() {
            return None;
        }
        let record = ModuleRecord::from_bytes(Bytes::from_bytes_vec(bundle.model)).ok()?;
        Some(State {
            model: start.model.try_load_record(record).ok()?,
            optimiser: start.optimiser.from_bytes(Bytes::from_bytes_vec(bundle.optimiser)).ok()?,
            generator: serde_json::from_slice(&bundle.generator).ok()?,
            parts,
            order,
            position,
        })
    }
}

fn numbers(bytes: &[u8]) -> Option<Vec<u32>> {
    let (numbers, []) = bytes.as_chunks::<4>() else { return None };
    Some(numbers.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect())
}

fn sorted(numbers: &[u32]) -> Vec<u32> {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable();
    sorted
}

/// Everything that the next step depends on.
struct State<M> {
    model: M,
    optimiser: ModuleOptimizer,
    generator: Pcg64Mcg,
    /// Parts that are not empty, in this epoch's order.
    parts: Vec<u32>,
    /// Items of the pool in their order.
    order: Vec<u32>,
    position: Position,
}

/// How far the descent is.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Position {
    /// Whole epochs done.
    epoch: usize,
    /// Where the pool starts in this epoch's parts.
    first_part: usize,
    /// Items of the pool done.
    done: usize,
    /// Items of this epoch done.
    epoch_done: u64,
    /// Of their energies.
    sum: f64,
    /// Mean energy of each epoch.
    history: Vec<f32>,
}

impl Position {
    /// Of all epochs.
    fn items_done(&self, item_count: u64) -> u64 {
        self.epoch as u64 * item_count + self.epoch_done
    }

    /// `count` items more, of this mean energy; those before `done` of the pool.
    fn step(&mut self, mean: f32, count: u64, done: usize) {
        self.sum += f64::from(mean) * count as f64;
        self.epoch_done += count;
        self.done = done;
    }

    fn end_pool(&mut self, next_part: usize) {
        self.first_part = next_part;
        self.done = 0;
    }

    /// Gives the epoch's mean energy.
    fn end_epoch(&mut self, item_count: u64) -> f32 {
        let mean = (self.sum / item_count as f64) as f32;
        let mut history = std::mem::take(&mut self.history);
        history.push(mean);
        *self = Self { epoch: self.epoch + 1, history, ..Self::default() };
        mean
    }
}

impl<M: Module> State<M> {
    fn pack(&self) -> Bundle {
        const PLAIN: &str = "a state is plain data";
        Bundle {
            model: self.model.clone().into_record().into_bytes().expect(PLAIN).to_vec(),
            optimiser: self.optimiser.into_bytes().expect(PLAIN).to_vec(),
            generator: serde_json::to_vec(&self.generator).expect(PLAIN),
            parts: self.parts.iter().flat_map(|part| part.to_le_bytes()).collect(),
            order: self.order.iter().flat_map(|item| item.to_le_bytes()).collect(),
            position: serde_json::to_vec(&self.position).expect(PLAIN),
        }
    }
}

/// A state in bytes, part by part.
#[derive(Debug, PartialEq)]
struct Bundle {
    model: Vec<u8>,
    optimiser: Vec<u8>,
    generator: Vec<u8>,
    parts: Vec<u8>,
    order: Vec<u8>,
    position: Vec<u8>,
}

impl Keep for Bundle {
    /// Each part after its length, 8 bytes, little endian.
    fn to_bytes(&self) -> Vec<u8> {
        let Self { model, optimiser, generator, parts, order, position } = self;
        let parts = [model, optimiser, generator, parts, order, position];
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
        let [model, optimiser, generator] = [part()?, part()?, part()?];
        let [parts, order, position] = [part()?, part()?, part()?];
        bytes.is_empty().then_some(Self { model, optimiser, generator, parts, order, position })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundles_come_back_and_damaged_ones_do_not() {
        let bundle = Bundle {
            model: vec![1, 2],
            optimiser: vec![],
            generator: vec![3],
            parts: vec![6],
            order: vec![4; 9],
            position: vec![5],
        };
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
        let history = vec![1.0 / 3.0, f32::MIN_POSITIVE];
        let position = Position { epoch: 3, first_part: 2, done: 8, epoch_done: 9, sum: 0.1, history };
        let back: Position = serde_json::from_slice(&serde_json::to_vec(&position).unwrap()).unwrap();
        assert_eq!(back, position);
    }
}
