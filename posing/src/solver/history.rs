//! A first guess from the solutions of the frames before.
//!
//! Wrinkles change smoothly from frame to frame, so the new solution nearly lies in the span of the last ones. The guess is the element of
//! that span with the least error in the norm of A (Fischer 1998, *Projection techniques for iterative solution of Ax = b with successive
//! right-hand sides*). It needs no product with A: what a solve ends with gives A d = b − residual.

use crate::threads::{for_row_pairs, for_rows, of_parts};
use glam::Vec3A;
use std::ops::Range;

/// The last solutions and what A makes of them, in memory that is kept.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    latest: Solution,
    before: Solution,
    /// How many of the two there are.
    count: usize,
}

#[derive(Clone, Debug, Default)]
struct Solution {
    d: Vec<Vec3A>,
    product: Vec<Vec3A>,
}

/// The change between two solutions counts where it has at least this part of its energy outside the latest one's direction …
const LEAST_INDEPENDENCE: f32 = 1e-4;
/// … and no more than this many times: of a figure that stands nearly still it is rounding, and its products with A are none.
const GREATEST_CHANGE: f32 = 2.0;

impl Solution {
    /// The solution and its product with A at these rows.
    fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = (&Vec3A, &Vec3A)> {
        self.d[rows.clone()].iter().zip(&self.product[rows])
    }
}

impl History {
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Sets `d` to the guess for the right side `b`; to zero, and tells so by `false`, where there is nothing to guess from.
    pub fn guess(&self, d: &mut [Vec3A], b: &[Vec3A]) -> bool {
        let of_same_level = |solution: &&Solution| solution.d.len() == d.len();
        let Some(latest) = Some(&self.latest).filter(|_| self.count > 0).filter(of_same_level) else {
            d.fill(Vec3A::ZERO);
            return false;
        };
        // Of a single solution there is no change, and the span is its direction.
        let before = Some(&self.before).filter(|_| self.count > 1).filter(of_same_level).unwrap_or(latest);
        // In the basis u (the latest) and v (the last change): two equations for each coordinate.
        let parts = of_parts(d.len(), |rows| {
            let [mut uau, mut uav, mut vav, mut ub, mut vb] = [Vec3A::ZERO; 5];
            let [latest, before] = [latest, before].map(|solution| solution.rows(rows.clone()));
            for (((u, au), (d, ad)), b) in latest.zip(before).zip(&b[rows]) {
                let (v, av) = (*u - *d, *au - *ad);
                uau += *u * *au;
                uav += *u * av;
                vav += v * av;
                ub += *u * *b;
                vb += v * *b;
            }
            [uau, uav, vav, ub, vb]
        });
        let [uau, uav, vav, ub, vb] = std::array::from_fn(|i| parts.iter().map(|part| part[i]).sum::<Vec3A>());
        let share = super::divide(uav, uau);
        let independent = vav - uav * share;
        let is_independent = independent.cmpgt(vav * LEAST_INDEPENDENCE);
        let of_change = super::divide(vb - ub * share, Vec3A::select(is_independent, independent, Vec3A::ZERO));
        let of_change = of_change.clamp(Vec3A::splat(-GREATEST_CHANGE), Vec3A::splat(GREATEST_CHANGE));
        let of_latest = super::divide(ub - uav * of_change, uau) + of_change;
        for_rows(d, |first, d| {
            for ((u, e), d) in latest.d[first..].iter().zip(&before.d[first..]).zip(d) {
                *d = *u * of_latest - *e * of_change;
            }
        });
        true
    }

    /// Remembers the solution `d` of the right side `b`, of which `residual` was left.
    pub fn remember(&mut self, d: &[Vec3A], b: &[Vec3A], residual: &[Vec3A]) {
        std::mem::swap(&mut self.latest, &mut self.before);
        self.count = (self.count + 1).min(2);
        let Solution { d: latest, product } = &mut self.latest;
        latest.resize(d.len(), Vec3A::ZERO);
        product.resize(d.len(), Vec3A::ZERO);
        for_row_pairs(latest, product, |first, latest, product| {
            latest.copy_from_slice(&d[first..][..latest.len()]);
            for (product, (b, residual)) in product.iter_mut().zip(b[first..].iter().zip(&residual[first..])) {
                *product = *b - *residual;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_that_is_rounding_is_not_blown_up() {
        const COUNT: usize = 50;
        let mut history = History::default();
        let (d, b) = (vec![Vec3A::ONE; COUNT], vec![Vec3A::ONE; COUNT]);
        history.remember(&d, &b, &[Vec3A::ZERO; COUNT]);
        // A ten-thousandth more at one vertex, of which almost nothing is left in the product.
        let (mut moved, mut residual) = (d.clone(), vec![Vec3A::ZERO; COUNT]);
        moved[7] += 1e-4;
        residual[7] -= 1e-6;
        history.remember(&moved, &b, &residual);
        let mut guess = d.clone();
        let mut left = b.clone();
        left[7] += 0.1;
        history.guess(&mut guess, &left);
        let off = guess.iter().map(|guess| guess.distance(Vec3A::ONE)).fold(0.0, f32::max);
        assert!(off < 0.01, "{off}");
    }
}
