//! Where the pose of a moment comes from: motions, a fade between them, a pose given live, or the rest pose.

use crate::body::Pose;
use crate::motion::{Timeline, fade_in};

/// A root that would cross more floor than this within a fade, metres, cuts to its new place: nobody glides.
const CUT_METRES: f32 = 0.5;
/// Joints nearer to their goal than this, radians, and roots nearer than as many metres, have arrived.
const ARRIVED: f32 = 1e-3;

/// A pose for every moment.
#[derive(Clone, Debug)]
pub(super) struct PoseSource {
    /// Shown where there is nothing else.
    standing: Pose,
    timeline: Option<Timeline>,
    crossfade: f64,
    /// What fades out, and for how many seconds it has; none where nothing fades.
    fading_from: Pose,
    fading_for: Option<f64>,
    live: Option<Live>,
    smoothing: f64,
}

/// A pose on its way to the one that was asked for.
#[derive(Clone, Debug)]
struct Live {
    wanted: Pose,
    shown: Pose,
}

impl PoseSource {
    pub fn new(standing: Pose) -> Self {
        Self {
            fading_from: standing.clone(),
            standing,
            timeline: None,
            crossfade: 0.0,
            fading_for: None,
            live: None,
            smoothing: 0.0,
        }
    }

    /// The pose at `seconds` of the motions, or the live one.
    pub fn pose(&self, seconds: f64) -> Pose {
        let [mut pose, mut other] = [Pose::rest(0), Pose::rest(0)];
        self.pose_into(seconds, &mut pose, &mut other);
        pose
    }

    /// [`Self::pose`] into one that is there already; `other` is room for what it fades into.
    pub fn pose_into(&self, seconds: f64, pose: &mut Pose, other: &mut Pose) {
        match (&self.live, &self.timeline) {
            (Some(live), _) => pose.clone_from(&live.shown),
            (None, None) => pose.clone_from(&self.standing),
            (None, Some(timeline)) => {
                timeline.sample_into(seconds, pose, other);
                if let Some(passed) = self.fading_for {
                    other.clone_from(pose);
                    pose.clone_from(&self.fading_from);
                    bring_near(pose, other);
                    pose.blend(other, if self.crossfade > 0.0 { fade_in(passed / self.crossfade) } else { 1.0 });
                }
            }
        }
    }

    /// The motions.
    pub fn timeline(&self) -> Option<&Timeline> {
        self.timeline.as_ref()
    }

    /// The motions, taken out.
    pub fn take_timeline(&mut self) -> Option<Timeline> {
        self.timeline.take()
    }

    /// Seconds of a fade.
    pub fn crossfade(&self) -> f64 {
        self.crossfade
    }

    /// Replaces the motions.
    pub fn set_timeline(&mut self, timeline: Option<Timeline>) {
        self.timeline = timeline;
        self.fading_for = None;
    }

    /// Seconds of a fade; 0 cuts.
    pub fn set_crossfade(&mut self, seconds: f64) {
        self.crossfade = if seconds.is_finite() { seconds.max(0.0) } else { 0.0 };
    }

    /// Lets `pose` fade out, while what the motions say fades in.
    pub fn fade_from(&mut self, pose: &Pose) {
        if self.crossfade > 0.0 && self.timeline.is_some() {
            self.fading_from.clone_from(pose);
            self.fading_for = Some(0.0);
        }
    }

    /// Cuts: a fade in progress is over.
    pub fn cut(&mut self) {
        self.fading_for = None;
    }

    /// A pose in place of the motions, or none any more. Without a translation the figure stands where the rest pose stands.
    pub fn set_live(&mut self, pose: Option<Pose>, now: Pose) {
        self.live = pose.map(|wanted| {
            let shown = if self.smoothing > 0.0 { now } else { wanted.clone() };
            Live { wanted, shown }
        });
    }

    /// Whether a live pose is shown.
    pub fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// Where the rest pose stands.
    pub fn standing(&self) -> &Pose {
        &self.standing
    }

    /// Seconds in which a live pose covers 63 % of the way to the one asked for; 0 jumps.
    pub fn set_smoothing(&mut self, seconds: f64) {
        self.smoothing = if seconds.is_finite() { seconds.max(0.0) } else { 0.0 };
    }

    /// Lets `seconds` of real time pass; fades go on only while the motions do.
    pub fn advance(&mut self, seconds: f64, running: bool) {
        if let Some(live) = &mut self.live {
            let share = if self.smoothing > 0.0 { 1.0 - (-seconds.max(0.0) / self.smoothing).exp() } else { 1.0 };
            live.shown.blend(&live.wanted, share as f32);
            if gap(&live.shown, &live.wanted) < ARRIVED {
                live.shown.clone_from(&live.wanted);
            }
        }
        if running {
            let passed = self.fading_for.map(|passed| passed + seconds.max(0.0));
            self.fading_for = passed.filter(|&passed| passed < self.crossfade);
        }
    }

    /// Whether the pose changes even while the motions stand still.
    pub fn is_settling(&self) -> bool {
        self.live.as_ref().is_some_and(|live| live.shown != live.wanted)
    }
}

/// Moves `pose` over the floor to where `to` is if that is far away.
fn bring_near(pose: &mut Pose, to: &Pose) {
    let mut way = to.translation - pose.translation;
    way.y = 0.0;
    if way.length() > CUT_METRES {
        pose.translation += way;
    }
}

/// The largest turn between two poses, radians, or the way between their roots, metres.
fn gap(a: &Pose, b: &Pose) -> f32 {
    let turns = a.rotations.iter().zip(&b.rotations).map(|(a, b)| a.angle_between(*b));
    turns.fold(a.translation.distance(b.translation), f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Motion;
    use crate::rotation::quat_from_axis_angle;
    use glam::Vec3;

    fn pose(degrees: f32, x: f32) -> Pose {
        Pose {
            rotations: vec![quat_from_axis_angle(Vec3::Y * degrees.to_radians())],
            translation: Vec3::new(x, 0.9, 0.0),
        }
    }

    fn standing_motion(degrees: f32, x: f32) -> Option<Timeline> {
        Timeline::new(
            vec![Motion { poses: vec![pose(degrees, x); 11], frames_per_second: 10.0, notes: Vec::new() }],
            0.0,
        )
    }

    fn degrees(pose: &Pose) -> f32 {
        pose.rotations[0].to_scaled_axis().y.to_degrees()
    }

    #[test]
    fn a_fade_goes_from_the_old_pose_to_the_new_motion_while_time_runs() {
        let mut source = PoseSource::new(pose(0.0, 0.0));
        source.set_timeline(standing_motion(60.0, 0.1));
        source.set_crossfade(0.4);
        source.fade_from(&pose(0.0, 0.0));
        assert!(degrees(&source.pose(0.0)).abs() < 0.1);
        source.advance(0.2, false);
        assert!(degrees(&source.pose(0.0)).abs() < 0.1, "time stands");
        source.advance(0.2, true);
        let half = source.pose(0.2);
        assert!((degrees(&half) - 30.0).abs() < 0.1 && (half.translation.x - 0.05).abs() < 1e-4, "{half:?}");
        source.advance(0.2, true);
        assert_eq!(source.pose(0.4), pose(60.0, 0.1));
    }

    #[test]
    fn a_fade_across_the_room_turns_but_does_not_glide() {
        let mut source = PoseSource::new(pose(0.0, 0.0));
        source.set_timeline(standing_motion(60.0, 3.0));
        source.set_crossfade(0.4);
        source.fade_from(&pose(0.0, 0.0));
        source.advance(0.2, true);
        let half = source.pose(0.2);
        assert!((degrees(&half) - 30.0).abs() < 0.1 && (half.translation.x - 3.0).abs() < 1e-4, "{half:?}");
        source.cut();
        assert!((degrees(&source.pose(0.2)) - 60.0).abs() < 0.1);
    }

    #[test]
    fn a_live_pose_takes_over_at_once_or_smoothly_and_arrives() {
        let mut source = PoseSource::new(pose(0.0, 0.0));
        source.set_live(Some(pose(90.0, 0.0)), source.pose(0.0));
        assert_eq!(source.pose(0.0), pose(90.0, 0.0));
        assert!(!source.is_settling());
        source.set_smoothing(0.1);
        source.set_live(Some(pose(0.0, 1.0)), source.pose(0.0));
        source.advance(0.1, false);
        let covered = degrees(&source.pose(0.0));
        assert!((covered - 90.0 * (-1.0_f32).exp()).abs() < 0.5, "{covered}");
        assert!(source.is_settling());
        source.advance(2.0, false);
        assert_eq!(source.pose(0.0), pose(0.0, 1.0));
        assert!(!source.is_settling());
        source.set_live(None, source.pose(0.0));
        assert_eq!(source.pose(0.0), pose(0.0, 0.0), "back to standing");
    }
}
