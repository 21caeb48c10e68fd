//! Conjugate gradients on fields of vectors, for the quadratic energies of surface fitting.

use glam::Vec3A;

/// Solves A x = b for a symmetric positive definite `apply` (out = A x), from the guess in `x`, with the Jacobi preconditioner
/// `inverse_diagonal`; stops after `iteration_count` steps or when the residual has shrunk by `reduction`.
pub fn conjugate_gradients(
    apply: &mut dyn FnMut(&[Vec3A], &mut [Vec3A]),
    inverse_diagonal: &[f32],
    b: &[Vec3A],
    x: &mut [Vec3A],
    iteration_count: usize,
    reduction: f64,
) {
    let n = b.len();
    let mut applied = vec![Vec3A::ZERO; n];
    apply(x, &mut applied);
    let mut residual: Vec<Vec3A> = b.iter().zip(&applied).map(|(&b, &a)| b - a).collect();
    let precondition =
        |residual: &[Vec3A]| -> Vec<Vec3A> { residual.iter().zip(inverse_diagonal).map(|(&r, &m)| r * m).collect() };
    let mut preconditioned = precondition(&residual);
    let mut direction = preconditioned.clone();
    let mut rho = dot(&residual, &preconditioned);
    let target = rho * reduction * reduction;
    for _ in 0..iteration_count {
        if rho <= target || rho == 0.0 {
            break;
        }
        apply(&direction, &mut applied);
        let step = (rho / dot(&direction, &applied)) as f32;
        for i in 0..n {
            x[i] += step * direction[i];
            residual[i] -= step * applied[i];
        }
        preconditioned = precondition(&residual);
        let next = dot(&residual, &preconditioned);
        let beta = (next / rho) as f32;
        for i in 0..n {
            direction[i] = preconditioned[i] + beta * direction[i];
        }
        rho = next;
    }
}

fn dot(a: &[Vec3A], b: &[Vec3A]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.dot(*b))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_small_system_exactly() {
        // Tridiagonal (-1, 2.5, -1).
        let n = 12;
        let apply = |x: &[Vec3A], out: &mut [Vec3A]| {
            for i in 0..n {
                out[i] = 2.5 * x[i];
                if i > 0 {
                    out[i] -= x[i - 1];
                }
                if i + 1 < n {
                    out[i] -= x[i + 1];
                }
            }
        };
        let expected: Vec<Vec3A> = (0..n).map(|i| Vec3A::new(i as f32, (i * i) as f32, 1.0)).collect();
        let mut b = vec![Vec3A::ZERO; n];
        apply(&expected, &mut b);
        let mut x = vec![Vec3A::ZERO; n];
        conjugate_gradients(&mut { apply }, &vec![0.4; n], &b, &mut x, 50, 1e-7);
        for (x, expected) in x.iter().zip(&expected) {
            assert!((*x - *expected).length() < 1e-3, "{x} is not {expected}");
        }
    }
}
