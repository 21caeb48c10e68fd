//! The preconditioner: one V-cycle over the subdivision hierarchy.
//!
//! Loop's stencils prolong whatever scheme the avatar is refined with: a fourth-order operator needs the smoother interpolation.

use super::direct::DirectSolver;
use super::normal_operator::NormalOperator;
use crate::mesh::loop_stencils::LoopStencils;
use glam::Vec3A;
use std::sync::Arc;

/// A level above the coarsest.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// a of the smoother Q = a (α N + β K) a: N^-½, and less at anchors.
    pub scaling: Vec<f32>,
    /// α and β.
    pub weights: [f32; 2],
    /// From the next coarser level, and transposed back.
    stencils: Arc<LoopStencils>,
    /// Smoothing steps before and after the coarser level.
    pub steps: usize,
    /// Room for a cycle, made by the first one.
    residual: Vec<Vec3A>,
    correction: Vec<Vec3A>,
    /// What the coarser level is to solve.
    coarse_side: Vec<Vec3A>,
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
    fn new(operator: &mut NormalOperator, is_finest: bool, stencils: Arc<LoopStencils>) -> Self {
        let (diagonal, of_anchors) = operator.diagonal_and_anchor_bound();
        let scaling: Vec<f32> = (diagonal.iter().zip(&of_anchors))
            .zip(&operator.reciprocal_valences)
            .map(|((own, anchors), reciprocal)| (own / (own + anchors) * reciprocal).sqrt())
            .collect();
        let amplitudes = of_anchors.iter().map(|&anchors| if anchors > 0.0 { 1.0 } else { ELSEWHERE });
        let [constant, linear] = SMOOTHING_POLYNOMIAL;
        let square = operator.scale * LARGEST_EIGENVALUE * LARGEST_EIGENVALUE;
        let weights = [constant / square, linear / (LARGEST_EIGENVALUE * square)];
        let largest = largest_eigenvalue(operator, &scaling, weights, amplitudes);
        operator.give_room_back();
        Self {
            weights: weights.map(|weight| weight * (STABLE / largest).min(1.0)),
            scaling,
            steps: if is_finest { 1 } else { COARSE_STEPS },
            residual: Vec::new(),
            correction: Vec::new(),
            coarse_side: Vec::new(),
            stencils,
        }
    }

    /// Smooths A correction = `side` from zero and hands what is left down.
    fn smooth_first(&mut self, operator: &mut NormalOperator, side: &[Vec3A]) {
        let Self { scaling, weights, residual, correction, coarse_side, stencils, .. } = self;
        residual.resize(side.len(), Vec3A::ZERO);
        correction.resize(side.len(), Vec3A::ZERO);
        coarse_side.resize(stencils.coarse_count(), Vec3A::ZERO);
        operator.smoothed(scaling, *weights, side, correction);
        operator.residual(correction, side, residual);
        for _ in 1..self.steps {
            operator.add_smoothed(scaling, *weights, residual, correction);
            operator.residual(correction, side, residual);
        }
        stencils.apply_transposed(residual, coarse_side);
    }

    /// Adds the coarser level's correction and smooths.
    fn smooth_last(&mut self, operator: &mut NormalOperator, side: &[Vec3A], coarse: &[Vec3A]) {
        let Self { scaling, weights, residual, correction, .. } = self;
        self.stencils.add_product(coarse, correction);
        for _ in 0..self.steps {
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
    coarsest_solution: Vec<Vec3A>,
}

impl Multigrid {
    /// One level for each operator and its stencils from the next coarser level, finest first.
    pub fn new(
        operators: &mut [NormalOperator],
        stencils: &[Arc<LoopStencils>],
        coarsest: DirectSolver,
        coarsest_count: usize,
    ) -> Self {
        let level = |(index, (operator, stencils)): (usize, (&mut NormalOperator, &Arc<LoopStencils>))| {
            Level::new(operator, index == 0, stencils.clone())
        };
        Self {
            levels: operators.iter_mut().zip(stencils).enumerate().map(level).collect(),
            coarsest,
            coarsest_solution: vec![Vec3A::ZERO; coarsest_count],
        }
    }

    /// Levels above the coarsest.
    pub fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// z = M⁻¹ r on the first level of `operators`, M symmetric and positive definite. `operators` are those of the last levels, as many
    /// as levels are to be passed.
    pub fn apply(&mut self, operators: &mut [NormalOperator], r: &[Vec3A]) -> &[Vec3A] {
        let Self { levels, coarsest, coarsest_solution } = self;
        let first = levels.len().saturating_sub(operators.len());
        descend(&mut levels[first..], operators, coarsest, r, coarsest_solution);
        levels[first..].first().map_or(coarsest_solution, |level| &level.correction)
    }
}

fn descend(
    levels: &mut [Level],
    operators: &mut [NormalOperator],
    coarsest: &mut DirectSolver,
    side: &[Vec3A],
    coarsest_solution: &mut [Vec3A],
) {
    let ([level, coarser @ ..], [operator, coarser_operators @ ..]) = (levels, operators) else {
        return coarsest.solve(side, coarsest_solution);
    };
    level.smooth_first(operator, side);
    descend(coarser, coarser_operators, coarsest, &level.coarse_side, coarsest_solution);
    level.smooth_last(operator, side, coarser.first().map_or(coarsest_solution, |next| &next.correction));
}

/// Where the power iteration starts away from anchors, against 1 at them: on a closed mesh only anchors lift an eigenvalue above what q has.
const ELSEWHERE: f32 = 0.1;

/// An upper bound of the largest eigenvalue of QA: power iteration on three fixed vectors of these amplitudes, and a margin.
fn largest_eigenvalue(
    operator: &mut NormalOperator,
    scaling: &[f32],
    weights: [f32; 2],
    amplitudes: impl Iterator<Item = f32>,
) -> f32 {
    const STEPS: usize = 6;
    const MARGIN: f32 = 1.1;
    let signs = |k: u32| Vec3A::from_array([1, 2, 3].map(|c| fixed_sign(3 * k + c)));
    let mut x: Vec<Vec3A> = (0u32..).zip(amplitudes).map(|(k, amplitude)| signs(k) * amplitude).collect();
    let mut product = x.clone();
    let length = |x: &[Vec3A]| x.iter().map(|x| *x * *x).sum::<Vec3A>().powf(0.5).max(Vec3A::splat(f32::MIN_POSITIVE));
    let mut estimate = Vec3A::ONE;
    for _ in 0..STEPS {
        let before = length(&x);
        operator.product(&x, &mut product);
        operator.smoothed(scaling, weights, &product, &mut x);
        let after = length(&x);
        estimate = after / before;
        let scale = after.recip();
        x.iter_mut().for_each(|x| *x *= scale);
    }
    MARGIN * estimate.max_element().max(f32::MIN_POSITIVE)
}

/// +1 or −1 by a hash of the counter.
fn fixed_sign(counter: u32) -> f32 {
    let mixed = (counter ^ counter >> 15).wrapping_mul(0x2C1B_3C6D);
    if (mixed ^ mixed >> 12).wrapping_mul(0x297A_2D39) >> 31 == 0 { 1.0 } else { -1.0 }
}
