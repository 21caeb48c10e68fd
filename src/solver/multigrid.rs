//! The preconditioner: one V-cycle over the subdivision hierarchy.
//!
//! Loop's stencils prolong whatever scheme the avatar is refined with: a fourth-order operator needs the smoother interpolation.

use super::normal_operator::NormalOperator;
use super::triangular::DirectSolver;
use crate::mesh::sparse::SparseMatrix;
use glam::Vec3A;

/// A symmetric positive definite matrix.
#[derive(Clone, Debug)]
pub(super) enum Operator {
    /// The finest level's.
    Normal(NormalOperator),
    /// A coarser one, assembled.
    Assembled(SparseMatrix),
}

impl Operator {
    /// out −= A x.
    pub fn subtract_product(&mut self, x: &[Vec3A], out: &mut [Vec3A]) {
        match self {
            Self::Normal(normal) => normal.subtract_product(x, out),
            Self::Assembled(matrix) => {
                for (i, out) in out.iter_mut().enumerate() {
                    let mut sum = Vec3A::ZERO;
                    for (column, value) in matrix.row(i) {
                        sum += x[column as usize] * value;
                    }
                    *out -= sum;
                }
            }
        }
    }

    fn diagonal(&self) -> Vec<f32> {
        match self {
            Self::Normal(normal) => normal.diagonal(),
            Self::Assembled(matrix) => {
                let entry = |i| matrix.row(i).find(|&(column, _)| column as usize == i).map_or(1.0, |(_, value)| value);
                (0..matrix.row_count()).map(entry).collect()
            }
        }
    }
}

/// A level above the coarsest.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub operator: Operator,
    reciprocal_diagonal: Vec<f32>,
    /// An upper bound of the eigenvalues of D⁻¹A.
    largest_eigenvalue: f32,
    /// From the next coarser level, and back.
    prolongation: SparseMatrix,
    restriction: SparseMatrix,
    residual: Vec<Vec3A>,
    correction: Vec<Vec3A>,
    step: Vec<Vec3A>,
}

/// The share of the spectrum, from above, that the smoother damps. What is below is left to the coarser level.
const SMOOTHED_SHARE: f32 = 0.1;

impl Level {
    pub fn new(mut operator: Operator, prolongation: SparseMatrix) -> Self {
        let count = prolongation.row_count();
        let reciprocal_diagonal: Vec<f32> = operator.diagonal().iter().map(|d| d.recip()).collect();
        let largest_eigenvalue = largest_eigenvalue(&mut operator, &reciprocal_diagonal);
        let zeros = vec![Vec3A::ZERO; count];
        Self {
            operator,
            reciprocal_diagonal,
            largest_eigenvalue,
            restriction: prolongation.transposed(),
            prolongation,
            residual: zeros.clone(),
            correction: zeros.clone(),
            step: zeros,
        }
    }

    /// Two Chebyshev steps on A x = residual: adds to `correction` and lowers `residual`. When nobody needs the residual any more
    /// (`is_last`), its second update is left out.
    fn smooth(&mut self, is_last: bool) {
        let (upper, lower) = (self.largest_eigenvalue, SMOOTHED_SHARE * self.largest_eigenvalue);
        let (centre, half_width) = (0.5 * (upper + lower), 0.5 * (upper - lower));
        let sigma = centre / half_width;
        let rho = 1.0 / (2.0 * sigma - 1.0 / sigma);
        let Self { operator, reciprocal_diagonal, residual, correction, step, .. } = self;
        let first = centre.recip();
        for (((step, correction), residual), reciprocal) in
            step.iter_mut().zip(&mut *correction).zip(&*residual).zip(&*reciprocal_diagonal)
        {
            *step = *residual * (reciprocal * first);
            *correction += *step;
        }
        operator.subtract_product(step, residual);
        let (kept, second) = (rho / sigma, 2.0 * rho / half_width);
        for (((step, correction), residual), reciprocal) in
            step.iter_mut().zip(&mut *correction).zip(&*residual).zip(&*reciprocal_diagonal)
        {
            *step = *step * kept + *residual * (reciprocal * second);
            *correction += *step;
        }
        if !is_last {
            self.operator.subtract_product(&self.step, &mut self.residual);
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
    pub fn apply(&mut self, r: &[Vec3A], z: &mut [Vec3A]) {
        if self.levels.is_empty() {
            return self.coarsest.solve(r, z);
        }
        self.levels[0].residual.copy_from_slice(r);
        self.descend(0);
        z.copy_from_slice(&self.levels[0].correction);
    }

    fn descend(&mut self, index: usize) {
        let (level, coarser) = self.levels[index..].split_first_mut().expect("index of a level");
        level.correction.fill(Vec3A::ZERO);
        level.smooth(false);
        match coarser.first_mut() {
            Some(next) => {
                level.restriction.apply(&level.residual, &mut next.residual);
                self.descend(index + 1);
            }
            None => {
                level.restriction.apply(&level.residual, &mut self.coarsest_side);
                self.coarsest.solve(&self.coarsest_side, &mut self.coarsest_solution);
            }
        }
        let (level, coarser) = self.levels[index..].split_first_mut().expect("index of a level");
        let coarse = coarser.first().map_or(&self.coarsest_solution, |next| &next.correction);
        level.prolongation.apply(coarse, &mut level.step);
        for (correction, step) in level.correction.iter_mut().zip(&level.step) {
            *correction += *step;
        }
        level.operator.subtract_product(&level.step, &mut level.residual);
        level.smooth(true);
    }
}

/// An upper bound of the largest eigenvalue of D⁻¹A: power iteration on three fixed vectors, and a margin.
fn largest_eigenvalue(operator: &mut Operator, reciprocal_diagonal: &[f32]) -> f32 {
    const STEPS: usize = 12;
    const MARGIN: f32 = 1.1;
    let count = reciprocal_diagonal.len();
    let mut x: Vec<Vec3A> =
        (0..count as u32).map(|k| Vec3A::from_array([1, 2, 3].map(|c| fixed_sign(3 * k + c)))).collect();
    let mut estimate = Vec3A::ONE;
    for _ in 0..STEPS {
        let mut y = vec![Vec3A::ZERO; count];
        operator.subtract_product(&x, &mut y);
        for (y, reciprocal) in y.iter_mut().zip(reciprocal_diagonal) {
            *y *= -*reciprocal;
        }
        let length = |x: &[Vec3A]| x.iter().map(|x| *x * *x).sum::<Vec3A>().powf(0.5);
        estimate = length(&y) / length(&x).max(Vec3A::splat(f32::MIN_POSITIVE));
        let scale = length(&y).max(Vec3A::splat(f32::MIN_POSITIVE)).recip();
        x = y.iter().map(|y| *y * scale).collect();
    }
    MARGIN * estimate.max_element().max(f32::MIN_POSITIVE)
}

/// +1 or −1 by a hash of the counter.
fn fixed_sign(counter: u32) -> f32 {
    let mixed = (counter ^ counter >> 15).wrapping_mul(0x2C1B_3C6D);
    if (mixed ^ mixed >> 12).wrapping_mul(0x297A_2D39) >> 31 == 0 { 1.0 } else { -1.0 }
}
