//! (LᵀL + w_a S) d = Lᵀ r by a fixed number of preconditioned conjugate-gradient steps. Products and step lengths never leave the GPU.

use super::history::{GpuHistory, HistoryKernels};
use super::kernel::{Dispatch, Gpu, Kernel, Shader, storage, vectors};
use super::multigrid::{GpuMultigrid, LevelFields};
use super::normal_operator::{GpuOperator, OperatorKernels};
use super::sparse::LoopMatrices;
use super::topology::GpuRings;
use crate::mesh::Subdivision;
use crate::solver::Solver;
use crate::wgsl::wgsl;
use wgpu::{Buffer, CommandEncoder};

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("conjugate_gradients.wgsl"));

/// Partial sums of an inner product, and workgroups that make them.
const PARTIAL_COUNT: usize = 64;

/// What the solves on all levels share.
pub(super) struct GpuSolvers {
    kernels: Kernels,
    operators: OperatorKernels,
    histories: HistoryKernels,
    history: GpuHistory,
    multigrid: GpuMultigrid,
    /// Without subdivision there is no level to share an operator with, and nothing is smoothed.
    lone: Option<GpuOperator>,
    finest_level: usize,
}

/// The whole solve on one level, as dispatches.
pub(super) struct GpuSolver {
    /// From the rows' residual to that of the first guess.
    start: Vec<Dispatch>,
    first: Vec<Dispatch>,
    /// Later iterations; the energies of this and the last one swap their places.
    later: [Vec<Dispatch>; 2],
    end: Dispatch,
}

struct Kernels {
    inner_product: Kernel,
    turn: Kernel,
    advance: Kernel,
}

/// What an iteration works on, all on one level.
struct Fields<'a> {
    displacement: &'a Buffer,
    /// The preconditioner's right side, and what it makes of that.
    residual: &'a Buffer,
    preconditioned: &'a Buffer,
    direction: Buffer,
    product: &'a Buffer,
    step_energy: Buffer,
}

impl GpuSolvers {
    pub fn new(gpu: &Gpu, solver: &Solver, subdivision: &Subdivision, loops: &LoopMatrices) -> Self {
        let finest_level = subdivision.level_count();
        let multigrid = GpuMultigrid::new(gpu, solver, subdivision, loops);
        let shader = Shader::new(gpu, "conjugate gradients", SOURCE);
        Self {
            kernels: Kernels {
                inner_product: shader.kernel("inner_product"),
                turn: shader.kernel("turn"),
                advance: shader.kernel("advance"),
            },
            operators: OperatorKernels::new(gpu),
            histories: HistoryKernels::new(gpu),
            history: GpuHistory::new(gpu, subdivision.vertex_count(finest_level)),
            lone: multigrid.levels.is_empty().then(|| {
                let unused = vec![0.0; subdivision.vertex_count(finest_level)];
                GpuOperator::new(gpu, &solver.operator_parts(), &unused, [0.0; 2])
            }),
            multigrid,
            finest_level,
        }
    }

    /// The operator of `level`, one on which the CPU's solver solves, too.
    fn operator(&self, level: usize) -> &GpuOperator {
        let index = self.finest_level - level;
        self.lone.as_ref().unwrap_or_else(|| &self.multigrid.levels[index].operator)
    }

    /// Neighbours on `level`.
    pub fn rings(&self, level: usize) -> &GpuRings {
        self.operator(level).rings()
    }

    /// Makes the next solve start from nothing in place of what the last ones make likely: they were of another level, or are no help.
    pub fn forget(&self, encoder: &mut CommandEncoder) {
        self.history.clear(encoder);
    }

    /// Where δ on `level` may wait until [`Self::row_residual`] is made of it.
    pub fn deltas(&self, level: usize) -> &Buffer {
        &self.fields(level).correction
    }

    /// What [`Self::on_level`] solves from.
    pub fn row_residual(&self, level: usize) -> &Buffer {
        &self.fields(level).residual
    }

    fn fields(&self, level: usize) -> &LevelFields {
        &self.multigrid.fields[self.finest_level - level]
    }

    /// Solves for `displacement` from the rows' residual, both on `level`.
    pub fn on_level(&self, gpu: &Gpu, level: usize, vertex_count: usize, displacement: &Buffer) -> GpuSolver {
        let Self { operators, histories, history, multigrid, .. } = self;
        let operator = self.operator(level);
        let field = |label| vectors(gpu, label, vertex_count);
        let energy = |label| storage(gpu, label, PARTIAL_COUNT * size_of::<[f32; 4]>());
        let right_side = field("solver: right side");
        let LevelFields { side, correction, residual } = self.fields(level);
        let fields = Fields {
            displacement,
            residual: side,
            preconditioned: correction,
            direction: field("solver: direction"),
            // The cycle is over when A is applied to the direction.
            product: residual,
            step_energy: energy("solver: energy of a step"),
        };
        let mut start = vec![operator.right_side(operators, self.row_residual(level), &right_side)];
        start.extend(history.guess(histories, vertex_count, &right_side, displacement));
        // As on the CPU, not of the remembered products: they carry rounding from frame to frame.
        start.extend(operator.residual(operators, displacement, &right_side, side));
        let iteration = |[energy, last_energy]: [&Buffer; 2]| {
            let first = self.finest_level - level;
            let mut dispatches = multigrid.cycle(operators, first);
            dispatches.extend(fields.rest_of_iteration(
                &self.kernels,
                operators,
                operator,
                vertex_count,
                energy,
                last_energy,
            ));
            dispatches
        };
        // An energy of zero turns no direction: the first iteration has no last one. Nothing ever writes to it.
        let (none, even, odd) = (energy("solver: no energy"), energy("solver: energy"), energy("solver: energy"));
        GpuSolver {
            start,
            first: iteration([&even, &none]),
            later: [iteration([&odd, &even]), iteration([&even, &odd])],
            end: history.remember(histories, vertex_count, &right_side, displacement, side),
        }
    }
}

impl GpuSolver {
    /// The dispatches of a solve, in order.
    pub fn dispatches(&self, iterations: u32) -> impl Iterator<Item = &Dispatch> {
        let first = self.first.iter().take(if iterations == 0 { 0 } else { usize::MAX });
        let later = (1..iterations as usize).flat_map(|index| &self.later[(index + 1) % 2]);
        self.start.iter().chain(first).chain(later).chain([&self.end])
    }
}

impl Fields<'_> {
    fn rest_of_iteration(
        &self,
        kernels: &Kernels,
        operators: &OperatorKernels,
        operator: &GpuOperator,
        vertex_count: usize,
        energy: &Buffer,
        last_energy: &Buffer,
    ) -> Vec<Dispatch> {
        let Self { displacement, residual, direction, product, preconditioned, step_energy } = self;
        let inner_product =
            |a, b, sum| kernels.inner_product.in_groups([PARTIAL_COUNT as u32, 1, 1], &[(0, a), (1, b), (2, sum)]);
        let turn = [(3, energy), (4, last_energy), (5, preconditioned), (7, direction)];
        let advance = [(3, energy), (4, step_energy), (5, direction), (6, product), (7, *displacement), (8, residual)];
        let mut dispatches =
            vec![inner_product(residual, preconditioned, energy), kernels.turn.over(vertex_count, &turn)];
        dispatches.extend(operator.product(operators, direction, product));
        dispatches.push(inner_product(direction, product, step_energy));
        dispatches.push(kernels.advance.over(vertex_count, &advance));
        dispatches
    }
}
