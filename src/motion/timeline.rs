//! Several motions one after the other, with one time for all: each fades into the next.

use super::Motion;
use crate::body::Pose;
use glam::Vec3;

/// Motions in a row. Where one follows another they overlap by the crossfade, and the later one is moved over the floor so that the
/// figure goes on from where it is.
#[derive(Clone, Debug)]
pub struct Timeline {
    clips: Vec<Clip>,
    duration: f64,
}

#[derive(Clone, Debug)]
struct Clip {
    motion: Motion,
    /// Seconds of the timeline at which it starts.
    start: f64,
    /// Seconds that it shares with the clip before.
    fade: f64,
    /// Added to its translations, metres, over the floor.
    offset: Vec3,
}

impl Clip {
    fn sample_into(&self, seconds: f64, pose: &mut Pose) {
        self.motion.sample_into((seconds - self.start) as f32, pose);
        pose.translation += self.offset;
    }

    fn sample(&self, seconds: f64) -> Pose {
        let mut pose = Pose::rest(0);
        self.sample_into(seconds, &mut pose);
        pose
    }
}

impl Timeline {
    /// Puts `motions` in a row; neighbours overlap by `crossfade` seconds, but by no more than half of either. None where there are none.
    pub fn new(motions: Vec<Motion>, crossfade: f64) -> Option<Self> {
        let crossfade = if crossfade > 0.0 { crossfade } else { 0.0 };
        let mut clips: Vec<Clip> = Vec::with_capacity(motions.len());
        let mut end = 0.0;
        for motion in motions {
            let duration = f64::from(motion.duration());
            let mut clip = Clip { motion, start: end, fade: 0.0, offset: Vec3::ZERO };
            if let Some(last) = clips.last() {
                clip.fade = crossfade.min(0.5 * f64::from(last.motion.duration())).min(0.5 * duration);
                clip.start -= clip.fade;
                if clip.fade > 0.0 {
                    let middle = clip.start + 0.5 * clip.fade;
                    let gap = last.sample(middle).translation - clip.sample(middle).translation;
                    clip.offset = Vec3::new(gap.x, 0.0, gap.z);
                }
            }
            end = clip.start + duration;
            clips.push(clip);
        }
        (!clips.is_empty()).then_some(Self { clips, duration: end })
    }

    /// Seconds from the first pose to the last.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Which motion plays at `seconds`; within a crossfade the later one.
    pub fn index(&self, seconds: f64) -> usize {
        self.clips.iter().rposition(|clip| clip.start <= seconds).unwrap_or(0)
    }

    /// Poses a second of the motion that plays at `seconds`.
    pub fn frames_per_second(&self, seconds: f64) -> f32 {
        self.clips[self.index(seconds)].motion.frames_per_second
    }

    /// The pose at `seconds`, clamped to the timeline.
    pub fn sample(&self, seconds: f64) -> Pose {
        let [mut pose, mut other] = [Pose::rest(0), Pose::rest(0)];
        self.sample_into(seconds, &mut pose, &mut other);
        pose
    }

    /// [`Self::sample`] into a pose that is there already; `other` is room for the pose that it fades into.
    pub fn sample_into(&self, seconds: f64, pose: &mut Pose, other: &mut Pose) {
        let index = self.index(seconds);
        let clip = &self.clips[index];
        let within = seconds - clip.start;
        if index > 0 && within < clip.fade {
            self.clips[index - 1].sample_into(seconds, pose);
            clip.sample_into(seconds, other);
            pose.blend(other, fade_in(within / clip.fade));
        } else {
            clip.sample_into(seconds, pose);
        }
    }

    /// The motions, in their order.
    pub fn into_motions(self) -> Vec<Motion> {
        self.clips.into_iter().map(|clip| clip.motion).collect()
    }
}

/// Weight of what comes, `share` of the way through a crossfade: it sets in and ends without a jerk.
pub fn fade_in(share: f64) -> f32 {
    let share = share.clamp(0.0, 1.0) as f32;
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::quat_from_axis_angle;

    /// Stands turned by `degrees` and walks along x from `x`, one metre a second, ten poses a second, for two seconds.
    fn motion(degrees: f32, x: f32) -> Motion {
        let poses = (0..=20).map(|i| Pose {
            rotations: vec![quat_from_axis_angle(Vec3::Y * degrees.to_radians())],
            translation: Vec3::new(x + 0.1 * i as f32, 0.9, 0.0),
        });
        Motion { poses: poses.collect(), frames_per_second: 10.0, notes: Vec::new() }
    }

    fn degrees(pose: &Pose) -> f32 {
        pose.rotations[0].to_scaled_axis().y.to_degrees()
    }

    #[test]
    fn without_crossfade_motions_follow_each_other_as_they_are() {
        let timeline = Timeline::new(vec![motion(0.0, 0.0), motion(90.0, 7.0)], 0.0).unwrap();
        assert!((timeline.duration() - 4.0).abs() < 1e-6);
        assert_eq!((timeline.index(1.9), timeline.index(2.1), timeline.index(-1.0)), (0, 1, 0));
        assert!((degrees(&timeline.sample(1.99)) - 0.0).abs() < 0.1);
        let second = timeline.sample(3.0);
        assert!((degrees(&second) - 90.0).abs() < 0.1 && (second.translation.x - 8.0).abs() < 1e-4, "{second:?}");
    }

    #[test]
    fn a_crossfade_turns_the_short_way_and_goes_on_from_the_place() {
        let timeline = Timeline::new(vec![motion(170.0, 0.0), motion(-170.0, 7.0)], 1.0).unwrap();
        assert!((timeline.duration() - 3.0).abs() < 1e-6);
        // Half-way both weigh the same; as rotations they lie twenty degrees apart.
        assert!((degrees(&timeline.sample(1.5)).abs() - 180.0).abs() < 0.1);
        let mut last = timeline.sample(0.0).translation.x;
        for i in 1..=30 {
            let x = timeline.sample(0.1 * f64::from(i)).translation.x;
            assert!((x - last - 0.1).abs() < 1e-3, "it walks on at its own pace: {last} to {x}");
            last = x;
        }
    }

    #[test]
    fn a_crossfade_longer_than_the_motions_is_cut_to_half_of_the_shorter() {
        let short = Motion { poses: motion(0.0, 0.0).poses[..11].to_vec(), ..motion(0.0, 0.0) };
        let timeline = Timeline::new(vec![motion(0.0, 0.0), short, motion(0.0, 0.0)], 60.0).unwrap();
        assert!((timeline.duration() - (2.0 + 1.0 + 2.0 - 2.0 * 0.5)).abs() < 1e-6);
    }

    #[test]
    fn of_one_motion_the_timeline_is_that_motion() {
        let one = motion(30.0, 1.0);
        let timeline = Timeline::new(vec![one.clone()], 0.3).unwrap();
        for seconds in [-1.0, 0.0, 0.77, 2.0, 9.0, f64::NAN] {
            assert_eq!(timeline.sample(seconds), one.sample(seconds as f32));
        }
        assert!(Timeline::new(Vec::new(), 0.3).is_none());
    }
}
