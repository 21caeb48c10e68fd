//! Sparse matrices on the GPU: subdivision, restriction, prolongation.

use super::kernel::{Dispatch, Gpu, Kernel, Shader, numbered, storage_of};
use crate::mesh::{Scheme, SparseMatrix, Subdivision};
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("sparse.wgsl"));

/// out = M x and out += M x.
pub(super) struct SparseKernels {
    apply: Kernel,
    add: Kernel,
}

/// A matrix in GPU buffers.
#[derive(Clone)]
pub(super) struct GpuMatrix {
    offsets: Buffer,
    entries: Buffer,
    row_count: usize,
}

impl GpuMatrix {
    pub fn new(gpu: &Gpu, matrix: &SparseMatrix) -> Self {
        Self {
            offsets: storage_of(gpu, "matrix: offsets", &matrix.offsets),
            entries: storage_of(gpu, "matrix: entries", &matrix.entries),
            row_count: matrix.row_count(),
        }
    }
}

/// Loop's stencils between all levels: they refine δ and the displacement, and lead between the solver's levels.
pub(super) struct LoopMatrices(Vec<Transfer>);

/// Between a level and the next.
struct Transfer {
    upwards: GpuMatrix,
    downwards: GpuMatrix,
}

impl LoopMatrices {
    pub fn new(gpu: &Gpu, subdivision: &Subdivision) -> Self {
        let transfer = |level| {
            let stencils = subdivision.loop_matrix(level);
            Transfer { upwards: GpuMatrix::new(gpu, &stencils), downwards: GpuMatrix::new(gpu, &stencils.transposed()) }
        };
        // The largest first: the others' lists find room where its were.
        let mut transfers: Vec<Transfer> = (0..subdivision.level_count()).rev().map(transfer).collect();
        transfers.reverse();
        Self(transfers)
    }

    /// From `level` to the next.
    pub fn upwards(&self, level: usize) -> &GpuMatrix {
        &self.0[level].upwards
    }

    /// From the next level to `level`: the transpose.
    pub fn downwards(&self, level: usize) -> &GpuMatrix {
        &self.0[level].downwards
    }
}

/// What [`Subdivision::refine`] applies, from `level` to the next.
pub(super) fn stencils(subdivision: &Subdivision, scheme: Scheme, level: usize) -> SparseMatrix {
    if scheme == Scheme::Loop {
        return subdivision.loop_matrix(level);
    }
    let (coarse_count, edges) = (subdivision.vertex_count(level), subdivision.edges(level));
    let row_count = coarse_count + edges.len();
    let mut stencils = SparseMatrix::with_capacity(row_count, row_count + edges.len(), coarse_count);
    (0..coarse_count as u32).for_each(|k| stencils.push_row(&mut [(k, 1.0)]));
    edges.iter().for_each(|&[a, b]| stencils.push_row(&mut [(a, 0.5), (b, 0.5)]));
    stencils
}

impl SparseKernels {
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(gpu, "sparse", SOURCE);
        Self { apply: shader.kernel("apply"), add: shader.kernel("add") }
    }

    /// out = M x.
    pub fn apply(&self, matrix: &GpuMatrix, x: &Buffer, out: &Buffer) -> Dispatch {
        Self::dispatch(&self.apply, matrix, x, out)
    }

    /// out += M x.
    pub fn add(&self, matrix: &GpuMatrix, x: &Buffer, out: &Buffer) -> Dispatch {
        Self::dispatch(&self.add, matrix, x, out)
    }

    fn dispatch(kernel: &Kernel, matrix: &GpuMatrix, x: &Buffer, out: &Buffer) -> Dispatch {
        kernel.over(matrix.row_count, &numbered([&matrix.offsets, &matrix.entries, x, out]))
    }
}
