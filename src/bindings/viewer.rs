//! An avatar, its motion, and how it is looked at. Whatever draws it is elsewhere.

use super::drawing::DrawnMesh;
use super::named;
use crate::animate::{Part, Stage};
use crate::avatar::Avatar;
use crate::motion::Motion;
use crate::player::{Player, QUALITY_LEVELS};
use crate::render::{DrawnSurface, Environment, Globals, Scene, Theme, View};
use bytemuck::Zeroable;
use glam::Vec3;
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

    /// Milliseconds that setting up the detail took; nothing before that is done.
    #[wasm_bindgen(getter, js_name = detailMilliseconds)]
    pub fn detail_milliseconds(&self) -> Option<f64> {
        self.detail_milliseconds
    }

    /// The avatar's texture, to be decoded and given to `setTexture`.
    #[wasm_bindgen(getter, js_name = textureImage)]
    pub fn texture_image(&self) -> Option<EncodedImage> {
        let texture = self.player.avatar().appearance.texture.as_ref()?;
        Some(EncodedImage { mime: texture.mime.clone(), bytes: texture.bytes.clone() })
    }

    /// Forgets motions that were read and never played.
    #[wasm_bindgen(js_name = beginMotions)]
    pub fn begin_motions(&mut self) {
        self.coming.clear();
    }

    /// Reads one more motion, to be played after those read before; returns what the reader has to say about it.
    #[wasm_bindgen(js_name = readMotion)]
    pub fn read_motion(
        &mut self,
        bytes: &[u8],
        name: &str,
        frames_per_second: Option<f32>,
    ) -> Result<Vec<String>, Error> {
        let motion = Motion::read(bytes, name, frames_per_second).map_err(|error| named("motion", &error))?;
        let notes = motion.notes.clone();
        self.coming.push(motion);
        Ok(notes)
    }

    /// Plays the motions that were read, from the beginning; none goes back to the rest pose.
    #[wasm_bindgen(js_name = playMotions)]
    pub fn play_motions(&mut self) -> Result<(), Error> {
        let motions = std::mem::take(&mut self.coming);
        self.player.set_motions(motions).map_err(|error| named("motion", &error))
    }

    /// Whether it wears another avatar's wrinkles.
    #[wasm_bindgen(getter, js_name = wearsOtherDetail)]
    pub fn wears_other_detail(&self) -> bool {
        self.own_avatar.is_some()
    }

    /// Seconds over which a motion fades into the next one; 0 cuts.
    #[wasm_bindgen(js_name = setCrossfade)]
    pub fn set_crossfade(&mut self, seconds: f64) {
        self.player.set_crossfade(seconds);
        self.redraw = true;
    }

    /// Which of the motions plays.
    #[wasm_bindgen(getter, js_name = motionIndex)]
    pub fn motion_index(&self) -> usize {
        self.player.timeline().map_or(0, |timeline| timeline.index(self.player.clock.seconds()))
    }

    /// Poses a second of the motion that plays; 0 without one.
    #[wasm_bindgen(getter, js_name = framesPerSecond)]
    pub fn frames_per_second(&self) -> f32 {
        self.player.timeline().map_or(0.0, |timeline| timeline.frames_per_second(self.player.clock.seconds()))
    }

    /// Shows a pose in place of the motions: axis-angle, radians, three numbers for each joint, and the root's translation in metres.
    #[wasm_bindgen(js_name = setPose)]
    pub fn set_pose(&mut self, rotations: Option<Vec<f32>>, translation: Option<Vec<f32>>) -> Result<(), Error> {
        let translation = match translation.as_deref() {
            Some(&[x, y, z]) => Some(Vec3::new(x, y, z)),
            Some(other) => {
                return Err(named("pose", &format!("translation: expected 3 numbers, found {}", other.len())));
            }
            None => None,
        };
        let set = self.player.set_live_pose(rotations.as_deref(), translation);
        set.map_err(|error| {
            named("pose", &format!("pose: expected {} numbers, found {}", 3 * error.expected, 3 * error.found))
        })?;
        self.redraw = true;
        Ok(())
    }

    /// Seconds in which a pose covers 63 % of the way to the one that was set last; 0 jumps.
    #[wasm_bindgen(js_name = setSmoothing)]
    pub fn set_smoothing(&mut self, seconds: f64) {
        self.player.set_smoothing(seconds);
    }

    /// Stops at `seconds` and shows them as they always look, whatever was before.
    #[wasm_bindgen(js_name = showExactly)]
    pub fn show_exactly(&mut self, seconds: f64) {
        self.player.show_exactly(seconds);
        self.redraw = true;
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
            let ended = milliseconds();
            parts[PARTS - 1] = ended - last;
            self.part_milliseconds = parts;
            self.pose_milliseconds = Some(ended - started);
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

    /// `auto`, or the name of a level of quality to keep.
    #[wasm_bindgen(js_name = setQuality)]
    pub fn set_quality(&mut self, name: &str) -> Result<(), Error> {
        let level = QUALITY_LEVELS.iter().position(|level| level.name == name);
        if level.is_none() && name != "auto" {
            let names = QUALITY_LEVELS.map(|level| level.name).join(", ");
            return Err(Error::new(&format!("quality: expected auto, {names}, found {name}")));
        }
        self.player.set_quality(level);
        self.redraw = true;
        Ok(())
    }

    /// Name of the level of quality that is shown.
    #[wasm_bindgen(getter)]
    pub fn quality(&self) -> String {
        self.player.quality().name.into()
    }

    /// Pixels of the picture a side, as a share of the screen's.
    #[wasm_bindgen(getter, js_name = pixelShare)]
    pub fn pixel_share(&self) -> f32 {
        self.player.quality().pixel_share
    }

    /// How many levels coarser than the finest the figure is.
    #[wasm_bindgen(getter)]
    pub fn coarser(&self) -> usize {
        self.scene.coarser()
    }

    /// Milliseconds of one part of the last pose.
    #[wasm_bindgen(js_name = partMilliseconds)]
    pub fn part_milliseconds(&self, part: usize) -> f64 {
        self.part_milliseconds.get(part).copied().unwrap_or(0.0)
    }

    /// Iterations of the solver in the last pose.
    #[wasm_bindgen(getter)]
    pub fn iterations(&self) -> u32 {
        self.player.iterations()
    }

    /// Bytes of this module's memory.
    #[wasm_bindgen(getter, js_name = memoryBytes)]
    pub fn memory_bytes(&self) -> usize {
        core::arch::wasm32::memory_size::<0>() << 16
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

    /// The surface as it is drawn, for a painter outside of this module.
    #[wasm_bindgen(js_name = drawnMesh)]
    pub fn drawn_mesh(&self) -> Result<DrawnMesh, Error> {
        Ok(DrawnMesh::new(self.drawn_surface()?))
    }

    /// Address of the figure's vertices, as shaders read them.
    #[wasm_bindgen(getter, js_name = verticesAddress)]
    pub fn vertices_address(&self) -> usize {
        self.scene.vertices().as_ptr().addr()
    }

    /// How many vertices there are.
    #[wasm_bindgen(getter, js_name = vertexCount)]
    pub fn vertex_count(&self) -> usize {
        self.scene.vertices().len()
    }

    /// Another number for every figure; 0 before the first.
    #[wasm_bindgen(getter)]
    pub fn revision(&self) -> u32 {
        self.scene.revision()
    }

    /// Makes what all passes share for a picture of `aspect` = width / height, and returns its address.
    #[wasm_bindgen(js_name = globalsAddress)]
    pub fn globals_address(&mut self, aspect: f32) -> usize {
        *self.globals = self.scene.globals(aspect);
        std::ptr::from_ref(&*self.globals).addr()
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

    /// Starts time.
    pub fn play(&mut self) {
        self.player.clock.play();
    }

    /// Stops time; the picture that stands is made anew.
    pub fn pause(&mut self) {
        self.player.clock.pause();
        self.redraw = true;
    }

    /// Goes to a time of the motion, seconds.
    pub fn seek(&mut self, seconds: f64) {
        self.player.seek(seconds);
        self.redraw = true;
    }

    /// Media seconds per second.
    #[wasm_bindgen(js_name = setPlaybackRate)]
    pub fn set_playback_rate(&mut self, rate: f64) {
        self.player.clock.set_rate(rate);
    }

    /// Whether the motion starts over at its end.
    #[wasm_bindgen(getter)]
    pub fn looping(&self) -> bool {
        self.player.clock.looping()
    }

    /// Sets whether the motion starts over at its end.
    #[wasm_bindgen(js_name = setLoop)]
    pub fn set_loop(&mut self, looping: bool) {
        self.player.clock.set_looping(looping);
    }

    /// `detailed`, `base`, `body`, or something about the detailed surface: `wireframe`, `normals`, `laplacian`.
    #[wasm_bindgen(js_name = setView)]
    pub fn set_view(&mut self, view: &str) -> Result<(), Error> {
        let (stage, shown) = match view {
            "detailed" => (Stage::Detailed, View::Lit),
            "base" => (Stage::Base, View::Lit),
            "body" => (Stage::Body, View::Lit),
            "wireframe" => (Stage::Detailed, View::Wireframe),
            "normals" => (Stage::Detailed, View::Normals),
            "laplacian" => (Stage::Detailed, View::Values),
            other => return Err(Error::new(&format!("view: expected the name of a view, found {other}"))),
        };
        self.player.options.stage = stage;
        self.player.tells_laplacian = shown == View::Values;
        self.scene.view = shown;
        self.pose_again();
        Ok(())
    }

    /// How many levels coarser than the finest the mesh's edges are drawn; nothing where they are not drawn.
    #[wasm_bindgen(getter, js_name = coarserLines)]
    pub fn coarser_lines(&self) -> Option<usize> {
        (self.scene.view == View::Wireframe).then(|| self.scene.coarser_lines())
    }

    /// 0 is the base, 1 as trained, 2 exaggerated.
    #[wasm_bindgen(js_name = setDetail)]
    pub fn set_detail(&mut self, detail: f32) {
        self.player.options.detail = detail;
        self.redraw = true;
    }

    /// What poses far from training wear: 0 what is likeliest, 1 the folds of the nearest training poses.
    #[wasm_bindgen(js_name = setLiveliness)]
    pub fn set_liveliness(&mut self, liveliness: f32) {
        self.player.options.liveliness = liveliness;
        self.redraw = true;
    }

    /// `light` or `dark`.
    #[wasm_bindgen(js_name = setTheme)]
    pub fn set_theme(&mut self, theme: &str) {
        self.theme = if theme == "dark" { Theme::DARK } else { Theme::LIGHT };
        self.apply_theme();
    }

    /// A colour behind the figure (red, green, blue, opacity in sRGB, 0 ..= 1) in place of the theme's; none gives that back.
    #[wasm_bindgen(js_name = setBackground)]
    pub fn set_background(&mut self, colour: Option<Vec<f32>>) {
        self.background = colour.and_then(|colour| colour.try_into().ok());
        self.apply_theme();
    }

    /// Strength of the shadow on the floor, 0 ..= 1.
    #[wasm_bindgen(js_name = setShadow)]
    pub fn set_shadow(&mut self, strength: f32) {
        self.shadow = strength.clamp(0.0, 1.0);
        self.apply_theme();
    }

    /// One of the presets of light by name.
    #[wasm_bindgen(js_name = setEnvironment)]
    pub fn set_environment(&mut self, name: &str) -> Result<(), Error> {
        let Some((_, environment)) = Environment::PRESETS.iter().find(|(preset, _)| *preset == name) else {
            return Err(Error::new(&format!("environment: expected the name of a preset, found {name}")));
        };
        self.scene.environment = *environment;
        self.redraw = true;
        Ok(())
    }

    /// Seconds since the motion's start.
    #[wasm_bindgen(getter, js_name = currentTime)]
    pub fn current_time(&self) -> f64 {
        self.player.clock.seconds()
    }

    /// Length of the motion, seconds; 0 without one.
    #[wasm_bindgen(getter)]
    pub fn duration(&self) -> f64 {
        self.player.clock.duration()
    }

    /// Whether time runs.
    #[wasm_bindgen(getter)]
    pub fn playing(&self) -> bool {
        self.player.clock.playing()
    }

    /// Whether a motion that does not loop is over.
    #[wasm_bindgen(getter)]
    pub fn ended(&self) -> bool {
        self.player.clock.ended()
    }

    /// Vertices of the finest level.
    #[wasm_bindgen(getter)]
    pub fn vertices(&self) -> usize {
        self.player.vertex_count()
    }

    /// Milliseconds that the last drawn frame took to pose (networks, solve, normals, packing); nothing where only the camera moved.
    #[wasm_bindgen(getter, js_name = poseMilliseconds)]
    pub fn pose_milliseconds(&self) -> Option<f64> {
        self.pose_milliseconds
    }
}

#[wasm_bindgen]
extern "C" {
    /// A clock of this thread that never goes back.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn milliseconds() -> f64;
}
