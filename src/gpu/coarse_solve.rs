//! The coarsest level, solved by two products with W = L⁻¹.

use super::inverse_factor::{InverseFactor, NONE};
use super::kernel::{Dispatch, Gpu, Kernel, Shader, WORKGROUP_LIMIT, numbered, storage, storage_of, vectors};
use crate::solver::FactorParts;
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("coarse_solve.wgsl"));

/// Columns of a workgroup of `backward`.
const COLUMNS: usize = 16;

/// Host twin of `Row` in coarse_solve.wgsl.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Row {
    origin: u32,
    first_column: u32,
    reciprocal_diagonal: f32,
    run_end: u32,
    next_run: u32,
}

/// W in GPU buffers, and its two products.
pub(super) struct GpuCoarseSolve {
    forward: Kernel,
    backward: Kernel,
    rows: Buffer,
    values: Buffer,
    vertices: Buffer,
    between: Buffer,
    count: usize,
}

impl GpuCoarseSolve {
    pub fn new(gpu: &Gpu, factor: &FactorParts<'_>) -> Self {
        let inverse = InverseFactor::new(factor);
        let count = inverse.steps.len();
        let mut rows: Vec<Row> = (0..count)
            .map(|i| {
                let step = inverse.steps[i] as usize;
                Row {
                    // Wraps below zero; adding a column that the row has wraps back.
                    origin: (inverse.offsets[i] as u32).wrapping_sub(inverse.first_columns[i]),
                    first_column: inverse.first_columns[i],
                    reciprocal_diagonal: factor.reciprocal_diagonal[step],
                    run_end: i as u32,
                    next_run: inverse.parents[i],
                }
            })
            .collect();
        for i in (0..count).rev() {
            if inverse.parents[i] != NONE && inverse.parents[i] as usize == i + 1 {
                (rows[i].run_end, rows[i].next_run) = (rows[i + 1].run_end, rows[i + 1].next_run);
            }
        }
        let values = storage(gpu, "coarse solve: values", 2 * inverse.offsets[count]);
        inverse.for_each_rows(factor, |offset, rows| {
            gpu.queue.write_buffer(&values, 2 * offset as u64, bytemuck::cast_slice(rows));
        });
        let vertices: Vec<u32> = inverse.steps.iter().map(|&step| factor.permutation[step as usize]).collect();
        let shader = Shader::new(gpu, "coarse solve", SOURCE);
        Self {
            forward: shader.kernel("forward"),
            backward: shader.kernel("backward"),
            rows: storage_of(gpu, "coarse solve: rows", &rows),
            values,
            vertices: storage_of(gpu, "coarse solve: vertices", &vertices),
            between: vectors(gpu, "coarse solve: between", count),
            count,
        }
    }

    /// x = A₀⁻¹ b, nearly.
    pub fn solve(&self, b: &Buffer, x: &Buffer) -> [Dispatch; 2] {
        let high = self.count.div_ceil(WORKGROUP_LIMIT);
        let groups = [self.count.div_ceil(high.max(1)) as u32, high as u32, 1];
        let forward = numbered([&self.rows, &self.values, b, &self.between, &self.vertices]);
        let backward = numbered([&self.rows, &self.values, &self.between, x, &self.vertices]);
        [
            self.forward.in_groups(groups, &forward),
            self.backward.in_groups([self.count.div_ceil(COLUMNS) as u32, 1, 1], &backward),
        ]
    }
}
