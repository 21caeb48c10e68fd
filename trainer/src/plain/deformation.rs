//! f_d as a multilayer perceptron (paper, Pose-dependent base mesh).

use super::descent::{Descent, Material};
use super::energy::{Energy, Scan, Weights};
use super::features::Features;
use super::gather::Rows;
use super::network::Network;
use super::{numbers, training_device};
use crate::checkpoint::Fingerprint;
use crate::context::{DeformationTrainer, Sample, TrainContext};
use crate::resident::Resident;
use anyhow::ensure;
use burn::tensor::{Device, Tensor, TensorData};
use crease::animate::PosedSurface;
use crease::encoding::PositionalEncoding;
use crease::network::{Mlp, SurfaceFunction};
use glam::{Mat3A, Vec3A};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::sync::Arc;

/// The network's numbers are decimetres: offsets of clothes are of that order, and so its outputs and weights are near 1.
const OUTPUT_SCALE: f32 = 0.1;

/// Trains f_d by gradient descent on E_d.
pub struct PlainDeformation;

impl DeformationTrainer for PlainDeformation {
    fn train(&self, context: &TrainContext) -> anyhow::Result<SurfaceFunction> {
        Ok(SurfaceFunction::Mlp(self.fit(context)?.0))
    }
}

/// A training frame: all that does not change while f_d does.
struct TrainingFrame {
    scan: Scan,
    /// The skinned body without offsets, metres.
    body: Vec<Vec3A>,
    /// LBS^rot at each vertex.
    posed_from_canonical: Vec<Mat3A>,
    axis_angles: Vec<[f32; 3]>,
}

impl TrainingFrame {
    fn bytes(&self) -> usize {
        let Self { scan, body, posed_from_canonical, axis_angles } = self;
        let matrices = size_of_val(posed_from_canonical.as_slice());
        scan.bytes() + size_of_val(body.as_slice()) + matrices + size_of_val(axis_angles.as_slice())
    }
}

impl PlainDeformation {
    /// The trained network, and the mean of E_d over each epoch.
    pub fn fit(&self, context: &TrainContext) -> anyhow::Result<(Mlp, Vec<f32>)> {
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
        let read = |index: usize| read_frame(context, context.samples[index]);
        let frame_count = context.samples.len();
        let frames = Resident::new(frame_count, context.options.memory_bytes(), TrainingFrame::bytes, read);
        let lessons =
            Lessons { context, features, frames, energy, device: device.clone(), sizes: [frame_count as u32] };
        let (network, history) = descent.run(context, &device, &lessons)?;
        Ok((network.export(0, encoding, OUTPUT_SCALE), history))
    }
}

/// Frames as the network is shown them: all of them are items of one part, and those of a step are read for it.
struct Lessons<'a> {
    context: &'a TrainContext,
    features: Features,
    frames: Resident<'a, TrainingFrame>,
    energy: Energy,
    device: Device,
    sizes: [u32; 1],
}

impl Material for Lessons<'_> {
    type Pool = ();

    fn part_sizes(&self) -> &[u32] {
        &self.sizes
    }

    fn pool(&self, _: &[u32]) -> anyhow::Result<()> {
        Ok(())
    }

    fn energy(&self, network: &Network, (): &(), items: &[u32], generator: &mut Pcg64Mcg) -> anyhow::Result<Tensor<1>> {
        let read = |&index: &u32| self.frames.get(index as usize);
        let frames: Vec<Arc<TrainingFrame>> = items.par_iter().map(read).collect::<anyhow::Result<_>>()?;
        let posed = pose_batch(self.context, self.features, network, &frames, &self.device);
        let positions: Vec<Vec3A> = numbers(posed.clone()).chunks_exact(3).map(Vec3A::from_slice).collect();
        ensure!(positions.iter().all(|p| p.is_finite()), "training the base diverged");
        let drawn: Vec<Scan> = match self.context.options.deformation.points_a_frame {
            0 => Vec::new(),
            count => frames.iter().map(|frame| frame.scan.drawn(count, generator)).collect(),
        };
        let scans: Vec<&Scan> = match drawn.is_empty() {
            true => frames.iter().map(|frame| &frame.scan).collect(),
            false => drawn.iter().collect(),
        };
        self.energy.evaluate(&posed, &positions, &scans)
    }

    fn note(&self, mean: f32) -> String {
        format!("E_d {:.3} mm²", 1e6 * mean)
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

fn read_frame(context: &TrainContext, sample: Sample) -> anyhow::Result<TrainingFrame> {
    let pose = context.pose(sample);
    let scan = context.scan(sample)?;
    let mut surface = PosedSurface::new(&context.subdivision);
    surface.pose(
        &context.rig,
        &[],
        pose,
        &context.subdivision,
        context.options.scheme,
        context.subdivision.level_count(),
    );
    Ok(TrainingFrame {
        scan: Scan::new(scan.points, scan.weights, scan.camera),
        body: surface.positions(0).to_vec(),
        posed_from_canonical: surface.rotations(&context.subdivision, 0).to_vec(),
        axis_angles: Features::axis_angles(pose),
    })
}

/// Posed vertices of the batch's frames (frames · vertices, 3): LBS_θ(v + f_d(γ(Q(v)), θ̄(v))).
fn pose_batch(
    context: &TrainContext,
    features: Features,
    network: &Network,
    batch: &[Arc<TrainingFrame>],
    device: &Device,
) -> Tensor<2> {
    let domain = &context.domains[0];
    let vertex_count = domain.canonical.len();
    let count = batch.len() * vertex_count;
    let mut input = vec![0.0; count * features.length()];
    input.par_chunks_exact_mut(features.length()).enumerate().for_each(|(row, input)| {
        let (frame, vertex) = (row / vertex_count, row % vertex_count);
        features.fill(domain.canonical[vertex], domain.masks[vertex], &batch[frame].axis_angles, input);
    });
    let input = Tensor::<2>::from_data(TensorData::new(input, [count, features.length()]), device);
    let offsets = network.forward(input) * OUTPUT_SCALE;

    // glam's columns, so the middle axis of (rows, columns, 3) is the one to sum over.
    let matrices = batch.iter().flat_map(|frame| &frame.posed_from_canonical);
    let matrices: Vec<f32> = matrices.flat_map(|matrix| matrix.to_cols_array()).collect();
    let matrices = Tensor::<3>::from_data(TensorData::new(matrices, [count, 3, 3]), device);
    let body: Vec<f32> = batch.iter().flat_map(|frame| &frame.body).flat_map(|point| point.to_array()).collect();
    let body = Tensor::<2>::from_data(TensorData::new(body, [count, 3]), device);
    body + (matrices * offsets.reshape([count, 3, 1])).sum_dim(1).reshape([count, 3])
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
