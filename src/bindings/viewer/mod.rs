//! An avatar, its motion, and how it is looked at. Whatever draws it is elsewhere.

mod figure;
mod looks;
mod motions;

use super::named;
use crate::animate::Part;
use crate::avatar::Avatar;
use crate::motion::Motion;
use crate::player::Player;
use crate::render::{DrawnSurface, Globals, Scene, Theme};
use bytemuck::Zeroable;
use js_sys::Error;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// An encoded picture out of an avatar file.
#[wasm_bindgen(getter_with_clone)]
pub struct EncodedImage {
    /// Media type.
    pub mime: String,
    /// The file's bytes.
    pub bytes: Vec<u8>,
}

/// An avatar that plays, without a device.
#[wasm_bindgen]
pub struct Viewer {
    name: String,
    player: Player,
    /// The avatar as it was read, where it wears another's wrinkles.
    own_avatar: Option<Arc<Avatar>>,
    /// Motions that were read and do not play yet.
    coming: Vec<Motion>,
    scene: Scene,
    theme: Theme,
    background: Option<[f32; 4]>,
    shadow: f32,
    /// Kept so that its address lasts.
    globals: Box<Globals>,
    last_milliseconds: Option<f64>,
    redraw: bool,
    pose_milliseconds: Option<f64>,
    detail_milliseconds: Option<f64>,
    /// Milliseconds of each part of the last pose, in the order of [`Part`]; then normals and packing.
    part_milliseconds: [f64; PARTS],
}

/// The parts that [`Part`] names, and one for normals and packing.
const PARTS: usize = Part::Solve as usize + 2;

impl Viewer {
    /// What there is to see.
    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The same, for a painter that poses.
    pub(super) fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// What plays.
    pub(super) fn player(&self) -> &Player {
        &self.player
    }

    /// The same, to change.
    pub(super) fn player_mut(&mut self) -> &mut Player {
        &mut self.player
    }

    /// The avatar as it was read, whatever wrinkles it wears.
    pub(super) fn own_avatar(&self) -> Arc<Avatar> {
        self.own_avatar.clone().unwrap_or_else(|| self.player.shared_avatar())
    }

    /// Shows `avatar`, the own one with other wrinkles or without, in the state that the present one is in.
    pub(super) fn wear(&mut self, avatar: Arc<Avatar>, own: Option<Arc<Avatar>>) -> Result<(), Error> {
        self.player.replace_avatar(avatar).map_err(|error| named("avatar", &error))?;
        self.own_avatar = own;
        self.redraw = true;
        Ok(())
    }

    fn apply_theme(&mut self) {
        let theme = self.background.map_or(self.theme, |background| self.theme.with_background(background));
        self.scene.theme = Theme { shadow_strength: self.shadow * theme.shadow_strength, ..theme };
        self.redraw = true;
    }

    /// The surface as it is drawn, made anew.
    pub(super) fn drawn_surface(&self) -> Result<DrawnSurface, Error> {
        DrawnSurface::new(&self.player.avatar().appearance, self.player.triangles(), &self.name)
            .map_err(|error| named("avatar", &error))
    }
}

#[wasm_bindgen]
impl Viewer {
    /// Reads the avatar in `bytes` (`name` is for messages) and makes it ready to play as far as its base.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: Vec<u8>, name: String) -> Result<Viewer, Error> {
        let avatar = Avatar::read(&bytes, &name).map_err(|error| named("avatar", &error))?;
        // Memory of wasm never shrinks: what follows takes the file's place.
        drop(bytes);
        let player = Player::with_base(Arc::new(avatar)).map_err(|error| named("avatar", &error))?;
        Ok(Self {
            name,
            player,
            own_avatar: None,
            coming: Vec::new(),
            scene: Scene::default(),
            theme: Theme::LIGHT,
            background: None,
            shadow: 1.0,
            globals: Box::new(Globals::zeroed()),
            last_milliseconds: None,
            redraw: true,
            pose_milliseconds: None,
            detail_milliseconds: None,
            part_milliseconds: [0.0; PARTS],
        })
    }

    /// Sets up the solver, unless that is done: from now on there is detail. The time that it takes is no part of the motion.
    #[wasm_bindgen(js_name = prepareDetail)]
    pub fn prepare_detail(&mut self) -> Result<(), Error> {
        if self.detail_milliseconds.is_none() {
            let started = milliseconds();
            self.player.prepare_detail().map_err(|error| named("avatar", &error))?;
            self.detail_milliseconds = Some(milliseconds() - started);
            self.last_milliseconds = None;
            self.redraw = true;
        }
        Ok(())
    }

    /// Lets time pass until `now` (milliseconds of a clock that never goes back). Returns whether there is something new to draw; throws,
    /// once for each pose, where the figure is not finite, and keeps the last one that was. A painter that poses by itself says so.
    pub fn advance(&mut self, now: f64, painter_poses: bool) -> Result<bool, Error> {
        let passed = self.last_milliseconds.map_or(0.0, |last| 1e-3 * (now - last).max(0.0));
        self.last_milliseconds = Some(now);
        let started = milliseconds();
        let mut last = started;
        let mut parts = [0.0; PARTS];
        let mut observe = |part: Part| {
            let now = milliseconds();
            parts[part as usize] = now - last;
            last = now;
        };
        self.pose_milliseconds = None;
        if painter_poses {
            self.redraw |= self.player.step(passed).is_some();
        } else if let Some(posed) =
            self.player.advance(passed, &mut observe).map_err(|error| named("avatar", &error))?
        {
            if posed.laplacian.is_empty() {
                self.scene.set_figure(posed.positions, posed.normals, posed.coarser);
            } else {
                self.scene.set_figure_of_values(posed.positions, posed.laplacian, posed.coarser);
            }
            crease_posing::threads::rest();
            let ended = milliseconds();
            parts[PARTS - 1] = ended - last;
            self.part_milliseconds = parts;
            self.pose_milliseconds = Some(ended - started);
            self.player.count_posing(1e-3 * (ended - started));
            self.redraw = true;
        }
        let camera = &mut self.scene.camera;
        camera.follow(self.player.root());
        self.redraw |= !camera.settled();
        camera.advance(passed as f32);
        Ok(self.redraw && (painter_poses || self.scene.revision() > 0))
    }

    /// The picture of this moment is on the screen: so long after the one before it, if that one was shown just before, and after so much
    /// work, milliseconds.
    pub fn drawn(&mut self, interval: Option<f64>, work: f64) {
        self.redraw = false;
        if let Some(interval) = interval {
            self.player.count_frame(1e-3 * interval, 1e-3 * work);
        }
    }

    /// Another painter takes over: the figure is posed again, by whoever poses then.
    #[wasm_bindgen(js_name = poseAgain)]
    pub fn pose_again(&mut self) {
        self.player.pose_again();
        self.redraw = true;
    }

    /// The picture must be drawn again, even where nothing moved.
    pub fn redraw(&mut self) {
        self.redraw = true;
    }

    /// Forgets the time of the last frame: a pause of the page is no part of the motion.
    #[wasm_bindgen(js_name = skipTime)]
    pub fn skip_time(&mut self) {
        self.last_milliseconds = None;
    }

    /// Whether the next frame will differ from the last.
    #[wasm_bindgen(getter)]
    pub fn moving(&self) -> bool {
        self.redraw || self.player.moving() || !self.scene.camera.settled()
    }
}

#[wasm_bindgen]
extern "C" {
    /// A clock of this thread that never goes back.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn milliseconds() -> f64;
}
