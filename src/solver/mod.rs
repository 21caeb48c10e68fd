//! Laplacian reconstruction: (LᵀL + w_a S) d = Lᵀ r by multigrid-preconditioned conjugate gradients.
//!
//! d is the displacement from the subdivided base mesh, r the wanted Laplacian less the base's own, in metres a row. Anchors hold
//! d at zero softly. The matrix depends on topology alone; the coarse level is factored once for each avatar.

mod factor;

pub use factor::CoarseFactor;

use crate::mesh::Subdivision;
use glam::Vec3A;

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
pub struct Solver {}

impl Solver {
    /// `anchors` are vertices of the finest level, ascending. `factor` belongs to the same topology, anchors and weight.
    pub fn new(
        subdivision: &Subdivision,
        anchors: &[u32],
        anchor_weight: f32,
        factor: CoarseFactor,
    ) -> Self {
        let _ = (subdivision, anchors, anchor_weight, factor);
        todo!()
    }

    /// Solves for `d` (finest level) from the rows' residual `r`; `d` comes in as the first guess. Returns the iterations done.
    pub fn solve(&mut self, r: &[Vec3A], d: &mut [Vec3A], stop: Stop) -> u32 {
        let _ = (r, d, stop);
        todo!()
    }
}
