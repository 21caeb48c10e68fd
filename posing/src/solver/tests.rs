//! The solver against a direct solution in double precision.

use super::*;
use crate::laplacian::{apply_topological, sample_elimination};
use crate::mesh::test_meshes::{grid, icosphere, noise_vectors, torus};
use crate::mesh::{Mesh, Scheme, vertex_normals};
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use std::f32::consts::TAU;

/// What the default tolerance promises, metres.
const PROMISED: f32 = 2e-5;
const DEFAULT_TOLERANCE: Stop = Stop::Tolerance(1e-5);

/// A reconstruction whose solution is known.
struct Problem {
    subdivision: Subdivision,
    anchors: Vec<u32>,
    anchor_weight: f32,
    /// Right side of 5 mm wrinkles, 60 mm apart.
    r: Vec<Vec3A>,
    exact: Vec<Vec3A>,
}

impl Problem {
    fn new(base: &Mesh, level_count: usize, anchor_count: usize, anchor_weight: f32) -> Self {
        let subdivision = Subdivision::new(base.positions.len(), &base.triangles, level_count);
        let mut positions = base.positions.clone();
        for level in 0..level_count {
            let mut finer = vec![Vec3A::ZERO; subdivision.vertex_count(level + 1)];
            subdivision.refine(Scheme::Midpoint, level, &positions, &mut finer);
            positions = finer;
        }
        let triangles = subdivision.triangles(level_count);
        let mut normals = positions.clone();
        vertex_normals(&positions, triangles, &mut normals);
        let wrinkle = |(p, n): (&Vec3A, &Vec3A)| *n * 0.005 * (TAU / 0.06 * (p.y + 0.4 * p.x)).sin();
        let wrinkles: Vec<Vec3A> = positions.iter().zip(&normals).map(wrinkle).collect();
        let mut r = wrinkles.clone();
        apply_topological(&Adjacency::new(positions.len(), triangles), &wrinkles, &mut r);
        let anchors = sample_elimination(&positions, 1.0, anchor_count);
        let exact = direct_solution(positions.len(), triangles, &anchors, anchor_weight, &r);
        Self { subdivision, anchors, anchor_weight, r, exact }
    }

    fn factor(&self) -> CoarseFactor {
        CoarseFactor::new(&self.subdivision, &self.anchors, self.anchor_weight)
    }

    fn solver(&self, factor: &CoarseFactor) -> Result<Solver, FactorError> {
        Solver::new(&self.subdivision, &self.anchors, self.anchor_weight, factor)
    }

    /// Iterations and the largest vertex error in metres, from a zero guess.
    fn solve(&self, solver: &mut Solver, stop: Stop) -> (u32, f32) {
        let mut d = vec![Vec3A::ZERO; self.r.len()];
        let iterations = solver.solve(self.subdivision.level_count(), &self.r, &mut d, Start::Base, stop);
        (iterations, self.error(&d))
    }

    fn error(&self, d: &[Vec3A]) -> f32 {
        d.iter().zip(&self.exact).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }
}

/// (LᵀL + w_a S)⁻¹ Lᵀ r with L made from the triangles alone, by sparse Cholesky in double precision.
fn direct_solution(
    vertex_count: usize,
    triangles: &[crate::mesh::Triangle],
    anchors: &[u32],
    anchor_weight: f32,
    r: &[Vec3A],
) -> Vec<Vec3A> {
    let mut neighbours = vec![std::collections::BTreeSet::new(); vertex_count];
    for t in triangles {
        for corner in 0..3 {
            let (a, b) = (t[corner] as usize, t[(corner + 1) % 3] as usize);
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
    }
    let mut entries = Vec::new();
    let mut right = faer::Mat::<f64>::zeros(vertex_count, 3);
    for (k, neighbours) in neighbours.iter().enumerate() {
        let others = neighbours.iter().map(|&j| (j, -1.0 / neighbours.len() as f64));
        let row: Vec<(usize, f64)> = others.chain([(k, 1.0)]).collect();
        for &(i, left) in &row {
            entries.extend(row.iter().map(|&(j, value)| Triplet::new(i, j, left * value)));
            for axis in 0..3 {
                right[(i, axis)] += left * f64::from(r[k][axis]);
            }
        }
    }
    entries.extend(anchors.iter().map(|&a| Triplet::new(a as usize, a as usize, f64::from(anchor_weight))));
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(vertex_count, vertex_count, &entries).unwrap();
    let solution = matrix.sp_cholesky(faer::Side::Lower).unwrap().solve(&right);
    let vertex = |k| Vec3A::from_array([0, 1, 2].map(|axis| solution[(k, axis)] as f32));
    (0..vertex_count).map(vertex).collect()
}

/// A torus of `around` × `around` / 2 vertices with 20 mm bumps.
fn bumpy_torus(around: u32) -> Mesh {
    let mut mesh = torus(around, around / 2);
    let mut normals = mesh.positions.clone();
    vertex_normals(&mesh.positions, &mesh.triangles, &mut normals);
    for (p, n) in mesh.positions.iter_mut().zip(normals) {
        *p += n * 0.02 * (25.0 * p.x).sin() * (20.0 * p.z).cos();
    }
    mesh
}

fn small_sphere(levels: usize) -> Mesh {
    let mut mesh = icosphere(levels);
    mesh.positions.iter_mut().for_each(|p| *p *= 0.25);
    mesh
}

#[test]
fn default_tolerance_keeps_its_promise_at_every_level_count() {
    let cases = [
        Problem::new(&small_sphere(4), 0, 60, 1.0),
        Problem::new(&small_sphere(3), 1, 60, 1.0),
        Problem::new(&small_sphere(2), 2, 60, 1.0),
        Problem::new(&small_sphere(1), 3, 60, 1.0),
        Problem::new(&bumpy_torus(36), 2, 80, 1.0),
        Problem::new(&bumpy_torus(36), 2, 30, 0.1),
        Problem::new(&bumpy_torus(24), 2, 200, 10.0),
    ];
    for (case, problem) in cases.iter().enumerate() {
        let mut solver = problem.solver(&problem.factor()).unwrap();
        let (iterations, error) = problem.solve(&mut solver, DEFAULT_TOLERANCE);
        assert!(error <= PROMISED && iterations <= 10, "case {case}: {iterations} iterations, {error} m");
    }
}

#[test]
fn open_meshes_are_solved_too() {
    let mut sheet = grid(20, 14);
    sheet.positions.iter_mut().for_each(|p| *p *= 0.03);
    let problem = Problem::new(&sheet, 2, 60, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    let (iterations, error) = problem.solve(&mut solver, DEFAULT_TOLERANCE);
    assert!(error <= PROMISED && iterations <= 15, "{iterations} iterations, {error} m");
}

#[test]
fn each_iteration_divides_the_error() {
    let problem = Problem::new(&bumpy_torus(36), 2, 80, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    let mut last = problem.error(&vec![Vec3A::ZERO; problem.r.len()]);
    assert!(last > 4e-3);
    for count in 1..=4 {
        let (iterations, error) = problem.solve(&mut solver, Stop::Iterations(count));
        assert_eq!(iterations, count);
        assert!(error < 0.4 * last, "iteration {count}: {error} m after {last} m");
        last = error;
    }
    // Too few iterations do not pass for enough.
    assert!(problem.solve(&mut solver, Stop::Iterations(1)).1 > PROMISED);
}

#[test]
fn a_wrong_factor_is_seen() {
    let problem = Problem::new(&bumpy_torus(36), 2, 80, 1.0);
    let right = problem.factor();
    let (needed, _) = problem.solve(&mut problem.solver(&right).unwrap(), DEFAULT_TOLERANCE);
    let mut wrong = right.clone();
    wrong.values.iter_mut().for_each(|value| *value = -*value);
    let mut weak = right;
    weak.diagonal.iter_mut().for_each(|d| *d *= 30.0);
    for factor in [wrong, weak] {
        let (_, error) = problem.solve(&mut problem.solver(&factor).unwrap(), Stop::Iterations(needed));
        assert!(error > 2.0 * PROMISED, "{error} m");
    }
}

/// A figure that stands nearly still for ten seconds: what rounding leaves in one frame must not add up over the next ones.
#[test]
fn earlier_solutions_carry_no_rounding_along() {
    let problem = Problem::new(&bumpy_torus(36), 2, 80, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    let mut d = problem.r.clone();
    for time in 0..600 {
        let still: Vec<Vec3A> = problem.r.iter().map(|&r| r * (1.0 + 1e-6 * (time as f32).sin())).collect();
        solver.solve(2, &still, &mut d, Start::Earlier, DEFAULT_TOLERANCE);
    }
    let error = d.iter().zip(&problem.exact).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(error <= PROMISED, "{error} m");
}

#[test]
fn earlier_solutions_make_a_near_guess_and_the_same_one_needs_nothing_more() {
    let problem = Problem::new(&bumpy_torus(36), 2, 80, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    // Wrinkles that grow, turn and wander: what is new at each moment is small.
    let turned = |time: f32| -> Vec<Vec3A> {
        let turn = glam::Quat::from_rotation_y(0.3 * time) * (1.0 + 0.2 * time);
        problem.r.iter().map(|&r| turn * r).collect()
    };
    let mut d = problem.r.clone();
    let mut solve = |time: f32, start| solver.solve(2, &turned(time), &mut d, start, DEFAULT_TOLERANCE);
    let cold = solve(0.0, Start::Base);
    solve(0.1, Start::Earlier);
    let warm = solve(0.2, Start::Earlier);
    assert!(warm < cold, "{warm} after {cold} iterations");
    assert_eq!(solve(0.2, Start::Earlier), 1);
    assert_eq!(solve(0.2, Start::Base), cold, "begins anew");
    let exact: Vec<Vec3A> = {
        let turn = glam::Quat::from_rotation_y(0.06) * 1.04;
        problem.exact.iter().map(|&exact| turn * exact).collect()
    };
    let mut guessed = problem.r.clone();
    for time in [0.0, 0.1, 0.2] {
        solver.solve(2, &turned(time), &mut guessed, Start::Earlier, DEFAULT_TOLERANCE);
    }
    let error = guessed.iter().zip(&exact).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(error <= PROMISED, "{error} m");
}

#[test]
fn a_coarser_level_solves_the_same_energy_on_its_mesh() {
    let problem = Problem::new(&bumpy_torus(36), 2, 80, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    assert_eq!(solver.coarsest_level(), 1);
    // ¼ LᵀL + w PᵀSP of level 1, assembled, against what the solver does without a matrix.
    let count = problem.subdivision.vertex_count(1);
    let adjacency = Adjacency::new(count, problem.subdivision.triangles(1));
    let mut entries = Vec::new();
    let mut right = faer::Mat::<f64>::zeros(count, 3);
    let r = noise_vectors(count, 5);
    for k in 0..count {
        let weight = -0.5 / adjacency.valence(k) as f64;
        let row: Vec<(usize, f64)> = adjacency.of(k).iter().map(|&j| (j as usize, weight)).chain([(k, 0.5)]).collect();
        for &(i, left) in &row {
            entries.extend(row.iter().map(|&(j, value)| Triplet::new(i, j, left * value)));
            for axis in 0..3 {
                right[(i, axis)] += left * 0.5 * f64::from(r[k][axis]);
            }
        }
    }
    let stencils = problem.subdivision.loop_stencils(1).matrix();
    for &anchor in &problem.anchors {
        for (i, left) in stencils.row(anchor as usize) {
            let of_row = |(j, value): (u32, f32)| Triplet::new(i as usize, j as usize, f64::from(left * value));
            entries.extend(stencils.row(anchor as usize).map(of_row));
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(count, count, &entries).unwrap();
    let exact = matrix.sp_cholesky(faer::Side::Lower).unwrap().solve(&right);
    let mut d = r.clone();
    let iterations = solver.solve(1, &r, &mut d, Start::Base, Stop::Tolerance(1e-4));
    let difference = |k: usize| (0..3).map(|axis| (f64::from(d[k][axis]) - exact[(k, axis)]).abs()).fold(0.0, f64::max);
    let error = (0..count).map(difference).fold(0.0, f64::max);
    let size = d.iter().map(|d| d.length()).fold(0.0, f32::max);
    assert!(iterations <= 15 && error < 4e-4 && size > 0.5, "{iterations} iterations, {error} m of {size} m");
    // And the finest level is not disturbed.
    assert!(problem.solve(&mut solver, DEFAULT_TOLERANCE).1 <= PROMISED);
}

#[test]
fn no_detail_is_no_displacement() {
    let problem = Problem::new(&small_sphere(1), 1, 20, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    let mut d = vec![Vec3A::ZERO; problem.r.len()];
    solver.solve(1, &vec![Vec3A::ZERO; d.len()], &mut d, Start::Base, DEFAULT_TOLERANCE);
    assert!(d.iter().all(|d| *d == Vec3A::ZERO));
}

#[test]
fn the_solution_is_linear_in_its_right_side() {
    let problem = Problem::new(&small_sphere(2), 1, 40, 1.0);
    let mut solver = problem.solver(&problem.factor()).unwrap();
    let (mut once, mut twice) = (vec![Vec3A::ZERO; problem.r.len()], vec![Vec3A::ZERO; problem.r.len()]);
    let doubled: Vec<Vec3A> = problem.r.iter().map(|&r| 2.0 * r).collect();
    solver.solve(1, &problem.r, &mut once, Start::Base, Stop::Iterations(8));
    solver.solve(1, &doubled, &mut twice, Start::Base, Stop::Iterations(8));
    assert!(once.iter().zip(&twice).all(|(a, b)| (2.0 * *a - *b).length() < 1e-6));
}

#[test]
fn a_vertex_of_no_triangle_stays() {
    let mut base = small_sphere(1);
    base.positions.push(Vec3A::ONE);
    let problem = |mesh: &Mesh| Subdivision::new(mesh.positions.len(), &mesh.triangles, 1);
    let subdivision = problem(&base);
    let factor = CoarseFactor::new(&subdivision, &[3, 9], 1.0);
    let mut solver = Solver::new(&subdivision, &[3, 9], 1.0, &factor).unwrap();
    let count = subdivision.vertex_count(1);
    let mut d = vec![Vec3A::ZERO; count];
    let mut r = noise_vectors(count, 11);
    r[42] = Vec3A::ZERO;
    solver.solve(1, &r, &mut d, Start::Base, Stop::Iterations(5));
    assert!(d.iter().all(|d| d.is_finite()) && d[42] == Vec3A::ZERO);
}
