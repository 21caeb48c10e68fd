//! Plays motions on an avatar: a clock, the motion it reads, and the animator it drives. No GPU, no browser.

mod clock;

pub use clock::Clock;

use crate::animate::{Animator, Options};
use crate::avatar::{Avatar, AvatarError};
use crate::body::Pose;
use crate::mesh::{Triangle, vertex_normals};
use crate::motion::Motion;
use glam::{Vec3, Vec3A};
use std::sync::Arc;

/// A motion that the avatar's skeleton cannot follow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("motion: pose {pose}: expected {expected} joint rotations, found {found}")]
pub struct JointCountError {
    /// Which pose of the motion.
    pub pose: usize,
    /// Joints of the avatar.
    pub expected: usize,
    /// Joints of the pose.
    pub found: usize,
}

/// An avatar, the motion that it plays, and when.
pub struct Player {
    avatar: Arc<Avatar>,
    animator: Animator,
    motion: Option<Motion>,
    standing: Pose,
    /// Play, pause, seek, loop and rate.
    pub clock: Clock,
    /// View (body, base or detailed), amount of detail, when the solver stops.
    pub options: Options,
    shown: Option<(Pose, Options)>,
    positions: Vec<Vec3A>,
    normals: Vec<Vec3A>,
}

impl Player {
    /// Prepares `avatar`. It stands in its rest pose, feet on the floor, until there is a motion.
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        let animator = Animator::new(avatar.clone())?;
        let standing = standing_pose(&avatar);
        Ok(Self {
            avatar,
            animator,
            motion: None,
            standing,
            clock: Clock::default(),
            // Poses follow each other, so the last frame is a good first guess for the solver.
            options: Options { warm_start: true, ..Options::default() },
            shown: None,
            positions: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// Replaces the motion and starts it from the beginning; `None` goes back to the rest pose.
    pub fn set_motion(&mut self, motion: Option<Motion>) -> Result<(), JointCountError> {
        if let Some(motion) = &motion {
            check_joints(motion, self.avatar.rig.parents.len())?;
        }
        self.clock.set_duration(motion.as_ref().map_or(0.0, |motion| f64::from(motion.duration())));
        self.motion = motion;
        Ok(())
    }

    /// The pose at the clock's time.
    pub fn pose(&self) -> Pose {
        match &self.motion {
            Some(motion) => motion.sample(self.clock.seconds() as f32),
            None => self.standing.clone(),
        }
    }

    /// Where the root joint is now, metres.
    pub fn root(&self) -> Vec3 {
        let translation = match &self.shown {
            Some((pose, _)) => pose.translation,
            None => self.pose().translation,
        };
        Vec3::from(self.avatar.rig.rest_joints[0]) + translation
    }

    /// Moves the clock by `seconds` of real time and returns what is to be shown if that changed, for whoever poses the avatar elsewhere.
    pub fn step(&mut self, seconds: f64) -> Option<&(Pose, Options)> {
        self.clock.advance(seconds);
        let wanted = (self.pose(), self.options);
        if self.shown.as_ref() == Some(&wanted) {
            return None;
        }
        Some(self.shown.insert(wanted))
    }

    /// Moves the clock by `seconds` of real time and poses the avatar if pose or options changed. Returns whether they did.
    pub fn advance(&mut self, seconds: f64) -> bool {
        if self.step(seconds).is_none() {
            return false;
        }
        let Some((pose, options)) = &self.shown else { return false };
        let positions = self.animator.animate(pose, options);
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.normals.resize(self.positions.len(), Vec3A::ZERO);
        vertex_normals(&self.positions, self.animator.triangles(), &mut self.normals);
        true
    }

    /// Positions of the finest level after the last [`Self::advance`], metres. Empty before the first.
    pub fn positions(&self) -> &[Vec3A] {
        &self.positions
    }

    /// Unit normals of the mesh that is shown, one for each position.
    pub fn normals(&self) -> &[Vec3A] {
        &self.normals
    }

    /// Vertices of the finest level.
    pub fn vertex_count(&self) -> usize {
        let subdivision = self.animator.subdivision();
        subdivision.vertex_count(subdivision.level_count())
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        self.animator.triangles()
    }

    /// What poses the avatar on the CPU.
    pub fn animator(&self) -> &Animator {
        &self.animator
    }

    /// The avatar.
    pub fn avatar(&self) -> &Avatar {
        self.animator.avatar()
    }
}

/// The rest pose, lifted or lowered until its lowest vertex touches the floor y = 0.
fn standing_pose(avatar: &Avatar) -> Pose {
    let lowest = avatar.rig.rest.iter().map(|vertex| vertex.y).fold(f32::INFINITY, f32::min);
    let lift = if lowest.is_finite() { -lowest } else { 0.0 };
    Pose { translation: Vec3::new(0.0, lift, 0.0), ..Pose::rest(avatar.rig.parents.len()) }
}

fn check_joints(motion: &Motion, expected: usize) -> Result<(), JointCountError> {
    match motion.poses.iter().position(|pose| pose.rotations.len() != expected) {
        Some(pose) => Err(JointCountError { pose, expected, found: motion.poses[pose].rotations.len() }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(joint_counts: &[usize]) -> Motion {
        Motion {
            poses: joint_counts.iter().map(|&count| Pose::rest(count)).collect(),
            frames_per_second: 30.0,
            notes: Vec::new(),
        }
    }

    #[test]
    fn a_motion_for_this_skeleton_is_accepted() {
        assert_eq!(check_joints(&motion(&[24, 24]), 24), Ok(()));
    }

    #[test]
    fn a_motion_for_another_skeleton_is_named() {
        let error = check_joints(&motion(&[24, 22]), 24).unwrap_err();
        assert_eq!(error, JointCountError { pose: 1, expected: 24, found: 22 });
        assert_eq!(error.to_string(), "motion: pose 1: expected 24 joint rotations, found 22");
    }
}
