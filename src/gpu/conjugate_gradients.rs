//! (LᵀL + w_a S) d = Lᵀ r by a fixed number of preconditioned conjugate-gradient steps. Products and step lengths never leave the GPU.

use super::history::{GpuHistory, HistoryKernels};
use super::kernel::{Dispatch, Kernel, Shader, storage, vectors};
use super::multigrid::GpuMultigrid;
use super::normal_operator::{GpuOperator, OperatorKernels};
use super::topology::GpuRings;
use crate::mesh::Subdivision;
use crate::solver::Solver;
use crate::wgsl::wgsl;
use wgpu::{Buffer, CommandEncoder, Device};

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("conjugate_gradients.wgsl"));

/// Partial sums of an inner product, and workgroups that make them.
const PARTIAL_COUNT: usize = 64;

/// What the solves on all levels share.
pub(super) struct GpuSolvers {
    kernels: Kernels,
    operators: OperatorKernels,
    histories: HistoryKernels,
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
    history: GpuHistory,
}

struct Kernels {
    inner_product: Kernel,
    turn: Kernel,
    advance: Kernel,
}

/// What an iteration works on, all on one level.
struct Fields<'a> {
    displacement: &'a Buffer,
    residual: Buffer,
    direction: Buffer,
    product: Buffer,
    preconditioned: Buffer,
    step_energy: Buffer,
}

impl GpuSolvers {
    pub fn new(device: &Device, solver: &Solver, subdivision: &Subdivision) -> Self {
        let finest_level = subdivision.level_count();
        let multigrid = GpuMultigrid::new(device, solver, subdivision);
        let shader = Shader::new(device, "conjugate gradients", SOURCE);
        Self {
            kernels: Kernels {
                inner_product: shader.kernel("inner_product"),
                turn: shader.kernel("turn"),
                advance: shader.kernel("advance"),
            },
            operators: OperatorKernels::new(device),
            histories: HistoryKernels::new(device),
            lone: multigrid.levels.is_empty().then(|| {
                let unused = vec![0.0; subdivision.vertex_count(finest_level)];
                GpuOperator::new(device, &solver.operator_parts(), &unused, [0.0; 2], subdivision, finest_level)
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

    /// Solves for `displacement` from `row_residual`, both on `level`.
    pub fn on_level(
        &self,
        device: &Device,
        level: usize,
        vertex_count: usize,
        row_residual: &Buffer,
        displacement: &Buffer,
    ) -> GpuSolver {
        let Self { operators, histories, multigrid, .. } = self;
        let operator = self.operator(level);
        let field = |label| vectors(device, label, vertex_count);
        let energy = |label| storage(device, label, PARTIAL_COUNT * size_of::<[f32; 4]>());
        let right_side = field("solver: right side");
        let fields = Fields {
            displacement,
            residual: field("solver: residual"),
            direction: field("solver: direction"),
            product: field("solver: product"),
            preconditioned: field("solver: preconditioned"),
            step_energy: energy("solver: energy of a step"),
        };
        let history = GpuHistory::new(device, vertex_count);
        let mut start = vec![operator.right_side(operators, row_residual, &right_side)];
        start.extend(history.guess(histories, &right_side, displacement, &fields.residual));
        let iteration = |[energy, last_energy]: [&Buffer; 2]| {
            let first = self.finest_level - level;
            let mut dispatches = multigrid.cycle(operators, first, &fields.residual, &fields.preconditioned);
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
            end: history.remember(histories, &right_side, displacement, &fields.residual),
            history,
        }
    }
}

impl GpuSolver {
    /// Makes the next solve start from nothing in place of what the last ones make likely.
    pub fn forget(&self, encoder: &mut CommandEncoder) {
        self.history.clear(encoder);
    }

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
