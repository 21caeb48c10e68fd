//! (LᵀL + w_a S) d = Lᵀ r by a fixed number of preconditioned conjugate-gradient steps. Products and step lengths never leave the GPU.

use super::kernel::{Dispatch, Kernel, Shader, storage, vectors};
use super::multigrid::GpuMultigrid;
use super::normal_operator::{GpuOperator, OperatorKernels};
use super::topology::GpuRings;
use crate::mesh::Subdivision;
use crate::solver::Solver;
use wgpu::{Buffer, Device};

/// WGSL of the pass.
pub(super) const SOURCE: &str = include_str!("conjugate_gradients.wgsl");

/// Partial sums of an inner product, and workgroups that make them.
const PARTIAL_COUNT: usize = 64;

/// The whole solve, as dispatches.
pub(super) struct GpuSolver {
    /// From the rows' residual to that of the first guess.
    start: Vec<Dispatch>,
    first: Vec<Dispatch>,
    /// Later iterations; the energies of this and the last one swap their places.
    later: [Vec<Dispatch>; 2],
    rings: GpuRings,
}

struct Kernels {
    inner_product: Kernel,
    turn: Kernel,
    advance: Kernel,
}

/// What an iteration works on, all on the finest level.
struct Fields<'a> {
    displacement: &'a Buffer,
    residual: Buffer,
    direction: Buffer,
    product: Buffer,
    preconditioned: Buffer,
    step_energy: Buffer,
}

impl GpuSolver {
    /// Solves for `displacement` from `row_residual`, both on the finest level; `displacement` comes in as the first guess.
    pub fn new(
        device: &Device,
        solver: &Solver,
        subdivision: &Subdivision,
        row_residual: &Buffer,
        displacement: &Buffer,
    ) -> Self {
        let finest = subdivision.level_count();
        let vertex_count = subdivision.vertex_count(finest);
        let operators = OperatorKernels::new(device);
        let multigrid = GpuMultigrid::new(device, solver, subdivision);
        // Without subdivision there is no level to share it with, and nothing is smoothed.
        let lone = multigrid.levels.is_empty().then(|| {
            let unused = vec![0.0; vertex_count];
            GpuOperator::new(device, &solver.operator_parts(), &unused, [0.0; 2], subdivision, finest)
        });
        let Some(operator) = lone.as_ref().or(multigrid.levels.first().map(|level| &level.operator)) else {
            unreachable!("there is a lone operator where there are no levels")
        };
        let field = |label| vectors(device, label, vertex_count);
        let energy = |label| storage(device, label, PARTIAL_COUNT * size_of::<[f32; 4]>());
        let fields = Fields {
            displacement,
            residual: field("solver: residual"),
            direction: field("solver: direction"),
            product: field("solver: product"),
            preconditioned: field("solver: preconditioned"),
            step_energy: energy("solver: energy of a step"),
        };
        let shader = Shader::new(device, "conjugate gradients", SOURCE);
        let kernels = Kernels {
            inner_product: shader.kernel("inner_product"),
            turn: shader.kernel("turn"),
            advance: shader.kernel("advance"),
        };
        let mut start = vec![operator.right_side(&operators, row_residual, &fields.product)];
        start.extend(operator.residual(&operators, displacement, &fields.product, &fields.residual));
        let iteration = |[energy, last_energy]: [&Buffer; 2]| {
            let mut dispatches = multigrid.cycle(&operators, &fields.residual, &fields.preconditioned);
            dispatches.extend(fields.rest_of_iteration(
                &kernels,
                &operators,
                operator,
                vertex_count,
                energy,
                last_energy,
            ));
            dispatches
        };
        // An energy of zero turns no direction: the first iteration has no last one. Nothing ever writes to it.
        let (none, even, odd) = (energy("solver: no energy"), energy("solver: energy"), energy("solver: energy"));
        Self {
            start,
            first: iteration([&even, &none]),
            later: [iteration([&odd, &even]), iteration([&even, &odd])],
            rings: operator.rings().clone(),
        }
    }

    /// Neighbours on the finest level.
    pub fn rings(&self) -> &GpuRings {
        &self.rings
    }

    /// The dispatches of a solve, in order.
    pub fn dispatches(&self, iterations: u32) -> impl Iterator<Item = &Dispatch> {
        let later = (1..iterations as usize).flat_map(|index| &self.later[(index + 1) % 2]);
        self.start.iter().chain(&self.first).chain(later)
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
