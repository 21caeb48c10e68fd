//! The two surface functions: f_d (metres) and f_l (δ, 1/m), plain or compact.

mod compact;
mod domain;
mod finite;
mod mlp;

pub use compact::{Compact, Region, matern, six_numbers};
pub use domain::Domain;
pub use mlp::{Layer, Mlp};

use crate::pose_feature::PoseMask;
use crate::rig::Pose;
use glam::Vec3A;

/// A function of surface point and pose, in the canonical (T-pose) frame.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceFunction {
    /// A multilayer perceptron of γ(Q) and θ̄ (the paper's form).
    Mlp(Mlp),
    /// Tables on vertices times coefficients of the pose.
    Compact(Compact),
}

/// Working memory of an evaluation; keep it from frame to frame and nothing is allocated after the first.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    masks: Vec<PoseMask>,
    pose_biases: Vec<f32>,
    pose_numbers: Vec<f32>,
    kernel: Vec<f32>,
    recall: Vec<f32>,
    factors: Vec<f32>,
    row_values: Vec<Vec3A>,
}

impl SurfaceFunction {
    /// The subdivision level on whose vertices the function is evaluated.
    pub fn level(&self) -> usize {
        match self {
            Self::Mlp(mlp) => mlp.level as usize,
            Self::Compact(compact) => compact.level as usize,
        }
    }

    /// The likeliest values: [`Self::evaluate_lively`] without any liveliness.
    pub fn evaluate(&self, domain: &Domain, pose: &Pose, scratch: &mut Scratch, out: &mut [Vec3A]) {
        self.evaluate_lively(domain, pose, 0.0, scratch, out);
    }

    /// Values at every vertex of the function's level. `domain` is that level's; `out` has one entry a vertex. With `liveliness` 1 a pose far
    /// from training has what the training poses nearest to it had, as far as the function recalls; with 0 what is likeliest.
    pub fn evaluate_lively(
        &self,
        domain: &Domain,
        pose: &Pose,
        liveliness: f32,
        scratch: &mut Scratch,
        out: &mut [Vec3A],
    ) {
        match self {
            Self::Mlp(mlp) => mlp.evaluate(domain, pose, scratch, out),
            Self::Compact(compact) => compact.evaluate_lively(pose, liveliness, scratch, out),
        }
    }
}
