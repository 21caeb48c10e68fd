//! Plays motions on an avatar: a clock, the motion it reads, and the animator it drives. No GPU, no browser.

mod clock;
mod pose_source;
mod prepared;
mod quality;
#[cfg(feature = "threads")]
mod sharing;
#[cfg(test)]
mod tests;

pub use clock::Clock;
pub use quality::{QUALITY_LEVELS, QualityController, QualityLevel};

use crate::animate::{Animator, BaseAnimator, Options, Part};
use crate::avatar::{Avatar, AvatarError};
use crate::body::Pose;
use crate::mesh::{Triangle, vertex_normals};
use crate::motion::{Motion, Timeline};
use glam::{Vec3, Vec3A};
use pose_source::PoseSource;
use prepared::Prepared;
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
