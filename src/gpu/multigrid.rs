//! The preconditioner: one V-cycle, the same as the CPU's (`solver::multigrid`).

use super::coarse_solve::GpuCoarseSolve;
use super::kernel::{Dispatch, vectors};
use super::normal_operator::{GpuOperator, OperatorKernels};
use super::sparse::{GpuMatrix, SparseKernels, stencils};
use crate::mesh::{Scheme, Subdivision};
use crate::solver::{LevelParts, Solver};
use wgpu::{Buffer, Device};

/// A level above the coarsest.
pub(super) struct GpuLevel {
    pub operator: GpuOperator,
    prolongation: GpuMatrix,
    restriction: GpuMatrix,
    steps: usize,
    residual: Buffer,
    /// The next coarser level's right side and solution.
    coarse_side: Buffer,
    coarse_correction: Buffer,
}

/// Levels above the coarsest, finest first, and the solve there.
pub(super) struct GpuMultigrid {
    pub levels: Vec<GpuLevel>,
    coarse_solve: GpuCoarseSolve,
    sparse: SparseKernels,
}

impl GpuLevel {
    fn new(device: &Device, level: &LevelParts<'_>, subdivision: &Subdivision, index: usize) -> Self {
        let prolongation = stencils(subdivision, Scheme::Loop, index - 1);
        let coarse = |label| vectors(device, label, subdivision.vertex_count(index - 1));
        Self {
            operator: GpuOperator::new(device, &level.operator, level.scaling, level.weights, subdivision, index),
            prolongation: GpuMatrix::new(device, &prolongation),
            restriction: GpuMatrix::new(device, &prolongation.transposed()),
            steps: level.steps,
            residual: vectors(device, "multigrid: residual", subdivision.vertex_count(index)),
            coarse_side: coarse("multigrid: right side"),
            coarse_correction: coarse("multigrid: correction"),
        }
    }
}

impl GpuMultigrid {
    pub fn new(device: &Device, solver: &Solver, subdivision: &Subdivision) -> Self {
        let finest = subdivision.level_count();
        let levels = solver.level_parts().enumerate();
        Self {
            levels: levels.map(|(i, level)| GpuLevel::new(device, &level, subdivision, finest - i)).collect(),
            coarse_solve: GpuCoarseSolve::new(device, &solver.factor_parts()),
            sparse: SparseKernels::new(device),
        }
    }

    /// correction = M⁻¹ side, on the level `first` levels below the finest.
    pub fn cycle(&self, kernels: &OperatorKernels, first: usize, side: &Buffer, correction: &Buffer) -> Vec<Dispatch> {
        let mut dispatches = Vec::new();
        self.descend(kernels, &self.levels[first..], side, correction, &mut dispatches);
        dispatches
    }

    fn descend(
        &self,
        kernels: &OperatorKernels,
        levels: &[GpuLevel],
        side: &Buffer,
        correction: &Buffer,
        out: &mut Vec<Dispatch>,
    ) {
        let Some((level, coarser)) = levels.split_first() else {
            out.extend(self.coarse_solve.solve(side, correction));
            return;
        };
        let GpuLevel { operator, residual, coarse_side, coarse_correction, steps, .. } = level;
        out.push(operator.smooth_first(kernels, side, correction));
        out.extend(operator.residual(kernels, correction, side, residual));
        for _ in 1..*steps {
            out.push(operator.smooth_more(kernels, residual, correction));
            out.extend(operator.residual(kernels, correction, side, residual));
        }
        out.push(self.sparse.apply(&level.restriction, residual, coarse_side));
        self.descend(kernels, coarser, coarse_side, coarse_correction, out);
        out.push(self.sparse.add(&level.prolongation, coarse_correction, correction));
        for _ in 0..*steps {
            out.extend(operator.residual(kernels, correction, side, residual));
            out.push(operator.smooth_more(kernels, residual, correction));
        }
    }
}
