//! Laplacian reconstruction: (LᵀL + w_a S) d = Lᵀ r by multigrid-preconditioned conjugate gradients.
//!
//! d is the displacement from the subdivided base mesh, r the wanted Laplacian less the base's own, in metres a row. Anchors hold
//! d at zero softly. The matrix depends on topology alone; the coarse level is factored once for each avatar.

mod factor;
mod galerkin;
mod multigrid;
mod normal_operator;
mod triangular;

pub use factor::{CoarseFactor, FactorError};

use crate::mesh::{Adjacency, Subdivision};
use glam::Vec3A;
use multigrid::{Level, Multigrid, Operator};
use normal_operator::NormalOperator;
use triangular::DirectSolver;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// After so many iterations.
    Iterations(u32),
    /// When the estimated largest vertex error falls below so many metres.
    Tolerance(f32),
}

/// Everything that solving needs and that no frame changes.
#[derive(Clone, Debug)]
pub struct Solver {
    operator: NormalOperator,
    preconditioner: Multigrid,
    residual: Vec<Vec3A>,
    preconditioned: Vec<Vec3A>,
    direction: Vec<Vec3A>,
    product: Vec<Vec3A>,
}

/// How much of the error one iteration is trusted to leave at best.
const BEST_CONTRACTION: f32 = 0.25;

/// Iterations after which a solve to a tolerance gives up and returns what it has.
const ITERATION_LIMIT: u32 = 60;

impl Solver {
    /// `anchors` are vertices of the finest level, ascending. `factor` belongs to the same topology, anchors and weight.
    ///
    /// # Errors
    /// When the factor's arrays do not fit the topology.
    pub fn new(
        subdivision: &Subdivision,
        anchors: &[u32],
        anchor_weight: f32,
        factor: CoarseFactor,
    ) -> Result<Self, FactorError> {
        let finest = subdivision.level_count();
        let vertex_count = subdivision.vertex_count(finest);
        let mut matrices = galerkin::operators(subdivision, anchors, anchor_weight);
        let coarsest = DirectSolver::new(&matrices[0], &factor)?;
        let adjacency = Adjacency::new(vertex_count, subdivision.triangles(finest));
        let operator = NormalOperator::new(&adjacency, anchors, anchor_weight);
        let mut level = |level: usize| {
            let operator = match matrices.get_mut(level) {
                Some(matrix) => Operator::Assembled(std::mem::take(matrix)),
                None => Operator::Normal(operator.clone()),
            };
            Level::new(operator, subdivision.loop_stencils(level - 1).clone())
        };
        let levels = (1..=finest).rev().map(&mut level).collect();
        let zeros = vec![Vec3A::ZERO; vertex_count];
        Ok(Self {
            operator,
            preconditioner: Multigrid::new(levels, coarsest, subdivision.vertex_count(0)),
            residual: zeros.clone(),
            preconditioned: zeros.clone(),
            direction: zeros.clone(),
            product: zeros,
        })
    }

    /// Solves for `d` (finest level) from the rows' residual `r`; `d` comes in as the first guess. Returns the iterations done.
    pub fn solve(&mut self, r: &[Vec3A], d: &mut [Vec3A], stop: Stop) -> u32 {
        let Self { operator, preconditioner, residual, preconditioned, direction, product } = self;
        operator.right_side(r, residual);
        if d.iter().any(|d| *d != Vec3A::ZERO) {
            operator.subtract_product(d, residual);
        }
        let limit = match stop {
            Stop::Iterations(count) => count,
            Stop::Tolerance(_) => ITERATION_LIMIT,
        };
        let mut energy = Vec3A::ZERO;
        let mut last_largest = f32::INFINITY;
        for iteration in 0..limit {
            preconditioner.apply(residual, preconditioned);
            let largest = preconditioned.iter().fold(0.0f32, |largest, z| largest.max(z.length_squared())).sqrt();
            let is_enough = match stop {
                Stop::Iterations(_) => iteration + 1 == limit,
                // The preconditioned residual is nearly the error, and this iteration still lowers it, about as the last one did.
                Stop::Tolerance(tolerance) => {
                    largest * (largest / last_largest).clamp(BEST_CONTRACTION, 1.0) <= tolerance
                }
            };
            last_largest = largest;
            let next_energy = dot(residual, preconditioned);
            let ratio = divide(next_energy, energy);
            energy = next_energy;
            for (direction, z) in direction.iter_mut().zip(&*preconditioned) {
                *direction = if iteration == 0 { *z } else { *z + *direction * ratio };
            }
            product.fill(Vec3A::ZERO);
            operator.subtract_product(direction, product);
            let length = divide(energy, -dot(direction, product));
            for (d, direction) in d.iter_mut().zip(&*direction) {
                *d += *direction * length;
            }
            if is_enough {
                return iteration + 1;
            }
            for (residual, product) in residual.iter_mut().zip(&*product) {
                *residual += *product * length;
            }
        }
        limit
    }
}

/// The inner products of the three coordinates.
fn dot(a: &[Vec3A], b: &[Vec3A]) -> Vec3A {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

/// a / b by coordinate; zero where b is not positive, as when that coordinate is solved exactly.
fn divide(a: Vec3A, b: Vec3A) -> Vec3A {
    let is_positive = b.cmpgt(Vec3A::ZERO);
    Vec3A::select(is_positive, a / Vec3A::select(is_positive, b, Vec3A::ONE), Vec3A::ZERO)
}

#[cfg(all(test, feature = "factor"))]
mod factor_tests;
#[cfg(all(test, feature = "factor"))]
mod tests;
