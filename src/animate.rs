//! Pose to detailed mesh on the CPU: the one definition of correct.

use crate::avatar::{Avatar, AvatarError};
use crate::body::Pose;
use crate::mesh::{Mesh, Triangle};
use crate::solver::Stop;
use glam::Vec3A;
use std::sync::Arc;

/// How far down the pipeline a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Stage {
    /// The skinned body, subdivided.
    Body,
    /// The pose-dependent base mesh, subdivided.
    Base,
    /// The detailed mesh.
    #[default]
    Detailed,
}

/// Choices of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How far to go.
    pub stage: Stage,
    /// 0 is the base, 1 as trained, 2 exaggerated.
    pub detail: f32,
    /// When the solver stops.
    pub stop: Stop,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            stage: Stage::Detailed,
            detail: 1.0,
            stop: Stop::Tolerance(1e-5),
        }
    }
}

/// An avatar made ready to move: all that no frame changes, and scratch space.
pub struct Animator {}

impl Animator {
    /// Prepares `avatar`.
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        let _ = avatar;
        todo!()
    }

    /// Poses the avatar. The result depends on pose and options alone, within the solver's tolerance.
    /// Positions (finest level, metres) stay valid until the next call.
    pub fn animate(&mut self, pose: &Pose, options: &Options) -> &[Vec3A] {
        let _ = (pose, options);
        todo!()
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        todo!()
    }
}

/// Poses `avatar` once. For many frames keep an [`Animator`].
pub fn animate(avatar: &Avatar, pose: &Pose, options: &Options) -> Result<Mesh, AvatarError> {
    let mut animator = Animator::new(Arc::new(avatar.clone()))?;
    let positions = animator.animate(pose, options).to_vec();
    Ok(Mesh {
        positions,
        triangles: animator.triangles().to_vec(),
    })
}
