//! The preconditioner: one V-cycle, the same as the CPU's (`solver::multigrid`).

use super::coarse_solve::GpuCoarseSolve;
use super::kernel::{Dispatch, Gpu, vectors};
use super::normal_operator::{GpuOperator, OperatorKernels};
use super::sparse::{GpuMatrix, LoopMatrices, SparseKernels};
use crate::mesh::Subdivision;
use crate::solver::{LevelParts, Solver};
use wgpu::Buffer;

/// A level above the coarsest.
pub(super) struct GpuLevel {
    pub operator: GpuOperator,
    prolongation: GpuMatrix,
    restriction: GpuMatrix,
    steps: usize,
}

/// What a cycle works on, on one level. Whoever starts one there may use the fields for what is over before or after it.
pub(super) struct LevelFields {
    pub side: Buffer,
    pub correction: Buffer,
    pub residual: Buffer,
}

/// Levels above the coarsest, finest first, and the solve there.
pub(super) struct GpuMultigrid {
    pub levels: Vec<GpuLevel>,
    /// Of each level and of the coarsest.
    pub fields: Vec<LevelFields>,
    coarse_solve: GpuCoarseSolve,
    sparse: SparseKernels,
}

impl GpuLevel {
    fn new(gpu: &Gpu, level: &LevelParts<'_>, loops: &LoopMatrices, index: usize) -> Self {
        Self {
            operator: GpuOperator::new(gpu, &level.operator, level.scaling, level.weights),
            prolongation: loops.upwards(index - 1).clone(),
            restriction: loops.downwards(index - 1).clone(),
            steps: level.steps,
        }
    }
}

impl LevelFields {
    fn new(gpu: &Gpu, vertex_count: usize) -> Self {
        let field = |label| vectors(gpu, label, vertex_count);
        Self {
            side: field("multigrid: right side"),
            correction: field("multigrid: correction"),
            residual: field("multigrid: residual"),
        }
    }
}

impl GpuMultigrid {
    pub fn new(gpu: &Gpu, solver: &Solver, subdivision: &Subdivision, loops: &LoopMatrices) -> Self {
        let finest = subdivision.level_count();
        let levels = solver.level_parts().enumerate();
        let fields = (0..=finest).rev().map(|level| LevelFields::new(gpu, subdivision.vertex_count(level)));
        Self {
            levels: levels.map(|(i, level)| GpuLevel::new(gpu, &level, loops, finest - i)).collect(),
            fields: fields.collect(),
            coarse_solve: GpuCoarseSolve::new(gpu, &solver.factor_parts()),
            sparse: SparseKernels::new(gpu),
        }
    }

    /// Leaves M⁻¹ side in the correction, both of the level that is `first` levels below the finest.
    pub fn cycle(&self, kernels: &OperatorKernels, first: usize) -> Vec<Dispatch> {
        let mut dispatches = Vec::new();
        self.descend(kernels, first, &mut dispatches);
        dispatches
    }

    fn descend(&self, kernels: &OperatorKernels, index: usize, out: &mut Vec<Dispatch>) {
        let LevelFields { side, correction, residual } = &self.fields[index];
        let Some(GpuLevel { operator, prolongation, restriction, steps }) = self.levels.get(index) else {
            out.extend(self.coarse_solve.solve(side, correction));
            return;
        };
        let coarse = &self.fields[index + 1];
        out.push(operator.smooth_first(kernels, side, correction));
        out.extend(operator.residual(kernels, correction, side, residual));
        for _ in 1..*steps {
            out.push(operator.smooth_more(kernels, residual, correction));
            out.extend(operator.residual(kernels, correction, side, residual));
        }
        out.push(self.sparse.apply(restriction, residual, &coarse.side));
        self.descend(kernels, index + 1, out);
        out.push(self.sparse.add(prolongation, &coarse.correction, correction));
        for _ in 0..*steps {
            out.extend(operator.residual(kernels, correction, side, residual));
            out.push(operator.smooth_more(kernels, residual, correction));
        }
    }
}
