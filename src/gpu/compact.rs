//! A compact surface function's tables, packed for compact.wgsl.

use super::kernel::{Dispatch, Gpu, Shader, storage, storage_of};
use crate::network::Compact;
use crate::wgsl::wgsl;
use crease_posing::order::places_by;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("frame.wgsl"), include_str!("compact.wgsl"));

/// Host twin of `Region` in compact.wgsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Region {
    mask: u32,
    kernel_length: f32,
    basis_count: u32,
    first_coefficient: u32,
    first_factor: u32,
    centre_count: u32,
    recalled_count: u32,
    joint_count: u32,
    fade: [f32; 2],
}

/// Host twin of `Row` in compact.wgsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Row {
    mean: [f32; 3],
    first_word: u32,
    first_quad: u32,
    quad_count: u32,
    padding: [u32; 2],
}

/// Evaluates `function` into `values`, one vector for each vertex of its level.
pub(super) fn evaluate(
    gpu: &Gpu,
    function: &Compact,
    joint_count: usize,
    frame: &Buffer,
    values: &Buffer,
    vertex_count: usize,
) -> Vec<Dispatch> {
    let packed = Packed::new(function, joint_count, vertex_count);
    let buffer = |bytes: &[u8]| storage_of(gpu, "compact", bytes);
    let factors = storage(gpu, "compact: factors", packed.factor_count * size_of::<f32>());
    let shader = Shader::new(gpu, "compact", SOURCE);
    let coefficients = shader.kernel("coefficients").in_groups(
        [packed.regions.len() as u32, 1, 1],
        &[
            (0, frame),
            (1, &buffer(bytemuck::cast_slice(&packed.regions))),
            (2, &buffer(bytemuck::cast_slice(&function.centres))),
            (3, &buffer(bytemuck::cast_slice(&packed.coefficients))),
            (4, &factors),
        ],
    );
    let tables = shader.kernel("tables").over(
        vertex_count,
        &[
            (5, &buffer(bytemuck::cast_slice(&packed.row_offsets))),
            (6, &buffer(bytemuck::cast_slice(&packed.rows))),
            (7, &buffer(bytemuck::cast_slice(&packed.basis))),
            (8, &factors),
            (9, values),
        ],
    );
    vec![coefficients, tables]
}

/// Tables by vertex in place of by region: a thread gathers all rows of its vertex.
struct Packed {
    regions: Vec<Region>,
    coefficients: Vec<f32>,
    factor_count: usize,
    row_offsets: Vec<u32>,
    rows: Vec<Row>,
    basis: Vec<u32>,
}

impl Packed {
    fn new(function: &Compact, joint_count: usize, vertex_count: usize) -> Self {
        let centre_count = function.centre_count as usize;
        let mut packed = Self {
            regions: Vec::new(),
            coefficients: Vec::new(),
            factor_count: 0,
            row_offsets: Vec::with_capacity(vertex_count + 1),
            rows: Vec::with_capacity(function.row_vertices.len()),
            basis: Vec::with_capacity(function.basis.len() / 4),
        };
        // For each row of the file: region and where its basis starts.
        let mut places = Vec::with_capacity(function.row_vertices.len());
        let (mut first_basis, mut first_step) = (0, 0);
        for (index, region) in function.regions.iter().enumerate() {
            let basis_count = region.basis_count as usize;
            for row in 0..(region.rows.1 - region.rows.0) as usize {
                places.push((index, first_basis + 3 * basis_count * row));
            }
            first_basis += 3 * basis_count * (region.rows.1 - region.rows.0) as usize;
            packed.regions.push(Region {
                mask: region.mask.0,
                kernel_length: region.kernel_length,
                basis_count: region.basis_count,
                first_coefficient: packed.coefficients.len() as u32,
                first_factor: packed.factor_count as u32,
                centre_count: function.centre_count,
                recalled_count: region.recalled_count() as u32,
                joint_count: joint_count as u32,
                fade: region.fade.unwrap_or_default(),
            });
            for (matrix, width) in
                [(&region.coefficient_from_kernel, centre_count), (&region.recalled, region.recalled_count())]
            {
                for k in 0..basis_count {
                    let row = &matrix[k * width..][..width];
                    let step = function.basis_step[first_step + k];
                    packed.coefficients.extend(row.iter().map(|value| step * value));
                }
            }
            first_step += basis_count;
            packed.factor_count += basis_count.next_multiple_of(4);
        }
        packed.add_rows(function, &places, vertex_count);
        packed
    }

    fn add_rows(&mut self, function: &Compact, places: &[(usize, usize)], vertex_count: usize) {
        let mut order = places_by(function.row_vertices.iter().copied()).peekable();
        for vertex in 0..vertex_count {
            self.row_offsets.push(self.rows.len() as u32);
            while let Some(row) = order.next_if(|&row| function.row_vertices[row] as usize == vertex) {
                let (region, first) = places[row];
                let region = self.regions[region];
                self.rows.push(Row {
                    mean: [0, 1, 2].map(|axis| function.mean[3 * row + axis]),
                    first_word: self.basis.len() as u32,
                    first_quad: region.first_factor / 4,
                    quad_count: region.basis_count.div_ceil(4),
                    padding: [0; 2],
                });
                let basis = &function.basis[first..][..3 * region.basis_count as usize];
                for four in basis.chunks(12) {
                    for axis in 0..3 {
                        let byte = |k: usize| four.get(3 * k + axis).copied().unwrap_or(0) as u8;
                        self.basis.push(u32::from_le_bytes([0, 1, 2, 3].map(byte)));
                    }
                }
            }
        }
        self.row_offsets.push(self.rows.len() as u32);
    }
}
