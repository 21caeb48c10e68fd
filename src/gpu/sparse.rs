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
            entries: storage_of(gpu, "matrix: entries", &entries(matrix)),
            row_count: matrix.row_count(),
        }
    }
}

/// Loop's stencils between all levels: they refine δ and the displacement, and lead up from the solver's coarser levels.
pub(super) struct LoopMatrices(Vec<GpuMatrix>);

impl LoopMatrices {
    pub fn new(gpu: &Gpu, subdivision: &Subdivision) -> Self {
        let levels = 0..subdivision.level_count();
        Self(levels.map(|level| GpuMatrix::new(gpu, &stencils(subdivision, Scheme::Loop, level))).collect())
    }

    /// From `level` to the next.
    pub fn upwards(&self, level: usize) -> &GpuMatrix {
        &self.0[level]
    }
}

/// (column, bits of the value), as the shaders read them.
pub(super) fn entries(matrix: &SparseMatrix) -> Vec<[u32; 2]> {
    matrix.columns.iter().zip(&matrix.values).map(|(&column, value)| [column, value.to_bits()]).collect()
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
