//! How far an avatar is ready: its base at once, its detail with the solver.

use crate::animate::{Animator, BaseAnimator, Options, Part};
use crate::body::Pose;
use crate::mesh::Subdivision;
use glam::Vec3A;
use std::ops::RangeInclusive;

/// The base is there at once, so that a page need not wait for the solver to show something.
#[expect(clippy::large_enum_variant, reason = "a player has one of them")]
pub(super) enum Prepared {
    Base(BaseAnimator),
    Detailed(Animator),
}

impl Prepared {
    pub(super) fn animate(&mut self, pose: &Pose, options: &Options, observe: &mut dyn FnMut(Part)) -> &[Vec3A] {
        match self {
            Self::Base(base) => base.animate_observed(pose, options, observe),
            Self::Detailed(animator) => animator.animate_observed(pose, options, observe),
        }
    }

    pub(super) fn subdivision(&self) -> &Subdivision {
        match self {
            Self::Base(base) => base.subdivision(),
            Self::Detailed(animator) => animator.subdivision(),
        }
    }

    pub(super) fn levels(&self) -> RangeInclusive<usize> {
        match self {
            Self::Base(base) => base.levels(),
            Self::Detailed(animator) => animator.levels(),
        }
    }
}
