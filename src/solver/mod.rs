//! Laplacian reconstruction: (LᵀL + w_a S) d = Lᵀ r by multigrid-preconditioned conjugate gradients.
//!
//! d is the displacement from the subdivided base mesh, r the wanted Laplacian less the base's own, in metres a row. Anchors hold
//! d at zero softly. The matrix depends on topology alone; the coarse level is factored once for each avatar.

mod factor;
mod galerkin;
mod multigrid;
mod normal_operator;
#[cfg(feature = "gpu")]
mod parts;
mod triangular;

pub use factor::{CoarseFactor, FactorError};
#[cfg(feature = "gpu")]
pub(crate) use parts::{FactorParts, LevelParts, OperatorParts};

use crate::mesh::sparse::SparseMatrix;
use crate::mesh::{Adjacency, Subdivision};
use glam::Vec3A;
use multigrid::{Level, Multigrid};
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
    direction: Vec<Vec3A>,
    product: Vec<Vec3A>,
}

/// c of c LᵀL on a level, as a share of the next finer level's: PᵀLᵀLP of a smooth field, whose L is a quarter on the finer level
/// while the vertices are four times as many.
const COARSENING: f32 = 0.25;

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
        let coarsest = DirectSolver::new(&galerkin::coarsest_operator(subdivision, anchors, anchor_weight), &factor)?;
        let mut anchor_rows = SparseMatrix::with_capacity(anchors.len(), anchors.len(), vertex_count);
        for &anchor in anchors {
            anchor_rows.push_row(&mut [(anchor, anchor_weight.sqrt())]);
        }
        let operator_of = |level: usize, scale: f32, anchor_rows: &SparseMatrix| {
            let adjacency = Adjacency::new(subdivision.vertex_count(level), subdivision.triangles(level));
            NormalOperator::new(&adjacency, scale, anchor_rows.clone())
        };
        let operator = operator_of(finest, 1.0, &anchor_rows);
        let mut levels: Vec<Level> = Vec::with_capacity(finest);
        for level in (1..=finest).rev() {
            let level_operator = match levels.last() {
                None => operator.clone(),
                Some(finer) => {
                    anchor_rows = anchor_rows.times(subdivision.loop_stencils(level));
                    operator_of(level, COARSENING * finer.operator.scale, &anchor_rows)
                }
            };
            let (prolongation, restriction) =
                (subdivision.loop_stencils(level - 1), subdivision.loop_stencils_transposed(level - 1));
            levels.push(Level::new(level_operator, level == finest, prolongation.clone(), restriction.clone()));
        }
        let zeros = vec![Vec3A::ZERO; vertex_count];
        Ok(Self {
            operator,
            preconditioner: Multigrid::new(levels, coarsest, subdivision.vertex_count(0)),
            residual: zeros.clone(),
            direction: zeros.clone(),
            product: zeros,
        })
    }

    /// Solves for `d` (finest level) from the rows' residual `r`; `d` comes in as the first guess. Returns the iterations done.
    pub fn solve(&mut self, r: &[Vec3A], d: &mut [Vec3A], stop: Stop) -> u32 {
        let Self { operator, preconditioner, residual, direction, product } = self;
        operator.right_side(r, residual);
        if d.iter().any(|d| *d != Vec3A::ZERO) {
            operator.product(d, product);
            residual.iter_mut().zip(&*product).for_each(|(residual, product)| *residual -= *product);
        }
        let limit = match stop {
            Stop::Iterations(count) => count,
            Stop::Tolerance(_) => ITERATION_LIMIT,
        };
        let mut energy = Vec3A::ZERO;
        let mut last_largest = f32::INFINITY;
        let mut last_length = 1.0f32;
        for iteration in 0..limit {
            let preconditioned = preconditioner.apply(residual);
            let mut next_energy = Vec3A::ZERO;
            let mut largest = 0.0f32;
            for (residual, z) in residual.iter().zip(preconditioned) {
                next_energy += *residual * *z;
                largest = largest.max(z.length_squared());
            }
            let largest = largest.sqrt();
            let is_enough = match stop {
                Stop::Iterations(_) => iteration + 1 == limit,
                // The preconditioned residual times the last step's length is nearly the error, and this iteration still lowers it,
                // about as the last one did.
                Stop::Tolerance(tolerance) => {
                    last_length * largest * (largest / last_largest).clamp(BEST_CONTRACTION, 1.0) <= tolerance
                }
            };
            last_largest = largest;
            let ratio = divide(next_energy, energy);
            energy = next_energy;
            if iteration == 0 {
                direction.copy_from_slice(preconditioned);
            } else {
                for (direction, z) in direction.iter_mut().zip(preconditioned) {
                    *direction = *z + *direction * ratio;
                }
            }
            operator.product(direction, product);
            let length = divide(energy, dot(direction, product));
            last_length = length.max_element().max(1.0);
            if is_enough {
                d.iter_mut().zip(&*direction).for_each(|(d, direction)| *d += *direction * length);
                return iteration + 1;
            }
            let rows = d.iter_mut().zip(&*direction).zip(residual.iter_mut().zip(&*product));
            for ((d, direction), (residual, product)) in rows {
                *d += *direction * length;
                *residual -= *product * length;
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

/// What tests of another implementation compare with.
#[cfg(all(test, feature = "gpu"))]
impl Solver {
    pub(crate) fn operator(&self, level_below_finest: usize) -> NormalOperator {
        self.preconditioner.levels[level_below_finest].operator.clone()
    }

    pub(crate) fn solve_coarsest(&mut self, b: &[Vec3A], x: &mut [Vec3A]) {
        self.preconditioner.coarsest.solve(b, x);
    }

    pub(crate) fn precondition(&mut self, r: &[Vec3A]) -> &[Vec3A] {
        self.preconditioner.apply(r)
    }
}

#[cfg(all(test, feature = "factor"))]
mod factor_tests;
#[cfg(all(test, feature = "factor"))]
mod tests;
