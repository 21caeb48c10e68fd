//! Laplacian reconstruction: (LᵀL + w_a S) d = Lᵀ r by multigrid-preconditioned conjugate gradients.
//!
//! d is the displacement from the subdivided base mesh, r the wanted Laplacian less the base's own, in metres a row. Anchors hold
//! d at zero softly. The matrix depends on topology alone; the coarse level is factored once for each avatar.

mod direct;
mod factor;
mod factor_pattern;
mod galerkin;
mod history;
mod multigrid;
mod normal_operator;
mod parts;

pub use factor::{CoarseFactor, FactorError};
pub use parts::{FactorParts, LevelParts, OperatorParts};

use crate::mesh::SparseMatrix;
use crate::mesh::rings::Rings;
use crate::mesh::{Adjacency, Subdivision};
use crate::threads::{for_row_pairs, for_rows, of_parts};
use direct::DirectSolver;
use glam::Vec3A;
use history::History;
use multigrid::Multigrid;
use normal_operator::NormalOperator;
use std::sync::Arc;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// After so many iterations.
    Iterations(u32),
    /// When the estimated largest vertex error falls below so many metres.
    Tolerance(f32),
}

/// Where to begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// From the base mesh.
    Base,
    /// From what earlier solves on the same level make likely, the base mesh if there were none since the last [`Start::Base`].
    Earlier,
}

/// Everything that solving needs and that no frame changes, and its working space, which the first solve makes: a solver whose work a GPU
/// does takes no memory for it.
#[derive(Clone, Debug)]
pub struct Solver {
    /// Of the levels on which one can solve, finest first.
    operators: Vec<NormalOperator>,
    preconditioner: Multigrid,
    history: History,
    right_side: Vec<Vec3A>,
    residual: Vec<Vec3A>,
    direction: Vec<Vec3A>,
    product: Vec<Vec3A>,
}

/// c of c LᵀL on a level, as a share of the next finer level's: PᵀLᵀLP of a smooth field, whose L is a quarter on the finer level
/// while the vertices are four times as many.
const COARSENING: f32 = 0.25;

/// How much of the error one iteration is trusted to leave at best.
const BEST_CONTRACTION: f32 = 0.2;

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
        factor: &CoarseFactor,
    ) -> Result<Self, FactorError> {
        let finest = subdivision.level_count();
        let vertex_count = subdivision.vertex_count(finest);
        let coarsest = DirectSolver::new(&galerkin::coupling(subdivision), factor)?;
        let mut anchor_rows = SparseMatrix::with_capacity(anchors.len(), anchors.len(), vertex_count);
        for &anchor in anchors {
            anchor_rows.push_row(&mut [(anchor, anchor_weight.sqrt())]);
        }
        let finest_rings = Rings::new(&Adjacency::new(vertex_count, subdivision.triangles(finest)));
        let mut operators = vec![NormalOperator::new(Arc::new(finest_rings), 1.0, anchor_rows.clone())];
        let mut stencils = Vec::new();
        for level in (0..finest).rev() {
            let below = subdivision.loop_stencils(level);
            if level > 0 {
                anchor_rows = below.times_from_left(&anchor_rows);
                let scale = COARSENING.powi((finest - level) as i32);
                operators.push(NormalOperator::new(below.rings().clone(), scale, anchor_rows.clone()));
            }
            stencils.push(below.clone());
        }
        Ok(Self {
            preconditioner: Multigrid::new(&mut operators, &stencils, coarsest, subdivision.vertex_count(0)),
            operators,
            history: History::default(),
            right_side: Vec::new(),
            residual: Vec::new(),
            direction: Vec::new(),
            product: Vec::new(),
        })
    }

    /// The coarsest level that [`Self::solve`] takes; the finest is the subdivision's.
    pub fn coarsest_level(&self) -> usize {
        Self::coarsest_level_of(self.finest_level())
    }

    /// The same before there is a solver: level 0 belongs to the direct solve, unless it is all there is.
    pub fn coarsest_level_of(finest_level: usize) -> usize {
        finest_level.min(1)
    }

    /// Neighbours of each vertex of `level`.
    pub fn valences(&self, level: usize) -> Vec<usize> {
        self.operators[self.finest_level() - level].valences()
    }

    /// out = L u on `level`: u_k minus the mean of its neighbours.
    pub fn laplacian(&self, level: usize, u: &[Vec3A], out: &mut [Vec3A]) {
        self.operators[self.finest_level() - level].laplacian(u, out);
    }

    fn finest_level(&self) -> usize {
        self.preconditioner.level_count()
    }

    /// Solves for `d` from the rows' residual `r`, both on the vertices of `level`. Returns the iterations done.
    ///
    /// On a coarser level the same energy is measured on the coarser mesh: L there, and the anchors through Loop's stencils.
    pub fn solve(&mut self, level: usize, r: &[Vec3A], d: &mut [Vec3A], start: Start, stop: Stop) -> u32 {
        let index = self.finest_level() - level;
        let Self { operators, preconditioner, history, right_side, residual, direction, product } = self;
        let largest = operators[0].vertex_count();
        let operators = &mut operators[index..];
        let count = operators[0].vertex_count();
        let [right_side, residual, direction, product] = [right_side, residual, direction, product].map(|v| {
            v.resize(largest, Vec3A::ZERO);
            &mut v[..count]
        });
        operators[0].right_side(r, right_side);
        if start == Start::Base {
            history.clear();
        }
        if history.guess(d, right_side) {
            // Not of the remembered products: they carry the rounding of their solves, which would add up from frame to frame.
            operators[0].residual(d, right_side, residual);
        } else {
            residual.copy_from_slice(right_side);
        }
        let limit = match stop {
            Stop::Iterations(count) => count,
            Stop::Tolerance(_) => ITERATION_LIMIT,
        };
        let mut energy = Vec3A::ZERO;
        let mut last_largest = f32::INFINITY;
        let mut last_length = 1.0f32;
        let mut iteration = 0;
        let mut is_enough = limit == 0;
        while !is_enough {
            iteration += 1;
            let preconditioned = preconditioner.apply(operators, residual);
            let (next_energy, largest) = energy_and_largest(residual, preconditioned);
            is_enough = iteration == limit;
            if let Stop::Tolerance(tolerance) = stop {
                // The preconditioned residual times the last step's length is nearly the error, and this iteration still lowers it,
                // about as the last one did.
                let contraction = (largest / last_largest).clamp(BEST_CONTRACTION, 1.0);
                is_enough |= last_length * largest * contraction <= tolerance;
            }
            last_largest = largest;
            let ratio = divide(next_energy, energy);
            energy = next_energy;
            for_rows(direction, |first, direction| {
                for (direction, z) in direction.iter_mut().zip(&preconditioned[first..]) {
                    *direction = if iteration == 1 { *z } else { *z + *direction * ratio };
                }
            });
            operators[0].product(direction, product);
            let length = divide(energy, dot(direction, product));
            last_length = length.max_element().max(1.0);
            for_row_pairs(d, residual, |first, d, residual| {
                let rows = d.iter_mut().zip(&direction[first..]).zip(residual.iter_mut().zip(&product[first..]));
                for ((d, direction), (residual, product)) in rows {
                    *d += *direction * length;
                    *residual -= *product * length;
                }
            });
        }
        history.remember(d, right_side, residual);
        iteration
    }
}

/// The inner products of the three coordinates.
fn dot(a: &[Vec3A], b: &[Vec3A]) -> Vec3A {
    of_parts(a.len(), |rows| a[rows.clone()].iter().zip(&b[rows]).map(|(a, b)| *a * *b).sum::<Vec3A>()).iter().sum()
}

/// The inner products of `residual` and `z`, and the greatest length in `z`.
fn energy_and_largest(residual: &[Vec3A], z: &[Vec3A]) -> (Vec3A, f32) {
    let parts = of_parts(z.len(), |rows| {
        let (mut energy, mut largest) = (Vec3A::ZERO, 0.0f32);
        for (residual, z) in residual[rows.clone()].iter().zip(&z[rows]) {
            energy += *residual * *z;
            let square = z.length_squared();
            // As `max` says, which is a call in wasm.
            largest = if square > largest { square } else { largest };
        }
        (energy, largest)
    });
    let energy = parts.iter().map(|(energy, _)| energy).sum();
    (energy, parts.iter().fold(0.0, |largest: f32, part| largest.max(part.1)).sqrt())
}

/// a / b by coordinate; zero where b is not positive, as when that coordinate is solved exactly.
fn divide(a: Vec3A, b: Vec3A) -> Vec3A {
    let is_positive = b.cmpgt(Vec3A::ZERO);
    Vec3A::select(is_positive, a / Vec3A::select(is_positive, b, Vec3A::ONE), Vec3A::ZERO)
}

/// What tests of another implementation compare with.
#[cfg(feature = "fixture")]
impl Solver {
    /// A on a level, counted from the finest.
    pub fn operator(&self, level_below_finest: usize) -> NormalOperator {
        self.operators[level_below_finest].clone()
    }

    /// Solves on the coarsest level.
    pub fn solve_coarsest(&mut self, b: &[Vec3A], x: &mut [Vec3A]) {
        self.preconditioner.coarsest.solve(b, x);
    }

    /// One V-cycle from the finest level.
    pub fn precondition(&mut self, r: &[Vec3A]) -> &[Vec3A] {
        self.preconditioner.apply(&mut self.operators, r)
    }
}

#[cfg(all(test, feature = "factor"))]
mod factor_tests;
#[cfg(all(test, feature = "factor"))]
mod tests;
