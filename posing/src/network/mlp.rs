//! Plain multilayer perceptrons, any width and depth, ReLU between layers.

use super::{Domain, Scratch};
use crate::encoding::PositionalEncoding;
use crate::pose_feature::PoseMask;
use crate::rig::Pose;
use crate::rotation::axis_angle_from_quat;
use crate::threads::for_rows;
use glam::Vec3A;
use std::cell::RefCell;

/// y = W x + b.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// (outputs, inputs), row-major.
    pub weight: Vec<f32>,
    /// (outputs).
    pub bias: Vec<f32>,
}

impl Layer {
    /// Number of inputs.
    pub fn input_count(&self) -> usize {
        self.weight.len() / self.bias.len()
    }

    /// Number of outputs.
    pub fn output_count(&self) -> usize {
        self.bias.len()
    }
}

/// f(γ(Q), θ̄) with θ̄ the masked axis-angle numbers, three per joint (root always zero).
#[derive(Clone, Debug, PartialEq)]
pub struct Mlp {
    /// Level on whose vertices it is evaluated.
    pub level: u32,
    /// γ.
    pub encoding: PositionalEncoding,
    /// First layer takes γ(Q) then θ̄; the last gives three numbers.
    pub layers: Vec<Layer>,
    /// The output is the last layer's times this (targets are standardised in training).
    pub output_scale: f32,
}

/// Rows evaluated together, so that their activations stay in the cache.
const BATCH: usize = 64;
/// Rows of a tile: activations are stored tile by tile, one lane a row, so that the inner loop is contiguous.
const LANES: usize = 8;
/// Outputs computed together, so that each loaded activation is used more than once.
const OUTPUTS: usize = 4;

thread_local! {
    /// What the layers of one batch take and give. Every thread has its own.
    static ACTIVATIONS: RefCell<Activations> = const { RefCell::new(Activations::new()) };
}

struct Activations {
    encoded: Vec<f32>,
    input: Vec<f32>,
    output: Vec<f32>,
}

impl Activations {
    const fn new() -> Self {
        Self { encoded: Vec::new(), input: Vec::new(), output: Vec::new() }
    }
}

impl Mlp {
    /// See [`super::SurfaceFunction::evaluate`].
    pub fn evaluate(&self, domain: &Domain, pose: &Pose, scratch: &mut Scratch, out: &mut [Vec3A]) {
        let Scratch { masks: distinct, pose_biases, .. } = scratch;
        self.pose_biases(&domain.masks, pose, distinct, pose_biases);
        for_rows(out, |first, out| {
            ACTIVATIONS.with_borrow_mut(|activations| {
                let rows = first..first + out.len();
                let batches = domain.canonical[rows.clone()].chunks(BATCH).zip(domain.masks[rows].chunks(BATCH));
                for ((points, masks), out) in batches.zip(out.chunks_mut(BATCH)) {
                    self.evaluate_batch(points, masks, distinct, pose_biases, activations, out);
                }
            });
        });
    }

    /// One batch at most. `pose_biases` are those of the masks in `distinct`.
    fn evaluate_batch(
        &self,
        points: &[Vec3A],
        masks: &[PoseMask],
        distinct: &[PoseMask],
        pose_biases: &[f32],
        Activations { encoded, input, output }: &mut Activations,
        out: &mut [Vec3A],
    ) {
        let widest = self.layers.iter().map(|layer| layer.input_count().max(layer.output_count())).max().unwrap_or(0);
        encoded.resize(self.encoding.length(), 0.0);
        for activations in [&mut *input, &mut *output] {
            activations.resize(widest * BATCH, 0.0);
        }
        for (row, &point) in points.iter().enumerate() {
            self.encoding.encode(point, encoded);
            for (i, &value) in encoded.iter().enumerate() {
                input[slot(row, i, encoded.len())] = value;
            }
        }
        let first = &self.layers[0];
        let width = first.output_count();
        for (row, mask) in masks.iter().enumerate() {
            let index = distinct.iter().position(|m| m == mask).expect("every mask has its bias");
            for (o, &value) in pose_biases[index * width..][..width].iter().enumerate() {
                output[slot(row, o, width)] = value;
            }
        }
        add_product(&first.weight, first.input_count(), encoded.len(), input, output);
        for layer in &self.layers[1..] {
            output.iter_mut().for_each(|x| *x = x.max(0.0));
            std::mem::swap(input, output);
            let width = layer.output_count();
            for tile in output[..width * BATCH].chunks_exact_mut(width * LANES) {
                for (lanes, &bias) in tile.chunks_exact_mut(LANES).zip(&layer.bias) {
                    lanes.fill(bias);
                }
            }
            add_product(&layer.weight, layer.input_count(), layer.input_count(), input, output);
        }
        for (row, value) in out.iter_mut().enumerate() {
            *value = self.output_scale * Vec3A::from_array([0, 1, 2].map(|axis| output[slot(row, axis, 3)]));
        }
    }

    /// W_θ θ̄ + b of the first layer for each mask that occurs: θ̄ takes few distinct values over the surface.
    fn pose_biases(&self, masks: &[PoseMask], pose: &Pose, distinct: &mut Vec<PoseMask>, biases: &mut Vec<f32>) {
        distinct.clear();
        biases.clear();
        let first = &self.layers[0];
        let encoded_length = self.encoding.length();
        for &mask in masks {
            if distinct.contains(&mask) {
                continue;
            }
            distinct.push(mask);
            let start = biases.len();
            biases.extend(&first.bias);
            for joint in mask.joints() {
                let angles = axis_angle_from_quat(pose.rotations[joint]);
                let column = encoded_length + 3 * joint;
                for (bias, row) in biases[start..].iter_mut().zip(first.weight.chunks_exact(first.input_count())) {
                    *bias += row[column] * angles.x + row[column + 1] * angles.y + row[column + 2] * angles.z;
                }
            }
        }
    }
}

/// Where channel `channel` of row `row` of a batch lies, with `width` channels a row.
fn slot(row: usize, channel: usize, width: usize) -> usize {
    (row / LANES * width + channel) * LANES + row % LANES
}

/// y += W x for one batch; W's rows are `stride` long and their first `input_count` entries are used.
fn add_product(weight: &[f32], stride: usize, input_count: usize, x: &[f32], y: &mut [f32]) {
    let output_count = weight.len() / stride;
    let mut o = 0;
    while o < output_count {
        if o + OUTPUTS <= output_count {
            add_rows::<OUTPUTS>(weight, stride, input_count, output_count, o, x, y);
            o += OUTPUTS;
        } else {
            add_rows::<1>(weight, stride, input_count, output_count, o, x, y);
            o += 1;
        }
    }
}

/// Outputs `o` .. `o + N` of [`add_product`].
fn add_rows<const N: usize>(
    weight: &[f32],
    stride: usize,
    input_count: usize,
    output_count: usize,
    o: usize,
    x: &[f32],
    y: &mut [f32],
) {
    let rows: [&[f32]; N] = std::array::from_fn(|n| &weight[(o + n) * stride..][..input_count]);
    for tile in 0..BATCH / LANES {
        let x = &x[tile * input_count * LANES..][..input_count * LANES];
        let x = x.as_chunks::<LANES>().0;
        let rows = rows.map(|row| &row[..x.len()]);
        let mut sums = [[0.0f32; LANES]; N];
        for (i, lanes) in x.iter().enumerate() {
            for n in 0..N {
                let w = rows[n][i];
                for lane in 0..LANES {
                    sums[n][lane] += w * lanes[lane];
                }
            }
        }
        for n in 0..N {
            let y = &mut y[(tile * output_count + o + n) * LANES..][..LANES];
            for lane in 0..LANES {
                y[lane] += sums[n][lane];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    /// Small repeatable numbers in −1 .. 1.
    fn numbers(count: usize, seed: u32) -> Vec<f32> {
        (0..count).map(|i| ((i as f32 * 12.9898 + seed as f32 * 78.233).sin() * 43758.547).fract()).collect()
    }

    fn random_mlp(widths: &[usize]) -> Mlp {
        let layers = widths
            .windows(2)
            .enumerate()
            .map(|(i, w)| Layer { weight: numbers(w[0] * w[1], i as u32), bias: numbers(w[1], 100 + i as u32) })
            .collect();
        Mlp { level: 0, encoding: PositionalEncoding { frequency_count: 2 }, layers, output_scale: 0.5 }
    }

    fn domain(count: usize) -> Domain {
        let coordinates = numbers(3 * count, 7);
        Domain {
            canonical: coordinates.chunks(3).map(Vec3A::from_slice).collect(),
            masks: (0..count).map(|i| PoseMask([0b10, 0b0, 0b110][i % 3])).collect(),
        }
    }

    fn bent() -> Pose {
        Pose {
            rotations: vec![Quat::from_rotation_y(1.0), Quat::from_rotation_x(0.5), Quat::from_rotation_z(-0.8)],
            translation: Vec3::ONE,
        }
    }

    /// The definition, row by row in f64.
    fn naive(mlp: &Mlp, point: Vec3A, mask: PoseMask, pose: &Pose) -> [f64; 3] {
        let mut encoded = vec![0.0; mlp.encoding.length()];
        mlp.encoding.encode(point, &mut encoded);
        for joint in 0..pose.rotations.len() {
            let angles = if mask.contains(joint) { axis_angle_from_quat(pose.rotations[joint]) } else { Vec3::ZERO };
            encoded.extend(angles.to_array());
        }
        let mut x: Vec<f64> = encoded.into_iter().map(f64::from).collect();
        for (i, layer) in mlp.layers.iter().enumerate() {
            x = layer
                .weight
                .chunks(layer.input_count())
                .zip(&layer.bias)
                .map(|(row, &bias)| {
                    let sum = row.iter().zip(&x).map(|(&w, x)| f64::from(w) * x).sum::<f64>() + f64::from(bias);
                    if i + 1 < mlp.layers.len() { sum.max(0.0) } else { sum }
                })
                .collect();
        }
        [0, 1, 2].map(|axis| x[axis] * f64::from(mlp.output_scale))
    }

    #[test]
    fn agrees_with_the_definition_for_odd_widths_and_counts() {
        // 15 encoded numbers and nine angles; 131 rows leave a partial batch.
        for widths in [&[24, 13, 21, 3][..], &[24, 3], &[24, 16, 3]] {
            let (mlp, domain, pose) = (random_mlp(widths), domain(131), bent());
            let mut out = vec![Vec3A::NAN; 131];
            mlp.evaluate(&domain, &pose, &mut Scratch::default(), &mut out);
            for (v, value) in out.iter().enumerate() {
                let expected = naive(&mlp, domain.canonical[v], domain.masks[v], &pose);
                for axis in 0..3 {
                    let error = (f64::from(value[axis]) - expected[axis]).abs();
                    assert!(error < 2e-5, "vertex {v}: {value} for {expected:?}");
                }
            }
        }
    }

    #[test]
    fn joints_outside_the_mask_and_the_root_change_nothing() {
        let (mlp, domain) = (random_mlp(&[24, 16, 3]), domain(30));
        let evaluate = |pose: &Pose| {
            let mut out = vec![Vec3A::ZERO; 30];
            mlp.evaluate(&domain, pose, &mut Scratch::default(), &mut out);
            out
        };
        let mut other = bent();
        other.rotations[0] = Quat::IDENTITY;
        other.rotations[2] = Quat::IDENTITY;
        let (before, after) = (evaluate(&bent()), evaluate(&other));
        for v in 0..30 {
            let listens = domain.masks[v].contains(2);
            assert_eq!(before[v] != after[v], listens, "vertex {v}");
        }
    }
}
