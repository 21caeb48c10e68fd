//! The solver's passes. Tolerances are shares of the largest value.

use super::super::coarse_solve::GpuCoarseSolve;
use super::super::conjugate_gradients::{GpuSolver, GpuSolvers};
use super::super::inverse_factor::{InverseFactor, NONE};
use super::super::multigrid::GpuMultigrid;
use super::super::normal_operator::{GpuOperator, OperatorKernels};
use super::super::sparse::LoopMatrices;
use super::{Gpu, gpu, largest_distance, size};
use crate::animate::Animator;
use crate::fixture::compact_avatar;
use crate::mesh::Subdivision;
use crate::mesh::test_meshes::{grid, icosphere, noise_vectors};
use crate::solver::{CoarseFactor, Solver, Start, Stop};
use glam::Vec3A;
use std::sync::Arc;
use wgpu::Buffer;

/// A closed mesh, an open one, and one without subdivision.
fn cases() -> Vec<(Subdivision, Solver)> {
    let fixture = Animator::new(Arc::new(compact_avatar())).unwrap();
    let (sheet, sphere) = (grid(12, 9), icosphere(3));
    let mut cases = vec![(fixture.subdivision().clone(), fixture.solver.clone())];
    for (mesh, levels) in [(sheet, 2), (sphere, 0)] {
        let subdivision = Subdivision::new(mesh.positions.len(), &mesh.triangles, levels);
        let anchors: Vec<u32> = (0..subdivision.vertex_count(levels) as u32).step_by(29).collect();
        let factor = CoarseFactor::new(&subdivision, &anchors, 0.7);
        let solver = Solver::new(&subdivision, &anchors, 0.7, &factor).unwrap();
        cases.push((subdivision, solver));
    }
    cases
}

fn assert_close(found: &[Vec3A], expected: &[Vec3A], tolerance: f32, what: &str) {
    let (error, size) = (largest_distance(found, expected), size(expected));
    assert!(size > 0.0 && error <= tolerance * size, "{what}: {error} of {size}");
}

#[test]
fn normal_operator() {
    let gpu = gpu();
    for (subdivision, solver) in cases() {
        let finest = subdivision.level_count();
        for (i, level) in solver.level_parts().enumerate() {
            let kernels = OperatorKernels::new(gpu);
            let mut cpu = solver.operator(i);
            let operator = GpuOperator::new(gpu, &level.operator, level.scaling, level.weights);
            let count = subdivision.vertex_count(finest - i);
            let (x, b) = (noise_vectors(count, 1), noise_vectors(count, 2));
            let (x_buffer, b_buffer, out) = (gpu.vectors(&x), gpu.vectors(&b), gpu.empty(count));
            let mut expected = vec![Vec3A::ZERO; count];

            cpu.product(&x, &mut expected);
            assert_close(&gpu.run(&operator.product(&kernels, &x_buffer, &out), &out), &expected, 2e-6, "product");
            cpu.residual(&x, &b, &mut expected);
            let dispatches = operator.residual(&kernels, &x_buffer, &b_buffer, &out);
            assert_close(&gpu.run(&dispatches, &out), &expected, 2e-6, "residual");
            cpu.right_side(&x, &mut expected);
            let dispatch = operator.right_side(&kernels, &x_buffer, &out);
            assert_close(&gpu.run([&dispatch], &out), &expected, 2e-6, "right side");
            expected.fill(Vec3A::ZERO);
            cpu.add_smoothed(level.scaling, level.weights, &x, &mut expected);
            let dispatch = operator.smooth_first(&kernels, &x_buffer, &out);
            assert_close(&gpu.run([&dispatch], &out), &expected, 2e-6, "smoothing");
            cpu.add_smoothed(level.scaling, level.weights, &b, &mut expected);
            let dispatch = operator.smooth_more(&kernels, &b_buffer, &out);
            assert_close(&gpu.run([&dispatch], &out), &expected, 2e-6, "more smoothing");
        }
    }
}

#[test]
fn the_inverse_factor_undoes_the_factor() {
    for (_, solver) in cases() {
        let factor = &solver.factor_parts();
        let inverse = InverseFactor::new(factor);
        let mut values = Vec::new();
        inverse.for_each_rows(factor, |offset, rows| {
            assert_eq!((offset, offset % 2), (values.len(), 0));
            values.extend_from_slice(rows);
        });
        assert_eq!(values.len(), InverseFactor::value_count(factor));
        let count = inverse.steps.len();
        assert!(inverse.parents.iter().zip(0u32..).all(|(&parent, i)| parent == NONE || parent > i));
        // L (W x) = x, in the factor's own order.
        let x: Vec<f32> = noise_vectors(count, 3).iter().map(|v| v.x).collect();
        let mut product = vec![0.0; count];
        for i in 0..count {
            let row = &values[inverse.offsets[i]..inverse.offsets[i + 1]];
            product[inverse.steps[i] as usize] =
                row.iter().zip(&x[inverse.first_columns[i] as usize..]).map(|(w, x)| w.to_f32() * x).sum::<f32>();
        }
        let mut back = product.clone();
        for j in 0..count {
            for (row, value) in factor.column(j) {
                back[row as usize] += value * product[j];
            }
        }
        let error = (0..count).map(|i| (back[inverse.steps[i] as usize] - x[i]).abs()).fold(0.0, f32::max);
        // Half precision.
        assert!(error < 2e-3, "{error}");
    }
}

#[test]
fn coarse_solve() {
    let gpu = gpu();
    for (subdivision, mut solver) in cases() {
        let b = noise_vectors(subdivision.vertex_count(0), 5);
        let mut expected = vec![Vec3A::ZERO; b.len()];
        solver.solve_coarsest(&b, &mut expected);
        let x = gpu.empty(b.len());
        let solve = GpuCoarseSolve::new(gpu, &solver.factor_parts());
        let found = gpu.run(&solve.solve(&gpu.vectors(&b), &x), &x);
        // W is kept in half precision: eleven bits.
        assert_close(&found, &expected, 2e-3, "coarse solve");
    }
}

#[test]
fn multigrid() {
    let gpu = gpu();
    for (subdivision, mut solver) in cases() {
        let r = noise_vectors(subdivision.vertex_count(subdivision.level_count()), 6);
        let expected = solver.precondition(&r).to_vec();
        let multigrid = GpuMultigrid::new(gpu, &solver, &subdivision, &LoopMatrices::new(gpu, &subdivision));
        let fields = &multigrid.fields[0];
        gpu.write(&fields.side, &r);
        let cycle = multigrid.cycle(&OperatorKernels::new(gpu), 0);
        assert_close(&gpu.run(&cycle, &fields.correction), &expected, 2e-3, "V-cycle");
    }
}

/// A solve on `level` in buffers of its own.
struct Solve {
    gpu: &'static Gpu,
    row_residual: Buffer,
    displacement: Buffer,
    solver: GpuSolver,
}

impl Solve {
    fn new(subdivision: &Subdivision, solver: &Solver, level: usize) -> Self {
        let (gpu, count) = (gpu(), subdivision.vertex_count(level));
        let displacement = gpu.empty(count);
        let solvers = GpuSolvers::new(gpu, solver, subdivision, &LoopMatrices::new(gpu, subdivision));
        let solver = solvers.on_level(gpu, level, count, &displacement);
        Self { gpu, row_residual: solvers.row_residual(level).clone(), displacement, solver }
    }

    /// What the GPU finds from `r` and from what it solved before.
    fn run(&self, r: &[Vec3A], iterations: u32) -> Vec<Vec3A> {
        self.gpu.write(&self.row_residual, r);
        self.gpu.run(self.solver.dispatches(iterations), &self.displacement)
    }
}

#[test]
fn conjugate_gradients() {
    for (subdivision, mut solver) in cases() {
        let finest = subdivision.level_count();
        for level in solver.coarsest_level()..=finest {
            let r = noise_vectors(subdivision.vertex_count(level), 7);
            let zero = vec![Vec3A::ZERO; r.len()];
            let mut exact = zero.clone();
            solver.solve(level, &r, &mut exact, Start::Base, Stop::Iterations(40));
            let mut errors = vec![];
            for count in [1, 2, 8] {
                let found = Solve::new(&subdivision, &solver, level).run(&r, count);
                let mut expected = zero.clone();
                solver.solve(level, &r, &mut expected, Start::Base, Stop::Iterations(count));
                errors.push([&found, &expected].map(|x| largest_distance(x, &exact) / size(&exact)));
            }
            // Half precision at the bottom bends the way there a little, and costs no iteration.
            for [found, expected] in &errors {
                assert!(*found < 1.5 * expected + 3e-5, "{errors:?}");
            }
            assert!(errors[0][0] > 2.0 * errors[2][0], "the test would notice: {errors:?}");
        }
    }
}

#[test]
fn history() {
    for (subdivision, mut solver) in cases() {
        let finest = subdivision.level_count();
        let solve = Solve::new(&subdivision, &solver, finest);
        let [first, second] = [7, 8].map(|seed| noise_vectors(subdivision.vertex_count(finest), seed));
        let mixed = |share: f32| -> Vec<Vec3A> { first.iter().zip(&second).map(|(a, b)| a.lerp(*b, share)).collect() };
        let mut expected = first.clone();
        // Without iterations the guess alone is seen: of one solution, then of two, in whose span that of a mixture lies.
        for (time, (share, iterations)) in
            [(0.0, 12), (0.3, 0), (0.3, 12), (0.5, 12), (-1.0, 0), (0.1, 12)].into_iter().enumerate()
        {
            let r = mixed(share);
            let start = if time == 0 { Start::Base } else { Start::Earlier };
            solver.solve(finest, &r, &mut expected, start, Stop::Iterations(iterations));
            let error = largest_distance(&solve.run(&r, iterations), &expected);
            assert!(error < 1e-3 * size(&expected), "{time}: {error} of {}", size(&expected));
        }
        // A good guess leaves hardly anything to do; it was two solves ago that the same was solved.
        let exact = expected.clone();
        let error = largest_distance(&solve.run(&mixed(0.1), 0), &exact);
        assert!(error < 1e-3 * size(&exact), "{error}");
        let other = largest_distance(&solve.run(&mixed(0.9), 0), &exact);
        assert!(other > 0.1 * size(&exact), "another right side is told apart: {other}");
    }
}

#[test]
fn no_residual_is_no_displacement() {
    for (subdivision, solver) in cases() {
        let zero = vec![Vec3A::ZERO; subdivision.vertex_count(subdivision.level_count())];
        assert_eq!(Solve::new(&subdivision, &solver, subdivision.level_count()).run(&zero, 3), zero);
    }
}
