//! Pose to base mesh: what is there before the solver is.

use super::{Options, Part, PosedSurface, Stage};
use crate::avatar::{Avatar, AvatarError};
use crate::body::Pose;
use crate::mesh::{Subdivision, Triangle};
use crate::network::{Domain, Scratch};
use crate::solver::Solver;
use glam::Vec3A;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// An avatar made ready to move as far as its base mesh: topology and f_d, no solver.
pub struct BaseAnimator {
    pub(super) avatar: Arc<Avatar>,
    pub(super) subdivision: Arc<Subdivision>,
    domain: Domain,
    pub(super) surface: PosedSurface,
    pub(super) scratch: Scratch,
    offsets: Vec<Vec3A>,
}

impl BaseAnimator {
    /// Prepares `avatar`, after [`Avatar::validate`] and a look at f_d's values in the rest pose.
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        avatar.validate(&avatar.name)?;
        let count = avatar.rig.rest.len();
        let domain = Domain::coarsest(&avatar.canonical, &avatar.rig.skin);
        if let Some(vertex) = avatar.deformation.not_finite_at_rest(&domain, avatar.rig.parents.len()) {
            return Err(AvatarError::not_finite(&avatar.name, "deformation", vertex));
        }
        let subdivision = Subdivision::new(count, &avatar.triangles, avatar.level_count as usize);
        Ok(Self {
            domain,
            surface: PosedSurface::new(&subdivision),
            scratch: Scratch::default(),
            offsets: vec![Vec3A::ZERO; count],
            subdivision: Arc::new(subdivision),
            avatar,
        })
    }

    /// The same avatar, with room of its own, which its first frame makes.
    pub fn anew(&self) -> Self {
        Self {
            avatar: Arc::clone(&self.avatar),
            subdivision: Arc::clone(&self.subdivision),
            domain: self.domain.clone(),
            surface: PosedSurface::new(&self.subdivision),
            scratch: Scratch::default(),
            offsets: self.offsets.clone(),
        }
    }

    /// Poses the base, or the body where `options` ask for it, and tells `observe` of each part when it is done. The detailed stage is not
    /// reached. Positions (metres, vertices of [`Options::level`]) stay valid until the next call.
    pub fn animate_observed(&mut self, pose: &Pose, options: &Options, observe: &mut dyn FnMut(Part)) -> &[Vec3A] {
        let level = self.level(options);
        let Self { avatar, subdivision, domain, surface, scratch, offsets } = self;
        let offsets: &[Vec3A] = if options.stage == Stage::Body {
            &[]
        } else {
            avatar.deformation.evaluate_lively(domain, pose, options.liveliness, scratch, offsets);
            offsets
        };
        observe(Part::Deformation);
        surface.pose(&avatar.rig, offsets, pose, subdivision, avatar.scheme, level);
        observe(Part::Base);
        surface.positions(level)
    }

    /// Levels that can be asked for.
    pub fn levels(&self) -> RangeInclusive<usize> {
        let finest = self.subdivision.level_count();
        Solver::coarsest_level_of(finest).max(self.avatar.laplacian.level())..=finest
    }

    /// The level of the mesh that `options` ask for.
    pub(super) fn level(&self, options: &Options) -> usize {
        let (coarsest, finest) = self.levels().into_inner();
        options.level.clamp(coarsest, finest)
    }

    /// The avatar.
    pub fn avatar(&self) -> &Arc<Avatar> {
        &self.avatar
    }

    /// Topology of all levels.
    pub fn subdivision(&self) -> &Arc<Subdivision> {
        &self.subdivision
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        self.subdivision.triangles(self.subdivision.level_count())
    }
}
