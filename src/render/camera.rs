//! A camera that orbits the figure, follows it over the floor, and never jumps.

use glam::{Mat4, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Seconds in which the camera covers 63 % of the way to where a person wants it.
const EASE_SECONDS: f32 = 0.08;
/// The same for following the figure: slow, so that steps do not shake the picture.
const FOLLOW_SECONDS: f32 = 0.5;
/// A root that moves further than this within one frame was cut, not walked: the camera cuts with it.
const CUT_METRES: f32 = 0.5;
/// Nearer to its goal than this, radians and metres together, the camera has arrived; and this near to the point that it follows.
const ARRIVED_ORBIT: f32 = 1e-4;
const ARRIVED_METRES: f32 = 1e-3;
/// Lowest elevation: the eye stays above the floor.
const LOWEST_ELEVATION: f32 = -0.12;
const HIGHEST_ELEVATION: f32 = FRAC_PI_2 - 0.05;
const NEAREST: f32 = 0.4;
const FARTHEST: f32 = 12.0;
const NEAR_PLANE: f32 = 0.05;

/// Where an orbiting camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Radians about y; 0 looks at the figure's front (from +z), positive moves the eye to +x.
    pub azimuth: f32,
    /// Radians above the horizon.
    pub elevation: f32,
    /// Metres from the target, for a square view.
    pub distance: f32,
    /// What it looks at, metres, relative to the followed point.
    pub target: Vec3,
}

impl Default for Orbit {
    /// A dancing person, raised arms to feet, slightly from the side and from above.
    fn default() -> Self {
        Self { azimuth: 0.35, elevation: 0.12, distance: 4.9, target: Vec3::new(0.0, 0.95, 0.0) }
    }
}

impl Orbit {
    fn towards(&self, goal: &Self, share: f32) -> Self {
        let mix = |from: f32, to: f32| from + share * (to - from);
        Self {
            azimuth: mix(self.azimuth, goal.azimuth),
            elevation: mix(self.elevation, goal.elevation),
            distance: mix(self.distance, goal.distance),
            target: self.target.lerp(goal.target, share),
        }
    }

    fn difference(&self, other: &Self) -> f32 {
        (self.azimuth - other.azimuth).abs()
            + (self.elevation - other.elevation).abs()
            + (self.distance - other.distance).abs()
            + self.target.distance(other.target)
    }
}

/// What the camera does where the figure goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Follow {
    /// It comes along softly.
    #[default]
    Soft,
    /// It keeps the root in the middle.
    Root,
    /// It stays.
    Stay,
}

/// Vertical field of view of the first view, radians.
const USUAL_FIELD_OF_VIEW: f32 = 0.5;

/// An [`Orbit`] on its way to another one, about a point that follows the figure.
#[derive(Clone, Debug)]
pub struct OrbitCamera {
    home: Orbit,
    goal: Orbit,
    now: Orbit,
    /// Point on the floor under the figure: wanted, and as followed.
    root: Option<Vec3>,
    followed: Vec3,
    follow: Follow,
    /// Vertical field of view of a square view, radians.
    field_of_view: f32,
    /// Radians a second by which it turns by itself, seconds for which it rests after it was moved, and those that are left of them.
    turn: f32,
    turn_rest: f32,
    resting: f32,
}

impl Default for OrbitCamera {
    fn default() -> Self {
        let home = Orbit::default();
        Self {
            home,
            goal: home,
            now: home,
            root: None,
            followed: Vec3::ZERO,
            follow: Follow::default(),
            field_of_view: USUAL_FIELD_OF_VIEW,
            turn: 0.0,
            turn_rest: 0.0,
            resting: 0.0,
        }
    }
}

impl OrbitCamera {
    /// Turns the eye about the target: `azimuth` to the right, `elevation` up, radians.
    pub fn orbit(&mut self, azimuth: f32, elevation: f32) {
        self.resting = self.turn_rest;
        self.goal.azimuth += azimuth;
        self.goal.elevation = (self.goal.elevation + elevation).clamp(LOWEST_ELEVATION, HIGHEST_ELEVATION);
    }

    /// Multiplies the distance by `factor`.
    pub fn zoom(&mut self, factor: f32) {
        self.resting = self.turn_rest;
        if factor > 0.0 {
            self.goal.distance = (self.goal.distance * factor).clamp(NEAREST, FARTHEST);
        }
    }

    /// Moves the target by shares of the view's height, right and up.
    pub fn pan(&mut self, right: f32, up: f32) {
        self.resting = self.turn_rest;
        let height = 2.0 * self.goal.distance * (0.5 * self.field_of_view).tan();
        let (sine, cosine) = self.goal.azimuth.sin_cos();
        let target = self.goal.target + height * (right * Vec3::new(cosine, 0.0, -sine) + up * Vec3::Y);
        self.goal.target = target.clamp(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 2.2, 2.0));
    }

    /// Goes back to the first view, the short way round.
    pub fn reset(&mut self) {
        let turns = ((self.goal.azimuth - self.home.azimuth) / TAU).round();
        self.goal = Orbit { azimuth: self.home.azimuth + turns * TAU, ..self.home };
    }

    /// Sets the first view, and goes there: azimuth and elevation in radians, distance in metres, or a `share` of the usual one. What is not
    /// given is as usual.
    pub fn set_orbit(&mut self, azimuth: Option<f32>, elevation: Option<f32>, distance: Option<f32>, share: f32) {
        let usual = Orbit::default();
        let azimuth = azimuth.unwrap_or(usual.azimuth);
        let elevation = elevation.unwrap_or(usual.elevation).clamp(LOWEST_ELEVATION, HIGHEST_ELEVATION);
        let distance = distance.unwrap_or(usual.distance * share).clamp(NEAREST, FARTHEST);
        self.home = Orbit { azimuth, elevation, distance, ..self.home };
        self.reset();
    }

    /// Sets what the first view looks at, metres, relative to the followed point; none is the usual point.
    pub fn set_target(&mut self, target: Option<Vec3>) {
        self.home.target = target.unwrap_or(Orbit::default().target);
        self.goal.target = self.home.target;
    }

    /// Sets the vertical field of view of a square view, radians; none is the usual one.
    pub fn set_field_of_view(&mut self, radians: Option<f32>) {
        self.field_of_view = radians.unwrap_or(USUAL_FIELD_OF_VIEW).clamp(0.05, 2.5);
    }

    /// Turns about the figure by itself, radians a second, except for `rest` seconds after it was moved.
    pub fn set_turn(&mut self, radians_per_second: f32, rest: f32) {
        self.turn = radians_per_second;
        self.turn_rest = rest.max(0.0);
        self.resting = 0.0;
    }

    /// Sets what it does where the figure goes.
    pub fn set_follow(&mut self, follow: Follow) {
        self.follow = follow;
    }

    /// Where it is now.
    pub fn orbit_now(&self) -> Orbit {
        self.now
    }

    /// The vertical field of view of a square view, radians.
    pub fn field_of_view(&self) -> f32 {
        self.field_of_view
    }

    /// Ends its movement at once; it does not move after a figure that it is not to follow.
    pub fn jump(&mut self) {
        self.now = self.goal;
        self.followed = self.followed_goal();
    }

    /// The point over the floor that it is on the way to.
    fn followed_goal(&self) -> Vec3 {
        match self.root {
            Some(root) if self.follow != Follow::Stay => root,
            _ => self.followed,
        }
    }

    /// Follows a figure whose root joint is at `root`: over the floor, not up and down.
    pub fn follow(&mut self, root: Vec3) {
        let root = Vec3::new(root.x, 0.0, root.z);
        match self.root {
            None => self.followed = root,
            Some(last) if last.distance(root) > CUT_METRES && self.follow == Follow::Soft => {
                self.followed += root - last;
            }
            Some(_) => {}
        }
        self.root = Some(root);
        if self.follow == Follow::Root {
            self.followed = root;
        }
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f32) {
        let seconds = seconds.max(0.0);
        let share = |time: f32| 1.0 - (-seconds / time).exp();
        let turn = self.turn * (seconds - self.resting).max(0.0);
        self.resting = (self.resting - seconds).max(0.0);
        self.goal.azimuth += turn;
        self.now.azimuth += turn;
        self.now = self.now.towards(&self.goal, share(EASE_SECONDS));
        self.followed = self.followed.lerp(self.followed_goal(), share(FOLLOW_SECONDS));
        // It arrives, so that the same wishes end in the same picture.
        if self.now.difference(&self.goal) < ARRIVED_ORBIT {
            self.now = self.goal;
        }
        if self.followed_goal().distance(self.followed) < ARRIVED_METRES {
            self.followed = self.followed_goal();
        }
    }

    /// Whether letting time pass would no longer move the picture.
    pub fn settled(&self) -> bool {
        self.turn == 0.0 && self.now == self.goal && self.followed == self.followed_goal()
    }

    /// What the camera looks at, metres.
    pub fn target(&self) -> Vec3 {
        self.followed + self.now.target
    }

    /// The eye, metres. A view narrower than a square steps back, so that the figure's width still fits.
    pub fn eye(&self, aspect: f32) -> Vec3 {
        let (sine, cosine) = self.now.azimuth.sin_cos();
        let (rise, run) = self.now.elevation.sin_cos();
        let distance = self.now.distance * (1.0 / aspect.max(0.1)).clamp(1.0, 1.4);
        self.target() + distance * Vec3::new(sine * run, rise, cosine * run)
    }

    /// Clip space (y up, depth 0 near to 1 far) from world, for a view of `aspect` = width / height.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let aspect = aspect.max(0.1);
        let view = glam::camera::rh::view::look_at_mat4(self.eye(aspect), self.target(), Vec3::Y);
        glam::camera::rh::proj::directx::perspective(self.field_of_view, aspect, NEAR_PLANE, 100.0) * view
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(camera: &mut OrbitCamera) {
        camera.advance(100.0);
    }

    #[test]
    fn the_target_is_in_the_middle_of_the_view() {
        let camera = OrbitCamera::default();
        for aspect in [0.5, 1.0, 2.0] {
            let middle = camera.clip_from_world(aspect).project_point3(camera.target());
            assert!(middle.truncate().length() < 1e-5, "{middle}");
            assert!((0.0..1.0).contains(&middle.z));
        }
    }

    #[test]
    fn a_standing_person_fits() {
        let camera = OrbitCamera::default();
        for aspect in [0.5, 1.0, 2.0] {
            for point in [Vec3::ZERO, Vec3::new(0.0, 1.8, 0.0)] {
                let seen = camera.clip_from_world(aspect).project_point3(point);
                assert!(seen.y.abs() < 0.95, "{point} is seen at {seen}");
            }
        }
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        let mut camera = OrbitCamera::default();
        let matrix = camera.clip_from_world(1.0);
        assert!(matrix.project_point3(camera.target() + 0.1 * Vec3::Y).y > 0.0);
        camera.orbit(-0.35, 0.0);
        settle(&mut camera);
        let from_the_front = camera.clip_from_world(1.0);
        assert!(from_the_front.project_point3(camera.target() + 0.1 * Vec3::X).x > 0.0);
    }

    #[test]
    fn the_eye_stays_above_the_floor_and_short_of_the_pole() {
        let mut camera = OrbitCamera::default();
        camera.orbit(0.0, -9.0);
        settle(&mut camera);
        assert!(camera.eye(1.0).y > 0.1);
        camera.orbit(0.0, 9.0);
        settle(&mut camera);
        assert!(camera.clip_from_world(1.0).is_finite());
    }

    #[test]
    fn it_moves_smoothly_and_settles() {
        let mut camera = OrbitCamera::default();
        assert!(camera.settled());
        let before = camera.eye(1.0);
        camera.orbit(1.0, 0.0);
        assert!(!camera.settled());
        assert_eq!(camera.eye(1.0), before);
        camera.advance(0.016);
        let step = camera.eye(1.0).distance(before);
        assert!(step > 0.0 && step < 1.0, "{step}");
        settle(&mut camera);
        assert!(camera.settled());
    }

    #[test]
    fn it_follows_slowly_over_the_floor_and_cuts_with_the_motion() {
        let mut camera = OrbitCamera::default();
        camera.follow(Vec3::new(0.0, 1.0, 0.0));
        let start = camera.target();
        camera.follow(Vec3::new(0.1, 1.5, 0.0));
        camera.advance(0.016);
        let moved = camera.target() - start;
        assert!(moved.x > 0.0 && moved.x < 0.01 && moved.y == 0.0, "{moved}");
        settle(&mut camera);
        let offset = camera.target() - Vec3::new(0.1, 0.0, 0.0);
        camera.follow(Vec3::new(-2.0, 1.0, 0.0));
        assert!((camera.target() - Vec3::new(-2.0, 0.0, 0.0) - offset).length() < 1e-5);
    }

    #[test]
    fn reset_goes_home_without_spinning_back() {
        let mut camera = OrbitCamera::default();
        let home = camera.eye(1.0);
        camera.orbit(TAU * 3.0 + 0.2, 0.3);
        camera.zoom(0.5);
        camera.pan(0.1, 0.1);
        settle(&mut camera);
        let azimuth = camera.now.azimuth;
        camera.reset();
        settle(&mut camera);
        assert!((camera.now.azimuth - azimuth).abs() < 1.0);
        assert!(camera.eye(1.0).distance(home) < 1e-3);
    }

    #[test]
    fn a_first_view_by_numbers_is_gone_to_and_come_back_to() {
        let mut camera = OrbitCamera::default();
        camera.set_orbit(Some(1.0), None, Some(3.0), 1.0);
        camera.set_target(Some(Vec3::Y));
        camera.jump();
        assert!((camera.eye(1.0).distance(Vec3::Y) - 3.0).abs() < 1e-4);
        assert_eq!(camera.orbit_now().azimuth, 1.0);
        camera.orbit(0.5, 0.1);
        camera.reset();
        settle(&mut camera);
        assert!((camera.orbit_now().azimuth - 1.0).abs() < 1e-4);
        camera.set_orbit(None, None, None, 0.5);
        camera.jump();
        assert!((camera.orbit_now().distance - 0.5 * Orbit::default().distance).abs() < 1e-5);
    }

    #[test]
    fn it_turns_by_itself_and_rests_after_it_was_moved() {
        let mut camera = OrbitCamera::default();
        let start = camera.orbit_now().azimuth;
        camera.set_turn(0.5, 2.0);
        assert!(!camera.settled());
        camera.advance(1.0);
        assert!((camera.orbit_now().azimuth - start - 0.5).abs() < 1e-4);
        camera.orbit(0.0, 0.1);
        camera.advance(1.5);
        assert!((camera.orbit_now().azimuth - start - 0.5).abs() < 1e-4, "it rests");
        camera.advance(1.0);
        assert!((camera.orbit_now().azimuth - start - 0.75).abs() < 1e-4);
    }

    #[test]
    fn it_follows_as_it_is_told() {
        let walked = Vec3::new(0.3, 1.0, 0.0);
        let target = |follow| {
            let mut camera = OrbitCamera::default();
            camera.set_follow(follow);
            camera.follow(Vec3::Y);
            camera.follow(walked);
            camera.target().x
        };
        assert_eq!([Follow::Soft, Follow::Root, Follow::Stay].map(target), [0.0, 0.3, 0.0]);
        let mut camera = OrbitCamera::default();
        camera.set_follow(Follow::Stay);
        camera.follow(Vec3::Y);
        camera.follow(walked);
        assert!(camera.settled(), "it has nowhere to go");
        settle(&mut camera);
        assert_eq!(camera.target().x, 0.0);
    }

    #[test]
    fn zoom_is_bounded() {
        let mut camera = OrbitCamera::default();
        camera.zoom(1e-6);
        camera.zoom(-1.0);
        settle(&mut camera);
        assert!(camera.eye(1.0).distance(camera.target()) >= NEAREST * 0.999);
    }
}
