//! The preconditioner: one V-cycle over the subdivision hierarchy.
//!
//! Loop's stencils prolong whatever scheme the avatar is refined with: a fourth-order operator needs the smoother interpolation.

use super::normal_operator::NormalOperator;
use super::triangular::DirectSolver;
use crate::mesh::sparse::SparseMatrix;
use glam::Vec3A;

/// A level above the coarsest.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub operator: NormalOperator,
    /// a of the smoother Q = a (α N + β K) a: N^-½, and less at anchors.
    pub scaling: Vec<f32>,
    /// α and β.
    pub weights: [f32; 2],
    /// From the next coarser level, and back.
    prolongation: SparseMatrix,
    restriction: SparseMatrix,
    /// Smoothing steps before and after the coarser level.
    pub steps: usize,
    side: Vec<Vec3A>,
    residual: Vec<Vec3A>,
    correction: Vec<Vec3A>,
}

/// q of the smoother, constant term first. A step multiplies the part of an error where L / 1.5 has the eigenvalue μ by 1 − μ² q(μ).
/// As A is L squared, a linear q costs half a product. This one has the least largest factor, 0.417, for μ in [√0.1, 1]; what is
/// below is left to the coarser level.
const SMOOTHING_POLYNOMIAL: [f32; 2] = [8.26, -7.677];

/// The largest eigenvalue of N⁻¹K on a closed mesh: the sum over all triangles of |x_a + x_b + x_c|² is xᵀ(N + 2 A_dj)x, never negative.
/// A boundary may exceed it a little, which q bears up to 1.6.
const LARGEST_EIGENVALUE: f32 = 1.5;

/// A coarser level has a quarter of the vertices, so a second step there is cheap.
const COARSE_STEPS: usize = 2;

/// The largest eigenvalue of QA allowed. At 2 the V-cycle would lose its definiteness.
const STABLE: f32 = 1.8;

impl Level {
    pub fn new(
        mut operator: NormalOperator,
        is_finest: bool,
        prolongation: SparseMatrix,
        restriction: SparseMatrix,
    ) -> Self {
        let zeros = vec![Vec3A::ZERO; prolongation.row_count()];
        let (diagonal, of_anchors) = operator.diagonal_and_anchor_bound();
        let scaling: Vec<f32> = (diagonal.iter().zip(&of_anchors))
            .zip(&operator.reciprocal_valences)
            .map(|((own, anchors), reciprocal)| (own / (own + anchors) * reciprocal).sqrt())
            .collect();
        let [constant, linear] = SMOOTHING_POLYNOMIAL;
        let square = operator.scale * LARGEST_EIGENVALUE * LARGEST_EIGENVALUE;
        let weights = [constant / square, linear / (LARGEST_EIGENVALUE * square)];
        let largest = largest_eigenvalue(&mut operator, &scaling, weights);
        let weights = weights.map(|weight| weight * (STABLE / largest).min(1.0));
        Self {
            operator,
            scaling,
            weights,
            prolongation,
            restriction,
            steps: if is_finest { 1 } else { COARSE_STEPS },
            side: zeros.clone(),
            residual: zeros.clone(),
            correction: zeros,
        }
    }

    /// Smooths A correction = side from zero and leaves the residual.
    fn smooth_first(&mut self) {
        let Self { operator, scaling, weights, side, residual, correction, steps, .. } = self;
        correction.fill(Vec3A::ZERO);
        operator.add_smoothed(scaling, *weights, side, correction);
        operator.residual(correction, side, residual);
        for _ in 1..*steps {
            operator.add_smoothed(scaling, *weights, residual, correction);
            operator.residual(correction, side, residual);
        }
    }

    /// Adds the coarser level's correction and smooths.
    fn smooth_last(&mut self, coarse: &[Vec3A]) {
        let Self { operator, scaling, weights, prolongation, side, residual, correction, steps, .. } = self;
        prolongation.add_product(coarse, correction);
        operator.residual(correction, side, residual);
        operator.add_smoothed(scaling, *weights, residual, correction);
        for _ in 1..*steps {
            operator.residual(correction, side, residual);
            operator.add_smoothed(scaling, *weights, residual, correction);
        }
    }
}

/// Levels above the coarsest, finest first, and the direct solve there.
#[derive(Clone, Debug)]
pub(super) struct Multigrid {
    pub levels: Vec<Level>,
    pub coarsest: DirectSolver,
    coarsest_side: Vec<Vec3A>,
    coarsest_solution: Vec<Vec3A>,
}

impl Multigrid {
    pub fn new(levels: Vec<Level>, coarsest: DirectSolver, coarsest_count: usize) -> Self {
        let zeros = vec![Vec3A::ZERO; coarsest_count];
        Self { levels, coarsest, coarsest_side: zeros.clone(), coarsest_solution: zeros }
    }

    /// z = M⁻¹ r, M symmetric and positive definite.
    pub fn apply(&mut self, r: &[Vec3A]) -> &[Vec3A] {
        if self.levels.is_empty() {
            self.coarsest.solve(r, &mut self.coarsest_solution);
            return &self.coarsest_solution;
        }
        self.levels[0].side.copy_from_slice(r);
        self.descend(0);
        &self.levels[0].correction
    }

    fn descend(&mut self, index: usize) {
        let (level, coarser) = self.levels[index..].split_first_mut().expect("index of a level");
        level.smooth_first();
        match coarser.first_mut() {
            Some(next) => {
                level.restriction.apply(&level.residual, &mut next.side);
                self.descend(index + 1);
            }
            None => {
                level.restriction.apply(&level.residual, &mut self.coarsest_side);
                self.coarsest.solve(&self.coarsest_side, &mut self.coarsest_solution);
            }
        }
        let (level, coarser) = self.levels[index..].split_first_mut().expect("index of a level");
        level.smooth_last(coarser.first().map_or(&self.coarsest_solution, |next| &next.correction));
    }
}

/// An upper bound of the largest eigenvalue of QA: power iteration on three fixed vectors, and a margin.
fn largest_eigenvalue(operator: &mut NormalOperator, scaling: &[f32], weights: [f32; 2]) -> f32 {
    const STEPS: usize = 12;
    const MARGIN: f32 = 1.1;
    let count = scaling.len();
    let mut x: Vec<Vec3A> =
        (0..count as u32).map(|k| Vec3A::from_array([1, 2, 3].map(|c| fixed_sign(3 * k + c)))).collect();
    let (mut product, mut smoothed) = (x.clone(), x.clone());
    let mut estimate = Vec3A::ONE;
    for _ in 0..STEPS {
        operator.product(&x, &mut product);
        smoothed.fill(Vec3A::ZERO);
        operator.add_smoothed(scaling, weights, &product, &mut smoothed);
        let length =
            |x: &[Vec3A]| x.iter().map(|x| *x * *x).sum::<Vec3A>().powf(0.5).max(Vec3A::splat(f32::MIN_POSITIVE));
        estimate = length(&smoothed) / length(&x);
        let scale = length(&smoothed).recip();
        x.iter_mut().zip(&smoothed).for_each(|(x, smoothed)| *x = *smoothed * scale);
    }
    MARGIN * estimate.max_element().max(f32::MIN_POSITIVE)
}

/// +1 or −1 by a hash of the counter.
fn fixed_sign(counter: u32) -> f32 {
    let mixed = (counter ^ counter >> 15).wrapping_mul(0x2C1B_3C6D);
    if (mixed ^ mixed >> 12).wrapping_mul(0x297A_2D39) >> 31 == 0 { 1.0 } else { -1.0 }
}
