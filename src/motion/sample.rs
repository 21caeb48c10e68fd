//! A motion at any moment: rotations by spherical interpolation, translations linearly.

use super::Motion;
use crate::body::Pose;

impl Motion {
    /// Seconds from the first pose to the last.
    pub fn duration(&self) -> f32 {
        (self.poses.len() - 1) as f32 / self.frames_per_second
    }

    /// Seconds after which [`Self::sample_looped`] repeats: one frame longer than [`Self::duration`], in which the
    /// last pose turns into the first.
    pub fn loop_duration(&self) -> f32 {
        self.poses.len() as f32 / self.frames_per_second
    }

    /// The pose at `seconds`, clamped to the motion.
    pub fn sample(&self, seconds: f32) -> Pose {
        let mut pose = Pose::rest(0);
        self.sample_into(seconds, &mut pose);
        pose
    }

    /// [`Self::sample`] into a pose that is there already.
    pub fn sample_into(&self, seconds: f32, pose: &mut Pose) {
        let last = self.poses.len() - 1;
        // f64: a long-running clock keeps its fractions. A time that is not a number counts as the start.
        let frame = (f64::from(seconds) * f64::from(self.frames_per_second)).max(0.0).min(last as f64);
        self.between(frame.floor() as usize, last, frame.fract() as f32, pose);
    }

    /// The pose at `seconds` of the motion repeated without end, also backwards from zero.
    pub fn sample_looped(&self, seconds: f32) -> Pose {
        let count = self.poses.len();
        let frame = (f64::from(seconds) * f64::from(self.frames_per_second)).rem_euclid(count as f64);
        // rem_euclid may round up to the divisor; infinity has no remainder.
        let frame = if frame < count as f64 { frame } else { 0.0 };
        let mut pose = Pose::rest(0);
        self.between(frame.floor() as usize, 0, frame.fract() as f32, &mut pose);
        pose
    }

    /// Between a frame and the next one, which after the last frame is `after_last`.
    fn between(&self, frame: usize, after_last: usize, fraction: f32, pose: &mut Pose) {
        let next = self.poses.get(frame + 1).unwrap_or(&self.poses[after_last]);
        pose.clone_from(&self.poses[frame]);
        pose.blend(next, fraction);
    }
}

/// Between two poses of one skeleton: `fraction` 0 is `from`, 1 is `to`; each joint takes the shorter way round.
pub fn interpolate(from: &Pose, to: &Pose, fraction: f32) -> Pose {
    let mut pose = from.clone();
    pose.blend(to, fraction);
    pose
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::quat_from_axis_angle;
    use glam::{Quat, Vec3};

    fn turn(degrees: f32) -> Quat {
        quat_from_axis_angle(Vec3::Y * degrees.to_radians())
    }

    /// Turns and walks at ten poses a second.
    fn motion(degrees: &[f32]) -> Motion {
        let poses = degrees.iter().enumerate();
        let poses = poses.map(|(i, &d)| Pose { rotations: vec![turn(d)], translation: Vec3::X * i as f32 });
        Motion { poses: poses.collect(), frames_per_second: 10.0, notes: Vec::new() }
    }

    fn assert_at(pose: &Pose, degrees: f32, x: f32) {
        let off = pose.rotations[0].angle_between(turn(degrees)).to_degrees();
        assert!(off < 0.1, "{off} degrees off {degrees}");
        assert!((pose.translation - Vec3::X * x).length() < 1e-5, "{} off {x}", pose.translation);
    }

    #[test]
    fn samples_between_poses_and_clamps_outside() {
        let motion = motion(&[0.0, 40.0, 60.0]);
        assert!((motion.duration() - 0.2).abs() < 1e-7);
        assert_at(&motion.sample(0.05), 20.0, 0.5);
        assert_at(&motion.sample(0.15), 50.0, 1.5);
        for (seconds, degrees, x) in [
            (-1.0, 0.0, 0.0),
            (f32::NAN, 0.0, 0.0),
            (f32::NEG_INFINITY, 0.0, 0.0),
            (0.2, 60.0, 2.0),
            (9.0, 60.0, 2.0),
            (f32::INFINITY, 60.0, 2.0),
        ] {
            assert_at(&motion.sample(seconds), degrees, x);
        }
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        // As numbers, 170 and -170 degrees lie 340 apart; as rotations, 20.
        let motion = motion(&[170.0, -170.0]);
        assert_at(&motion.sample(0.05), 180.0, 0.5);
    }

    #[test]
    fn loops_through_the_first_pose() {
        let motion = motion(&[0.0, 40.0, 60.0]);
        assert!((motion.loop_duration() - 0.3).abs() < 1e-7);
        assert_at(&motion.sample_looped(0.05), 20.0, 0.5);
        assert_at(&motion.sample_looped(0.25), 30.0, 1.0);
        assert_at(&motion.sample_looped(0.35), 20.0, 0.5);
        assert_at(&motion.sample_looped(-0.05), 30.0, 1.0);
        assert_at(&motion.sample_looped(f32::NAN), 0.0, 0.0);
        assert_at(&motion.sample_looped(f32::INFINITY), 0.0, 0.0);
    }

    #[test]
    fn one_pose_is_everywhere() {
        let motion = motion(&[30.0]);
        assert_eq!(motion.duration(), 0.0);
        for seconds in [-1.0, 0.0, 0.07, 100.0] {
            assert_at(&motion.sample(seconds), 30.0, 0.0);
            assert_at(&motion.sample_looped(seconds), 30.0, 0.0);
        }
    }
}
