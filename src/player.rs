//! Plays motions on an avatar: a clock, the motion it reads, and the animator it drives. No GPU, no browser.

mod clock;
mod pose_source;
mod quality;
#[cfg(feature = "threads")]
mod sharing;

pub use clock::Clock;
pub use quality::{QUALITY_LEVELS, QualityController, QualityLevel};

use crate::animate::{Animator, BaseAnimator, Options, Part};
use crate::avatar::{Avatar, AvatarError};
use crate::body::Pose;
use crate::mesh::{Subdivision, Triangle, vertex_normals};
use crate::motion::{Motion, Timeline};
use glam::{Vec3, Vec3A};
use pose_source::PoseSource;
use std::ops::RangeInclusive;
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

/// A pose in which the avatar's surface leaves the range of numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{avatar}: the networks' weights: expected finite positions in every pose, found {count} vertices without at \
     {seconds:.2} s of the motion; train the avatar again"
)]
pub struct NotFiniteError {
    /// Name of the avatar.
    pub avatar: String,
    /// Vertices that are nowhere.
    pub count: usize,
    /// When, in seconds since the motion's start.
    pub seconds: f64,
}

/// What a frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// The pose.
    pub pose: Pose,
    /// What is computed of it.
    pub options: Options,
    /// How many levels coarser than the finest the triangles are that are drawn. They may be coarser than the mesh that is computed:
    /// their corners then carry that mesh's positions and normals.
    pub coarser: usize,
}

/// The mesh of one pose, as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posed<'a> {
    /// Positions, metres.
    pub positions: &'a [Vec3A],
    /// Unit normals, one for each position.
    pub normals: &'a [Vec3A],
    /// f_l along the normal, 1/m, one for each position, where [`Player::tells_laplacian`]; empty elsewhere.
    pub laplacian: &'a [f32],
    /// How many levels coarser than the finest the mesh is.
    pub coarser: usize,
}

/// How far the avatar is ready. The base is there at once, so that a page need not wait for the solver to show something.
#[expect(clippy::large_enum_variant, reason = "a player has one of them")]
enum Prepared {
    Base(BaseAnimator),
    Detailed(Animator),
}

impl Prepared {
    fn animate(&mut self, pose: &Pose, options: &Options, observe: &mut dyn FnMut(Part)) -> &[Vec3A] {
        match self {
            Self::Base(base) => base.animate_observed(pose, options, observe),
            Self::Detailed(animator) => animator.animate_observed(pose, options, observe),
        }
    }

    fn subdivision(&self) -> &Subdivision {
        match self {
            Self::Base(base) => base.subdivision(),
            Self::Detailed(animator) => animator.subdivision(),
        }
    }

    fn levels(&self) -> RangeInclusive<usize> {
        match self {
            Self::Base(base) => base.levels(),
            Self::Detailed(animator) => animator.levels(),
        }
    }
}

/// An avatar, the motion that it plays, and when.
pub struct Player {
    avatar: Arc<Avatar>,
    prepared: Prepared,
    source: PoseSource,
    /// Play, pause, seek, loop and rate.
    pub clock: Clock,
    /// View (body, base or detailed) and amount of detail; quality decides the rest.
    pub options: Options,
    /// Whether frames come with f_l.
    pub tells_laplacian: bool,
    controller: QualityController,
    fixed_quality: Option<usize>,
    wanted: Option<Wanted>,
    /// Room for the next pose, and for what it fades into.
    next: [Pose; 2],
    /// The solver must not start from what the last call left.
    cold: bool,
    /// Frames depend on the pose alone, until time runs again.
    exact: bool,
    positions: Vec<Vec3A>,
    normals: Vec<Vec3A>,
    laplacian: Vec<f32>,
    #[cfg(feature = "threads")]
    sharing: sharing::Sharing,
}

impl Player {
    /// Prepares `avatar`. It stands in its rest pose, feet on the floor, until there is a motion.
    pub fn new(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        let mut player = Self::with_base(avatar)?;
        player.prepare_detail()?;
        Ok(player)
    }

    /// Prepares `avatar` as far as its base, which is shown where the detailed stage is asked for, until [`Self::prepare_detail`].
    pub fn with_base(avatar: Arc<Avatar>) -> Result<Self, AvatarError> {
        let base = BaseAnimator::new(avatar.clone())?;
        let standing = standing_pose(&avatar);
        Ok(Self {
            avatar,
            prepared: Prepared::Base(base),
            source: PoseSource::new(standing.clone()),
            clock: Clock::default(),
            options: Options::default(),
            tells_laplacian: false,
            controller: QualityController::default(),
            fixed_quality: None,
            wanted: None,
            next: [standing.clone(), standing],
            cold: false,
            exact: false,
            positions: Vec::new(),
            normals: Vec::new(),
            laplacian: Vec::new(),
            #[cfg(feature = "threads")]
            sharing: sharing::Sharing::default(),
        })
    }

    /// Sets up the solver, unless that is done; the next frame is posed anew.
    pub fn prepare_detail(&mut self) -> Result<(), AvatarError> {
        if let Prepared::Base(base) = &self.prepared {
            self.prepared = Prepared::Detailed(Animator::over(base.anew())?);
            self.pose_again();
        }
        Ok(())
    }

    /// Whether the detailed stage can be shown.
    pub fn is_detailed(&self) -> bool {
        matches!(self.prepared, Prepared::Detailed(_))
    }

    /// Replaces the motions, played one after the other, and starts them from the beginning; none goes back to the rest pose. While time
    /// runs, what was shown fades into what comes.
    pub fn set_motions(&mut self, motions: Vec<Motion>) -> Result<(), JointCountError> {
        for motion in &motions {
            check_joints(motion, self.avatar.rig.parents.len())?;
        }
        let before = self.clock.running().then(|| self.pose());
        let timeline = Timeline::new(motions, self.source.crossfade());
        self.clock.set_duration(timeline.as_ref().map_or(0.0, Timeline::duration));
        self.source.set_timeline(timeline);
        if let Some(before) = before {
            self.source.fade_from(&before);
        }
        Ok(())
    }

    /// Seconds over which a motion fades into the next one; 0 cuts. The moment that is shown stays as nearly as it can.
    pub fn set_crossfade(&mut self, seconds: f64) {
        self.source.set_crossfade(seconds);
        if let Some(timeline) = self.source.take_timeline() {
            let moment = self.clock.seconds();
            let timeline = Timeline::new(timeline.into_motions(), self.source.crossfade());
            self.clock.set_duration(timeline.as_ref().map_or(0.0, Timeline::duration));
            self.clock.seek(moment);
            self.source.set_timeline(timeline);
        }
    }

    /// The motions.
    pub fn timeline(&self) -> Option<&Timeline> {
        self.source.timeline()
    }

    /// Goes to `seconds` at once: no fade.
    pub fn seek(&mut self, seconds: f64) {
        self.clock.seek(seconds);
        self.source.cut();
        self.exact = false;
    }

    /// Stops at `seconds` and shows them as they always look: no fade, and frames that depend on the pose alone until time runs again.
    pub fn show_exactly(&mut self, seconds: f64) {
        self.clock.pause();
        self.seek(seconds);
        self.exact = true;
    }

    /// Shows a pose in place of the motions, or the motions again: `rotations` are axis-angle, radians, three numbers for each joint;
    /// `translation` in metres, where the rest pose stands if there is none.
    pub fn set_live_pose(
        &mut self,
        rotations: Option<&[f32]>,
        translation: Option<Vec3>,
    ) -> Result<(), JointCountError> {
        let expected = self.avatar.rig.parents.len();
        let now = self.pose();
        let wanted = match rotations {
            Some(numbers) if numbers.len() != 3 * expected => {
                return Err(JointCountError { pose: 0, expected, found: numbers.len() / 3 });
            }
            Some(numbers) => {
                Some(Pose::from_axis_angle(numbers, translation.unwrap_or(self.source.standing().translation)))
            }
            None => None,
        };
        self.source.set_live(wanted, now);
        Ok(())
    }

    /// Seconds in which a live pose covers 63 % of the way to the one asked for; 0 jumps.
    pub fn set_smoothing(&mut self, seconds: f64) {
        self.source.set_smoothing(seconds);
    }

    /// Whether time will bring another pose.
    pub fn moving(&self) -> bool {
        self.source.is_settling() || (self.clock.running() && !self.source.is_live())
    }

    /// The pose at the clock's time.
    pub fn pose(&self) -> Pose {
        self.source.pose(self.clock.seconds())
    }

    /// Where the root joint is now, metres.
    pub fn root(&self) -> Vec3 {
        match &self.wanted {
            Some(wanted) => self.avatar.rig.root(&wanted.pose),
            None => self.root_at_clock(),
        }
    }

    /// Where the root joint is at the clock's time, whatever was shown last, metres.
    pub fn root_at_clock(&self) -> Vec3 {
        self.avatar.rig.root(&self.pose())
    }

    /// Moves the clock by `seconds` of real time and returns what is to be shown if that changed, for whoever poses the avatar elsewhere.
    pub fn step(&mut self, seconds: f64) -> Option<&Wanted> {
        self.let_time_pass(seconds);
        let [next, other] = &mut self.next;
        self.source.pose_into(self.clock.seconds(), next, other);
        let (options, coarser) = self.frame_options();
        let wanted = self.wanted.get_or_insert_with(|| Wanted { pose: Pose::rest(0), options, coarser });
        if wanted.pose == self.next[0] && wanted.options == options && wanted.coarser == coarser {
            return None;
        }
        std::mem::swap(&mut wanted.pose, &mut self.next[0]);
        (wanted.options, wanted.coarser) = (options, coarser);
        self.wanted.as_ref()
    }

    fn let_time_pass(&mut self, seconds: f64) {
        let running = self.clock.running() && !self.source.is_live();
        self.exact &= !running;
        self.source.advance(seconds, running);
        if running && self.clock.advance(seconds) {
            let end = if self.clock.rate() < 0.0 { 0.0 } else { self.clock.duration() };
            let [last, other] = &mut self.next;
            self.source.pose_into(end, last, other);
            self.source.fade_from(last);
        }
    }

    /// What was to be shown last.
    pub fn wanted(&self) -> Option<&Wanted> {
        self.wanted.as_ref()
    }

    /// Forgets what was shown: the next frame is posed anew, by whoever poses then.
    pub fn pose_again(&mut self) {
        self.wanted = None;
    }

    /// Moves the clock by `seconds` of real time and poses the avatar if pose or options changed: then its new mesh is returned.
    /// Where that is not finite the error is returned, once for each pose, and nothing may be shown of it. `observe` hears of each part of the
    /// frame when it is done.
    pub fn advance(
        &mut self,
        seconds: f64,
        observe: &mut dyn FnMut(Part),
    ) -> Result<Option<Posed<'_>>, NotFiniteError> {
        if self.step(seconds).is_none() {
            return Ok(None);
        }
        #[cfg(feature = "threads")]
        crate::threads::set_shares(self.sharing.now());
        let Some(Wanted { pose, options, coarser }) = &self.wanted else { return Ok(None) };
        let options = Options { warm_start: options.warm_start && !self.cold, ..*options };
        let positions = self.prepared.animate(pose, &options, observe);
        let count = positions.iter().filter(|position| !position.is_finite()).count();
        self.cold = count > 0;
        if count > 0 {
            return Err(self.not_finite(count));
        }
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.normals.resize(self.positions.len(), Vec3A::ZERO);
        let subdivision = self.prepared.subdivision();
        vertex_normals(&self.positions, subdivision.triangles(options.level), &mut self.normals);
        // A coarser level's vertices come first on every finer one.
        let drawn = subdivision.vertex_count(subdivision.level_count() - coarser);
        self.laplacian.clear();
        if self.tells_laplacian
            && let Prepared::Detailed(animator) = &mut self.prepared
        {
            let deltas = animator.learned_laplacian(pose, options.liveliness, options.level);
            self.laplacian.extend(deltas.iter().zip(&self.normals).map(|(delta, normal)| delta.dot(*normal)));
        }
        Ok(Some(Posed {
            positions: &self.positions[..drawn],
            normals: &self.normals[..drawn],
            laplacian: &self.laplacian[..drawn.min(self.laplacian.len())],
            coarser: *coarser,
        }))
    }

    /// The mesh that [`Self::advance`] returned last took so many seconds to make, and what was made of it: whether the next is worth sharing out
    /// between threads is learnt from it.
    pub fn count_posing(&mut self, seconds: f64) {
        #[cfg(feature = "threads")]
        self.sharing.count(seconds);
        #[cfg(not(feature = "threads"))]
        let _ = seconds;
    }

    /// The error of a frame of this moment with `count` vertices that are nowhere.
    pub fn not_finite(&self, count: usize) -> NotFiniteError {
        NotFiniteError { avatar: self.avatar.name.clone(), count, seconds: self.clock.seconds() }
    }

    /// What a frame of this moment and of the present quality shows. While time runs the solver starts from the last frames, as poses follow
    /// each other; a picture that stands depends on its pose alone.
    fn frame_options(&self) -> (Options, usize) {
        let quality = self.quality();
        let (coarsest, finest) = self.prepared.levels().into_inner();
        let level = |coarser| finest.saturating_sub(coarser).clamp(coarsest, finest);
        let options = Options {
            stop: quality.stop,
            warm_start: !self.exact && (self.clock.running() || self.source.is_live()),
            level: level(quality.coarser_surface),
            solve_level: level(quality.coarser_solve),
            ..self.options
        };
        let coarser = (finest - options.level + quality.coarser_triangles).min(finest);
        (options, coarser)
    }

    /// Keeps one of [`QUALITY_LEVELS`], or lets quality follow the machine.
    pub fn set_quality(&mut self, level: Option<usize>) {
        self.fixed_quality = level;
        self.controller = QualityController::default();
    }

    /// The level of quality of the next frame.
    pub fn quality(&self) -> &'static QualityLevel {
        let followed = if self.exact { 0 } else { self.controller.level() };
        &QUALITY_LEVELS[self.fixed_quality.unwrap_or(followed).min(QUALITY_LEVELS.len() - 1)]
    }

    /// Tells what a frame cost that followed on another: seconds between the two, and seconds of work.
    pub fn count_frame(&mut self, interval: f64, work: f64) {
        if self.fixed_quality.is_none() {
            self.controller.frame(interval, work);
        }
    }

    /// Goes on with another avatar of the same skeleton, in the same state, its detail included.
    pub fn replace_avatar(&mut self, avatar: Arc<Avatar>) -> Result<(), AvatarError> {
        self.prepared = Prepared::Detailed(Animator::new(avatar.clone())?);
        self.avatar = avatar;
        self.pose_again();
        Ok(())
    }

    /// The finest mesh of the moment that is shown: positions, metres. It depends on the pose alone. Without detail before
    /// [`Self::prepare_detail`].
    pub fn finest_mesh(&mut self) -> Vec<Vec3A> {
        let (pose, shown) = (self.pose(), self.options);
        let options = Options { level: usize::MAX, solve_level: usize::MAX, ..shown };
        let positions = self.prepared.animate(&pose, &options, &mut |_| ()).to_vec();
        self.cold = true;
        positions
    }

    /// Iterations of the solver in the last frame.
    pub fn iterations(&self) -> u32 {
        self.animator().map_or(0, Animator::iterations)
    }

    /// Vertices of the finest level.
    pub fn vertex_count(&self) -> usize {
        let subdivision = self.prepared.subdivision();
        subdivision.vertex_count(subdivision.level_count())
    }

    /// Triangles of the finest level.
    pub fn triangles(&self) -> &[Triangle] {
        let subdivision = self.prepared.subdivision();
        subdivision.triangles(subdivision.level_count())
    }

    /// What poses the avatar on the CPU; none before [`Self::prepare_detail`].
    pub fn animator(&self) -> Option<&Animator> {
        match &self.prepared {
            Prepared::Base(_) => None,
            Prepared::Detailed(animator) => Some(animator),
        }
    }

    /// The avatar, to keep.
    pub fn shared_avatar(&self) -> Arc<Avatar> {
        Arc::clone(&self.avatar)
    }

    /// The avatar.
    pub fn avatar(&self) -> &Avatar {
        &self.avatar
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
    #[cfg(feature = "factor")]
    use crate::animate::Stage;

    #[cfg(feature = "factor")]
    fn fixture() -> Player {
        Player::new(Arc::new(crate::fixture::compact_avatar())).unwrap()
    }

    #[cfg(feature = "factor")]
    fn advance(player: &mut Player, seconds: f64) -> Result<Option<Posed<'_>>, NotFiniteError> {
        player.advance(seconds, &mut |_| ())
    }

    /// A detail that no number can hold.
    #[cfg(feature = "factor")]
    const BEYOND: f32 = f32::INFINITY;

    #[test]
    #[cfg(feature = "factor")]
    fn only_what_changes_is_posed_again() {
        let mut player = fixture();
        assert!(advance(&mut player, 0.0).unwrap().is_some());
        assert!(advance(&mut player, 1.0).unwrap().is_none(), "it stands");
        player.options.detail = 0.5;
        assert!(advance(&mut player, 0.0).unwrap().is_some());
    }

    #[test]
    #[cfg(feature = "factor")]
    fn the_base_is_there_before_the_solver_and_the_detail_after_it() {
        let mut whole = fixture();
        let detailed = advance(&mut whole, 0.0).unwrap().unwrap().positions.to_vec();
        whole.options.stage = Stage::Base;
        let base = advance(&mut whole, 0.0).unwrap().unwrap().positions.to_vec();
        assert_ne!(detailed, base);

        let mut player = Player::with_base(Arc::new(crate::fixture::compact_avatar())).unwrap();
        assert!(!player.is_detailed());
        assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, base);
        player.prepare_detail().unwrap();
        assert!(player.is_detailed());
        assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, detailed);
        assert_eq!(advance(&mut player, 0.0), Ok(None));
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_factor_that_does_not_fit_is_an_error_of_the_detail() {
        let mut avatar = crate::fixture::compact_avatar();
        avatar.factor.values.pop();
        let mut player = Player::with_base(Arc::new(avatar)).unwrap();
        assert!(advance(&mut player, 0.0).unwrap().is_some());
        assert_eq!(player.prepare_detail().unwrap_err().field, "factor.values");
        assert!(!player.is_detailed());
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_surface_that_is_not_finite_is_an_error_once_and_leaves_no_trace() {
        let mut player = fixture();
        let before = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
        player.options.detail = BEYOND;
        let error = advance(&mut player, 0.0).unwrap_err();
        assert!(error.count > 0 && error.to_string().contains("finite"), "{error}");
        assert_eq!(advance(&mut player, 0.0), Ok(None), "said once");
        player.options.detail = 1.0;
        let after = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
        assert_eq!(after, before, "the solver starts afresh");
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_picture_that_stands_depends_on_its_pose_alone_and_one_that_moves_is_as_near() {
        let moving = Motion { poses: vec![Pose::rest(24), crate::fixture::bent_pose()], ..motion(&[]) };
        let playing = || {
            let mut player = fixture();
            player.set_quality(Some(0));
            player.set_motions(vec![moving.clone()]).unwrap();
            player.clock.play();
            player
        };
        let mut player = playing();
        for _ in 0..4 {
            advance(&mut player, 0.004).unwrap();
        }
        let moved = player.positions.clone();
        player.clock.pause();
        let stands = advance(&mut player, 0.0).unwrap().expect("posed anew").positions.to_vec();
        let mut other = playing();
        other.clock.pause();
        other.clock.seek(player.clock.seconds());
        assert_eq!(advance(&mut other, 0.0).unwrap().unwrap().positions, stands);
        let apart = moved.iter().zip(&stands).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart > 0.0 && apart < 4e-5, "the solver started elsewhere: {apart} m");
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_fixed_quality_gives_the_same_mesh_whatever_was_before() {
        let mut player = fixture();
        for level in 0..QUALITY_LEVELS.len() {
            player.set_quality(Some(level));
            player.options.detail = 1.0;
            let first = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
            player.options.detail = 2.0;
            advance(&mut player, 0.0).unwrap();
            player.options.detail = 1.0;
            assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, first, "{}", QUALITY_LEVELS[level].name);
        }
    }

    #[test]
    #[cfg(feature = "factor")]
    fn the_last_level_draws_the_coarsest_triangles_with_the_normals_of_a_finer_mesh() {
        let mut player = fixture();
        let [low, lowest] = [3, 4].map(|level| {
            player.set_quality(Some(level));
            let posed = advance(&mut player, 0.0).unwrap().unwrap();
            (posed.positions.len(), posed.normals.to_vec(), posed.coarser)
        });
        let subdivision = player.animator().unwrap().subdivision();
        assert_eq!((low.0, low.2), (subdivision.vertex_count(1), 1));
        assert_eq!((lowest.0, lowest.2), (subdivision.vertex_count(0), 2));
        let furthest = lowest.1.iter().zip(&low.1).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(furthest < 0.2, "one iteration less and no other mesh: {furthest}");
    }

    #[test]
    #[cfg(feature = "factor")]
    fn neighbouring_levels_of_quality_look_alike() {
        let mut player = fixture();
        let mut better: [Vec<Vec3A>; 2] = Default::default();
        for level in 0..QUALITY_LEVELS.len() {
            player.set_quality(Some(level));
            let posed = advance(&mut player, 0.0).unwrap().unwrap();
            let (positions, normals) = (posed.positions.to_vec(), posed.normals.to_vec());
            // Levels of the mesh begin with the vertices of the coarser one.
            let furthest = |a: &[Vec3A], b: &[Vec3A]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            let apart = [furthest(&positions, &better[0]), furthest(&normals, &better[1])];
            let name = QUALITY_LEVELS[level].name;
            assert!(apart[0] < 0.01 && apart[1] < 0.5, "{name}: {} m, normals {}", apart[0], apart[1]);
            better = [positions, normals];
        }
    }

    #[test]
    #[cfg(feature = "factor")]
    fn an_exact_frame_is_the_same_whatever_was_before() {
        let mut player = fixture();
        player.set_crossfade(0.3);
        player.set_motions(vec![turning()]).unwrap();
        player.show_exactly(0.5);
        let first = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
        player.clock.play();
        for _ in 0..4 {
            advance(&mut player, 0.13).unwrap();
        }
        player.show_exactly(0.5);
        assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, first);
        assert!(!player.clock.playing());
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_loop_fades_over_its_seam_only_while_it_plays() {
        let mut player = fixture();
        player.set_crossfade(0.4);
        player.set_motions(vec![turning()]).unwrap();
        player.clock.set_looping(true);
        player.seek(0.95);
        player.clock.play();
        player.step(0.05 + 1e-6);
        let seam = player.pose();
        let turn = |pose: &Pose| pose.rotations[0].to_scaled_axis().y;
        assert!((turn(&seam) - 1.0).abs() < 0.05, "still as at the end: {}", turn(&seam));
        player.seek(0.0);
        assert!(turn(&player.pose()).abs() < 1e-3, "a seek cuts");
    }

    #[test]
    #[cfg(feature = "factor")]
    fn another_crossfade_keeps_the_moment() {
        let mut player = fixture();
        player.set_motions(vec![turning(), turning()]).unwrap();
        assert!((player.clock.duration() - 2.0).abs() < 1e-6);
        player.seek(0.3);
        player.set_crossfade(0.4);
        assert!((player.clock.duration() - 1.6).abs() < 1e-6);
        assert_eq!(player.clock.seconds(), 0.3);
    }

    #[test]
    #[cfg(feature = "factor")]
    fn a_live_pose_takes_the_place_of_the_motion_and_must_fit_the_skeleton() {
        let mut player = fixture();
        player.set_motions(vec![turning()]).unwrap();
        player.clock.play();
        let joints = player.avatar().rig.parents.len();
        let mut numbers = vec![0.0; 3 * joints];
        numbers[1] = 0.5;
        player.set_live_pose(Some(&numbers), Some(Vec3::X)).unwrap();
        player.step(0.3);
        assert_eq!(player.pose().translation, Vec3::X);
        assert!(!player.moving(), "a live pose moves when it is set");
        assert_eq!(player.set_live_pose(Some(&[0.0; 6]), None).unwrap_err().found, 2);
        player.set_live_pose(None, None).unwrap();
        assert!(player.moving());
    }

    /// Turns by one radian in one second.
    #[cfg(feature = "factor")]
    fn turning() -> Motion {
        let joints = crate::fixture::compact_avatar().rig.parents.len();
        let poses = (0..=10).map(|i| {
            let mut pose = Pose::rest(joints);
            pose.rotations[0] = glam::Quat::from_rotation_y(0.1 * i as f32);
            pose
        });
        Motion { poses: poses.collect(), frames_per_second: 10.0, notes: Vec::new() }
    }

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
