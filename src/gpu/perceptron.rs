//! Plain multilayer perceptrons: tiled matrix products, batch of vertices by batch.

use super::kernel::{Dispatch, Gpu, Shader, storage, storage_of, uniform_of};
use crate::network::{Domain, Mlp};
use crate::pose_feature::PoseMask;
use crate::wgsl::wgsl;
use half::f16;
use wgpu::{Buffer, BufferBinding, Features};

/// WGSL of the pass where numbers of 16 bits are at hand.
pub(super) const HALF_SOURCE: &str =
    wgsl!("enable f16;\nalias real = f16;\n", include_str!("frame.wgsl"), include_str!("perceptron.wgsl"));

/// WGSL of the pass everywhere.
pub(super) const SINGLE_SOURCE: &str =
    wgsl!("alias real = f32;\n", include_str!("frame.wgsl"), include_str!("perceptron.wgsl"));

/// Most vertices whose activations are in memory at a time.
const BATCH: usize = 8192;

/// Vertices and outputs of a workgroup of `hidden`, and inputs that it takes at a time.
const ROWS: usize = 128;
const OUTPUTS: usize = 64;
const INPUTS: usize = 16;

/// Host twin of `Layer` in perceptron.wgsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct LayerSizes {
    input_count: u32,
    output_count: u32,
    row_count: u32,
    encoded_count: u32,
    frequency_count: u32,
    output_scale: f32,
}

/// Numbers in the format of `real`.
struct Real {
    is_half: bool,
}

/// A layer in GPU buffers.
struct GpuLayer {
    sizes: Buffer,
    weight: Buffer,
    bias: Buffer,
    /// For each vertex of a batch the row of `bias`; a layer after the first has one row.
    output_count: usize,
}

/// Multiplications and additions of one evaluation, each counted as one operation.
pub(super) fn operations(mlp: &Mlp, vertex_count: usize) -> u64 {
    let encoded = mlp.encoding.length();
    let products = |(i, layer): (usize, &crate::network::Layer)| {
        let input_count = if i == 0 { encoded } else { layer.input_count() };
        (input_count * layer.output_count()) as u64
    };
    2 * vertex_count as u64 * mlp.layers.iter().enumerate().map(products).sum::<u64>()
}

/// Evaluates `mlp` into `values`, one vector for each vertex of `domain`.
pub(super) fn evaluate(gpu: &Gpu, mlp: &Mlp, domain: &Domain, frame: &Buffer, values: &Buffer) -> Vec<Dispatch> {
    let real = Real { is_half: gpu.device.features().contains(Features::SHADER_F16) };
    let shader = Shader::new(gpu, "perceptron", if real.is_half { HALF_SOURCE } else { SINGLE_SOURCE });
    let vertex_count = domain.canonical.len();
    let row_count = vertex_count.next_multiple_of(ROWS).min(BATCH);
    let padded_count = vertex_count.next_multiple_of(row_count);

    let (distinct, mut mask_rows) = mask_rows(&domain.masks);
    mask_rows.resize(padded_count, 0);
    let mut points: Vec<[f32; 4]> = domain.canonical.iter().map(|point| point.extend(0.0).to_array()).collect();
    points.resize(padded_count, [0.0; 4]);
    let (points, mask_rows) =
        (storage_of(gpu, "perceptron: points", &points), storage_of(gpu, "perceptron: masks", &mask_rows));
    let no_rows = storage(gpu, "perceptron: no masks", row_count * size_of::<u32>());

    let layers: Vec<GpuLayer> =
        (0..mlp.layers.len()).map(|index| GpuLayer::new(gpu, mlp, index, row_count, distinct.len(), &real)).collect();
    let widest = layers.iter().map(|layer| layer.output_count).max().unwrap_or(0);
    let widest = widest.max(mlp.encoding.length().next_multiple_of(INPUTS));
    let activations = ["a", "b"].map(|_| storage(gpu, "perceptron: activations", widest * row_count * real.size()));

    let mut dispatches = vec![pose_biases(gpu, &shader, mlp, &distinct, &layers[0], frame)];
    let [encode, hidden, last] = ["encode", "hidden", "last"].map(|entry| shader.kernel(entry));
    for first in (0..padded_count).step_by(row_count) {
        let batch = Batch { first, row_count, vertex_count: row_count.min(vertex_count - first) };
        let groups = [(row_count / 64) as u32, 1, 1];
        let [mut input, mut output] = activations.each_ref();
        dispatches.push(
            encode.with_ranges(groups, &[(1, all(&layers[0].sizes)), (6, batch.rows(&points, 16)), (7, all(input))]),
        );
        for (index, layer) in layers.iter().enumerate() {
            let bias_rows = if index == 0 { batch.rows(&mask_rows, 4) } else { all(&no_rows) };
            let mut bindings = vec![(1, all(&layer.sizes)), (9, all(&layer.bias)), (10, bias_rows)];
            if index + 1 < layers.len() {
                bindings.extend([(8, all(&layer.weight)), (11, all(input)), (12, all(output))]);
                let groups = [(row_count / ROWS) as u32, (layer.output_count / OUTPUTS) as u32, 1];
                dispatches.push(hidden.with_ranges(groups, &bindings));
                std::mem::swap(&mut input, &mut output);
            } else {
                bindings.extend([(13, all(input)), (14, all(&layer.weight)), (15, batch.values(values))]);
                dispatches.push(last.with_ranges(groups, &bindings));
            }
        }
    }
    dispatches
}

fn all(buffer: &Buffer) -> BufferBinding<'_> {
    buffer.as_entire_buffer_binding()
}

/// Vertices that are evaluated together.
struct Batch {
    first: usize,
    row_count: usize,
    /// Without the padding.
    vertex_count: usize,
}

impl Batch {
    /// This batch's part of a buffer that is padded to whole batches.
    fn rows<'a>(&self, buffer: &'a Buffer, bytes: usize) -> BufferBinding<'a> {
        self.part(buffer, bytes, self.row_count)
    }

    fn values<'a>(&self, buffer: &'a Buffer) -> BufferBinding<'a> {
        self.part(buffer, 16, self.vertex_count)
    }

    fn part<'a>(&self, buffer: &'a Buffer, bytes: usize, count: usize) -> BufferBinding<'a> {
        let size = std::num::NonZero::new((bytes * count) as u64);
        BufferBinding { buffer, offset: (bytes * self.first) as u64, size }
    }
}

/// The distinct masks, and for each vertex which it is.
fn mask_rows(masks: &[PoseMask]) -> (Vec<u32>, Vec<u32>) {
    let mut distinct: Vec<u32> = Vec::new();
    let rows = masks.iter().map(|mask| {
        let known = distinct.iter().position(|&other| other == mask.0);
        known.unwrap_or_else(|| {
            distinct.push(mask.0);
            distinct.len() - 1
        }) as u32
    });
    let rows = rows.collect();
    (distinct, rows)
}

/// θ̄'s share of the first layer, for each mask that occurs.
fn pose_biases(
    gpu: &Gpu,
    shader: &Shader<'_>,
    mlp: &Mlp,
    distinct: &[u32],
    first: &GpuLayer,
    frame: &Buffer,
) -> Dispatch {
    let layer = &mlp.layers[0];
    let columns = mlp.encoding.length()..layer.input_count();
    let weight = transposed(&layer.weight, layer.input_count(), columns, first.output_count);
    let mut bias = layer.bias.clone();
    bias.resize(first.output_count, 0.0);
    shader.kernel("pose_biases").in_groups(
        [(first.output_count / 64) as u32, distinct.len() as u32, 1],
        &[
            (0, frame),
            (1, &first.sizes),
            (2, &storage_of(gpu, "perceptron: distinct masks", distinct)),
            (3, &storage_of(gpu, "perceptron: weight of the pose", &weight)),
            (4, &storage_of(gpu, "perceptron: bias", &bias)),
            (5, &first.bias),
        ],
    )
}

/// The given columns of a matrix with rows of `stride`, each as a row filled up with zeros to `padded` numbers.
fn transposed(weight: &[f32], stride: usize, columns: std::ops::Range<usize>, padded: usize) -> Vec<f32> {
    let mut out = vec![0.0; columns.len() * padded];
    for (output, row) in weight.chunks_exact(stride).enumerate() {
        for (i, &value) in row[columns.clone()].iter().enumerate() {
            out[i * padded + output] = value;
        }
    }
    out
}

impl GpuLayer {
    fn new(gpu: &Gpu, mlp: &Mlp, index: usize, row_count: usize, mask_count: usize, real: &Real) -> Self {
        let layer = &mlp.layers[index];
        let is_last = index + 1 == mlp.layers.len();
        let used = if index == 0 { mlp.encoding.length() } else { layer.input_count() };
        let input_count = used.next_multiple_of(INPUTS);
        let output_count = layer.output_count().next_multiple_of(OUTPUTS);
        let sizes = LayerSizes {
            input_count: input_count as u32,
            output_count: output_count as u32,
            row_count: row_count as u32,
            encoded_count: mlp.encoding.length() as u32,
            frequency_count: mlp.encoding.frequency_count,
            output_scale: mlp.output_scale,
        };
        // The last layer reads four numbers an input.
        let stride = if is_last { 4 } else { output_count };
        let mut weight = transposed(&layer.weight, layer.input_count(), 0..used, stride);
        weight.resize(input_count * stride, 0.0);
        let bias = if index == 0 {
            storage(gpu, "perceptron: bias of each mask", mask_count * output_count * size_of::<f32>())
        } else {
            let mut bias = layer.bias.clone();
            bias.resize(output_count, 0.0);
            storage_of(gpu, "perceptron: bias", &bias)
        };
        let weight = if is_last {
            storage_of(gpu, "perceptron: weight", &weight)
        } else {
            storage_of(gpu, "perceptron: weight", &real.bytes(&weight))
        };
        Self { sizes: uniform_of(gpu, "perceptron: layer", &sizes), weight, bias, output_count }
    }
}

impl Real {
    fn size(&self) -> usize {
        if self.is_half { size_of::<f16>() } else { size_of::<f32>() }
    }

    fn bytes(&self, numbers: &[f32]) -> Vec<u8> {
        if self.is_half {
            numbers.iter().flat_map(|&number| f16::from_f32(number).to_le_bytes()).collect()
        } else {
            bytemuck::cast_slice(numbers).to_vec()
        }
    }
}
