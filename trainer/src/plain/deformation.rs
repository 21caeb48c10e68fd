//! f_d as a multilayer perceptron (paper, Pose-dependent base mesh).

use super::descent::{Descent, Material};
use super::energy::{Energy, Scan, Weights};
use super::features::Features;
use super::gather::Rows;
use super::network::Network;
use super::posed_network::PosedNetwork;
use super::skinning::Skinning;
use super::{numbers, training_device};
use crate::checkpoint::Fingerprint;
use crate::context::{DeformationTrainer, Sample, TrainContext, TrainedDeformation};
use crate::resident::Resident;
use anyhow::ensure;
use burn::tensor::{Device, Tensor, TensorData};
use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::network::{Mlp, SurfaceFunction};
use glam::Vec3A;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::sync::Arc;

/// The network's numbers are decimetres: offsets of clothes are of that order, and so its outputs and weights are near 1.
const OUTPUT_SCALE: f32 = 0.1;

/// Where poses are learnt too, they begin to move after this share of all steps: before f_d knows the clothes, they would make up for them.
const POSES_START: f64 = 0.5;

/// Trains f_d by gradient descent on E_d.
pub struct PlainDeformation;

impl DeformationTrainer for PlainDeformation {
    fn train(&self, context: &TrainContext) -> anyhow::Result<TrainedDeformation> {
        let Fit { network, poses, energies: _ } = self.fit(context)?;
        Ok(TrainedDeformation { function: SurfaceFunction::Mlp(network), poses })
    }
}

/// What descent leaves.
pub struct Fit {
    /// f_d.
    pub network: Mlp,
    /// The mean of E_d over each epoch.
    pub energies: Vec<f32>,
    /// The poses of the training frames, where they were learnt too.
    pub poses: Option<Vec<Pose>>,
}

impl PlainDeformation {
    /// Descends on E_d. Fails where a scan cannot be read, where the energy is not finite, and where somebody asked to stop.
    pub fn fit(&self, context: &TrainContext) -> anyhow::Result<Fit> {
        let options = &context.options.deformation;
        let device = training_device(context.options.device)?;
        let encoding = PositionalEncoding { frequency_count: context.options.frequency_count };
        let features = Features::new(encoding, context.rig.parents.len());
        let weights = Weights {
            regulariser: options.regulariser_weight,
            anchor: options.anchor_weight,
            mesh_to_scan: options.mesh_to_scan_weight,
        };
        let energy = Energy::new(&context.body.triangles, &context.adjacency, anchor_rows(context), weights);

        let descent = Descent {
            name: "deformation",
            title: "training the base",
            inputs: inputs(context)?,
            options: &options.network,
            input_count: features.length(),
            seed: context.options.seed,
            items_a_step: options.frames_a_step,
            items_a_pool: usize::MAX,
            rate: |_| 1.0,
        };
        let read = |index: usize| read_scan(context, context.samples[index]);
        let frame_count = context.samples.len();
        let lessons = Lessons {
            context,
            features,
            scans: Resident::new(frame_count, context.options.memory_bytes(), Scan::bytes, read),
            energy,
            skinning: Skinning::new(&context.rig, &device),
            device: device.clone(),
            sizes: [frame_count as u32],
        };
        let (model, energies) = descent.run(context, &device, &lessons)?;
        let all: Vec<u32> = (0..frame_count as u32).collect();
        let poses = lessons.steps(&model, &all).map(|steps| lessons.moved(&context.poses(), &numbers(steps)));
        Ok(Fit { network: model.network.export(0, encoding, OUTPUT_SCALE), energies, poses })
    }
}

/// Frames as the network is shown them: all of them are items of one part, and those of a step are read for it.
struct Lessons<'a> {
    context: &'a TrainContext,
    features: Features,
    scans: Resident<'a, Scan>,
    energy: Energy,
    skinning: Skinning,
    device: Device,
    sizes: [u32; 1],
}

impl Material for Lessons<'_> {
    type Model = PosedNetwork;
    type Pool = ();

    fn model(&self, network: Network) -> PosedNetwork {
        if self.context.options.refinement.learning_rate > 0.0 {
            PosedNetwork::with_poses(network, self.context.samples.len(), self.context.rig.parents.len(), &self.device)
        } else {
            PosedNetwork::new(network)
        }
    }

    fn part_sizes(&self) -> &[u32] {
        &self.sizes
    }

    fn pool(&self, _: &[u32]) -> anyhow::Result<()> {
        Ok(())
    }

    fn energy(
        &self,
        model: &PosedNetwork,
        (): &(),
        items: &[u32],
        done: f64,
        generator: &mut Pcg64Mcg,
    ) -> anyhow::Result<Tensor<1>> {
        let read = |&index: &u32| self.scans.get(index as usize);
        let whole: Vec<Arc<Scan>> = items.par_iter().map(read).collect::<anyhow::Result<_>>()?;
        let pose = |&index: &u32| self.context.pose(self.context.samples[index as usize]).clone();
        let given: Vec<Pose> = items.iter().map(pose).collect();
        let steps = self.steps(model, items).filter(|_| done >= POSES_START);
        let posed = self.posed(&model.network, &given, steps.clone());
        let positions: Vec<Vec3A> = numbers(posed.clone()).chunks_exact(3).map(Vec3A::from_slice).collect();
        ensure!(positions.iter().all(|p| p.is_finite()), "training the base diverged");
        let drawn: Vec<Scan> = match self.context.options.deformation.points_a_frame {
            0 => Vec::new(),
            count => whole.iter().map(|scan| scan.drawn(count, generator)).collect(),
        };
        let scans: Vec<&Scan> = match drawn.is_empty() {
            true => whole.iter().map(Arc::as_ref).collect(),
            false => drawn.iter().collect(),
        };
        let energy = self.energy.evaluate(&posed, &positions, &scans)?;
        Ok(match steps {
            Some(steps) => energy + self.hold(steps),
            None => energy,
        })
    }

    fn note(&self, mean: f32) -> String {
        format!("E_d {:.3} mm²", 1e6 * mean)
    }
}

impl Lessons<'_> {
    /// Steps of the poses of `frames`, radians and metres; none where poses are not learnt.
    fn steps(&self, model: &PosedNetwork, frames: &[u32]) -> Option<Tensor<2>> {
        let options = &self.context.options;
        let scale = options.refinement.learning_rate / options.deformation.network.learning_rate;
        model.steps(frames, scale as f32, &self.device)
    }

    /// `poses` after `steps`.
    fn moved(&self, poses: &[Pose], steps: &[f32]) -> Vec<Pose> {
        let unknowns = Skinning::unknowns(self.context.rig.parents.len());
        poses.iter().zip(steps.chunks_exact(unknowns)).map(|(pose, steps)| Skinning::moved(pose, steps)).collect()
    }

    /// How far poses are from those that are given, as [`refine_poses`](crate::refinement::refine_poses) weighs it; the mean of the frames.
    fn hold(&self, steps: Tensor<2>) -> Tensor<1> {
        let options = self.context.options.refinement;
        let [frame_count, unknowns] = steps.dims();
        let turns = steps.clone().slice([0..frame_count, 0..unknowns - 3]).square().sum();
        let translations = steps.slice([0..frame_count, unknowns - 3..unknowns]).square().sum();
        let share = 1.0 / frame_count as f64;
        turns * (options.rotation_weight * share) + translations * (options.translation_weight * share)
    }

    /// Posed vertices of frames in the poses `given` after `steps` (frames · vertices, 3): LBS_θ(v + f_d(γ(Q(v)), θ̄(v))). θ̄ is that of the
    /// moved pose, but nothing flows back through it: a pose is to fit the scan, not to ask the network for other clothes.
    fn posed(&self, network: &Network, given: &[Pose], steps: Option<Tensor<2>>) -> Tensor<2> {
        let domain = &self.context.domains[0];
        let vertex_count = domain.canonical.len();
        let features = self.features;
        let asked = match &steps {
            Some(steps) => self.moved(given, &numbers(steps.clone())),
            None => given.to_vec(),
        };
        let axis_angles: Vec<Vec<[f32; 3]>> = asked.iter().map(Features::axis_angles).collect();
        let count = given.len() * vertex_count;
        let mut input = vec![0.0; count * features.length()];
        input.par_chunks_exact_mut(features.length()).enumerate().for_each(|(row, input)| {
            let (frame, vertex) = (row / vertex_count, row % vertex_count);
            features.fill(domain.canonical[vertex], domain.masks[vertex], &axis_angles[frame], input);
        });
        let input = Tensor::<2>::from_data(TensorData::new(input, [count, features.length()]), &self.device);
        let offsets = network.forward(input) * OUTPUT_SCALE;
        self.skinning.posed(given, steps, offsets)
    }
}

/// Everything that the result depends on.
fn inputs(context: &TrainContext) -> anyhow::Result<Fingerprint> {
    let start = context.ingredients("deformation");
    let all = context.samples.iter().try_fold(start, |all, &sample| {
        let frame = context.frame_ingredients("deformation", sample)?.finish();
        anyhow::Ok(all.bytes(&frame.0))
    })?;
    Ok(all.finish())
}

fn read_scan(context: &TrainContext, sample: Sample) -> anyhow::Result<Scan> {
    let scan = context.scan(sample)?;
    Ok(Scan::new(scan.points, scan.weights, scan.camera))
}

/// Anchors stand on the finest level: each as the sum of level-0 vertices that subdivision makes it of.
fn anchor_rows(context: &TrainContext) -> Rows {
    let subdivision = &context.subdivision;
    let level_count = subdivision.level_count();
    let mut rows = vec![Vec::new(); context.anchors.len()];
    // The transpose of refinement takes an impulse at an anchor to its weights; three anchors go at a time, one an axis.
    rows.par_chunks_mut(3).zip(context.anchors.par_chunks(3)).for_each(|(rows, anchors)| {
        let mut fine = vec![Vec3A::ZERO; subdivision.vertex_count(level_count)];
        for (axis, &anchor) in anchors.iter().enumerate() {
            fine[anchor as usize][axis] = 1.0;
        }
        for level in (0..level_count).rev() {
            let mut coarse = vec![Vec3A::ZERO; subdivision.vertex_count(level)];
            subdivision.restrict(context.options.scheme, level, &fine, &mut coarse);
            fine = coarse;
        }
        for (vertex, weights) in fine.iter().enumerate() {
            for (axis, row) in rows.iter_mut().enumerate() {
                if weights[axis] != 0.0 {
                    row.push((vertex as u32, weights[axis]));
                }
            }
        }
    });
    Rows::new(&rows)
}
