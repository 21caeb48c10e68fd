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
    encoded: Vec<f32>,
    activations: [Vec<f32>; 2],
    pose_numbers: Vec<f32>,
    kernel: Vec<f32>,
    factors: Vec<f32>,
}

impl SurfaceFunction {
    /// The subdivision level on whose vertices the function is evaluated.
    pub fn level(&self) -> usize {
        match self {
            Self::Mlp(mlp) => mlp.level as usize,
            Self::Compact(compact) => compact.level as usize,
        }
    }

    /// Values at every vertex of the function's level. `domain` is that level's; `out` has one entry a vertex.
    pub fn evaluate(&self, domain: &Domain, pose: &Pose, scratch: &mut Scratch, out: &mut [Vec3A]) {
        match self {
            Self::Mlp(mlp) => mlp.evaluate(domain, pose, scratch, out),
            Self::Compact(compact) => compact.evaluate(pose, scratch, out),
        }
    }
}
