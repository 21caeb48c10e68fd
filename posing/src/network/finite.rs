//! Whether finite weights give finite values: what no look at the numbers of a file tells.

use super::{Domain, Scratch, SurfaceFunction};
use crate::rig::Pose;
use glam::Vec3A;

/// Vertices at which perceptrons are looked at; all of them would take seconds.
const SAMPLE: usize = 256;

impl SurfaceFunction {
    /// A vertex at which the value in the rest pose is not finite, among all for tables and among a sample for perceptrons.
    /// `domain` is that of the function's level.
    pub fn not_finite_at_rest(&self, domain: &Domain, joint_count: usize) -> Option<usize> {
        let count = domain.canonical.len();
        let stride = match self {
            Self::Compact(_) => 1,
            Self::Mlp(_) => count.div_ceil(SAMPLE).max(1),
        };
        let sample = Domain {
            canonical: domain.canonical.iter().step_by(stride).copied().collect(),
            masks: domain.masks.iter().step_by(stride).copied().collect(),
        };
        let mut values = vec![Vec3A::ZERO; sample.canonical.len()];
        self.evaluate(&sample, &Pose::rest(joint_count), &mut Scratch::default(), &mut values);
        values.iter().position(|value| !value.is_finite()).map(|at| at * stride)
    }
}
