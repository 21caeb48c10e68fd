//! The two surface functions: f_d (metres) and f_l (δ, 1/m), plain or compact.

mod compact;
mod domain;
mod mlp;

pub use compact::{Compact, Region};
pub use domain::Domain;
pub use mlp::{Layer, Mlp};

use crate::body::Pose;
use glam::Vec3A;

/// A function of surface point and pose, in the canonical (T-pose) frame.
#[derive(Clone, Debug)]
pub enum SurfaceFunction {
    /// A multilayer perceptron of γ(Q) and θ̄ (the paper's form).
    Mlp(Mlp),
    /// Tables on vertices times coefficients of the pose.
    Compact(Compact),
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
    pub fn evaluate(&self, domain: &Domain, pose: &Pose, out: &mut [Vec3A]) {
        match self {
            Self::Mlp(mlp) => mlp.evaluate(domain, pose, out),
            Self::Compact(compact) => compact.evaluate(pose, out),
        }
    }
}
