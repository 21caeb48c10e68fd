//! Normal equations of a sum of weighted squares, and the Gauss–Newton step that they ask for.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// H δ = −g for residuals r with rows J: H = Σ w JᵀJ, g = Σ w Jᵀ r.
#[derive(Clone, Debug)]
pub struct System {
    /// Row-major; the upper triangle alone is filled.
    hessian: Vec<f64>,
    gradient: Vec<f64>,
}

/// An unknown and the residual's derivative by it.
pub type Entry = (usize, f64);

impl System {
    /// Of `count` unknowns, with nothing asked for.
    pub fn new(count: usize) -> Self {
        Self { hessian: vec![0.0; count * count], gradient: vec![0.0; count] }
    }

    /// Number of unknowns.
    pub fn count(&self) -> usize {
        self.gradient.len()
    }

    /// Adds `weight`·r² for a residual with the derivatives `row`.
    pub fn add(&mut self, row: &[Entry], residual: f64, weight: f64) {
        let count = self.count();
        for (at, &(i, a)) in row.iter().enumerate() {
            self.gradient[i] += weight * a * residual;
            for &(j, b) in &row[at..] {
                let (first, second) = (i.min(j), i.max(j));
                self.hessian[first * count + second] += weight * a * b;
            }
        }
    }

    /// [`Self::add`] for a row in which an unknown may come several times: its derivatives are summed.
    pub fn add_repeated(&mut self, mut row: Vec<Entry>, residual: f64, weight: f64) {
        row.sort_by_key(|entry| entry.0);
        let mut summed: Vec<Entry> = Vec::with_capacity(row.len());
        for (unknown, value) in row {
            match summed.last_mut() {
                Some(last) if last.0 == unknown => last.1 += value,
                _ => summed.push((unknown, value)),
            }
        }
        self.add(&summed, residual, weight);
    }

    /// Adds another system of as many unknowns, or of the first of them.
    pub fn merge(mut self, other: &Self) -> Self {
        let (count, own) = (other.count(), self.count());
        for i in 0..count {
            self.gradient[i] += other.gradient[i];
            for j in i..count {
                self.hessian[i * own + j] += other.hessian[i * count + j];
            }
        }
        self
    }

    /// H_ij.
    pub fn hessian(&self, i: usize, j: usize) -> f64 {
        self.hessian[i.min(j) * self.count() + i.max(j)]
    }

    /// g_i.
    pub fn gradient(&self, i: usize) -> f64 {
        self.gradient[i]
    }

    /// The step of Levenberg and Marquardt: (H + `damping` diag H) δ = −g. Zero where the system cannot be solved.
    pub fn step(&self, damping: f64) -> Vec<f64> {
        let count = self.count();
        let matrix = Mat::<f64>::from_fn(count, count, |i, j| {
            self.hessian(i, j) + if i == j { damping * self.hessian(i, i) + 1e-12 } else { 0.0 }
        });
        let right = Mat::<f64>::from_fn(count, 1, |i, _| -self.gradient[i]);
        match matrix.llt(Side::Lower) {
            Ok(factor) => {
                let step = factor.solve(right);
                (0..count).map(|i| step[(i, 0)]).collect()
            }
            Err(_) => vec![0.0; count],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_solves_a_linear_problem() {
        // x + 2 y = 5, 3 x − y = 1, z = 4 twice.
        let mut system = System::new(3);
        system.add(&[(0, 1.0), (1, 2.0)], -5.0, 1.0);
        let mut other = System::new(3);
        other.add(&[(1, -1.0), (0, 3.0)], -1.0, 0.5);
        other.add(&[(2, 1.0)], -4.0, 2.0);
        let step = system.merge(&other).step(0.0);
        for (found, expected) in step.iter().zip([1.0, 2.0, 4.0]) {
            assert!((found - expected).abs() < 1e-6, "{step:?}");
        }
    }

    #[test]
    fn damping_shortens_the_step_and_nothing_asked_moves_nothing() {
        let mut system = System::new(2);
        system.add(&[(0, 2.0)], 1.0, 1.0);
        assert!((system.step(0.0)[0] + 0.5).abs() < 1e-6 && (system.step(1.0)[0] + 0.25).abs() < 1e-6);
        assert_eq!(system.step(0.0)[1], 0.0);
    }
}
