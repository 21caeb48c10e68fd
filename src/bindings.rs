//! What JavaScript sees of the player: wasm-bindgen only, no logic.

use crate::animate::Stage;
use crate::avatar::Avatar;
use crate::gpu::{GpuAnimator, GpuError};
use crate::motion::Motion;
use crate::player::Player;
use crate::render::screen::{Screen, ScreenError};
use crate::render::{Albedo, DrawnSurface, OrbitCamera, Renderer, Theme};
use js_sys::{Error, Reflect};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// Reports panics on the console with their place; called by the module itself.
#[wasm_bindgen(start)]
fn start() {
    console_error_panic_hook::set_once();
}

/// An encoded picture out of an avatar file.
#[wasm_bindgen(getter_with_clone)]
pub struct EncodedImage {
    /// Media type.
    pub mime: String,
    /// The file's bytes.
    pub bytes: Vec<u8>,
}

/// An avatar on a canvas.
#[wasm_bindgen]
pub struct Viewer {
    player: Player,
    camera: OrbitCamera,
    theme: Theme,
    renderer: Renderer,
    screen: Screen,
    /// Poses the avatar where the GPU does it.
    gpu: Option<GpuAnimator>,
    last_milliseconds: Option<f64>,
    redraw: bool,
    pose_milliseconds: Option<f64>,
}

#[wasm_bindgen]
impl Viewer {
    /// Reads the avatar in `bytes` (`name` is for messages) and prepares to draw it on `canvas`, an OffscreenCanvas or a canvas element.
    /// `backend` is `webgpu` or `webgpu+cpu`; without it, whichever suits the adapter.
    pub async fn create(
        canvas: JsValue,
        bytes: Vec<u8>,
        name: String,
        backend: Option<String>,
    ) -> Result<Viewer, Error> {
        let avatar = Avatar::read(&bytes, &name).map_err(|error| named("avatar", &error))?;
        let player = Player::new(Arc::new(avatar)).map_err(|error| named("avatar", &error))?;
        let surface = DrawnSurface::new(&player.avatar().appearance, player.triangles(), &name)
            .map_err(|error| named("avatar", &error))?;
        let screen = Screen::new(canvas, GpuAnimator::features()).await.map_err(|error| screen_error(&error))?;
        let vertex_count = player.vertex_count();
        let (device, queue) = (screen.device().clone(), screen.queue().clone());
        let renderer = Renderer::new(device, queue, screen.format(), &surface, vertex_count);
        let gpu = gpu_animator(&screen, &player, &renderer, backend.as_deref());
        Ok(Self {
            player,
            camera: OrbitCamera::default(),
            theme: Theme::LIGHT,
            renderer,
            screen,
            gpu,
            last_milliseconds: None,
            redraw: true,
            pose_milliseconds: None,
        })
    }

    /// The avatar's texture, to be decoded and given to `setTexture`.
    #[wasm_bindgen(getter, js_name = textureImage)]
    pub fn texture_image(&self) -> Option<EncodedImage> {
        let texture = self.player.avatar().appearance.texture.as_ref()?;
        Some(EncodedImage { mime: texture.mime.clone(), bytes: texture.bytes.clone() })
    }

    /// Takes the decoded texture.
    #[wasm_bindgen(js_name = setTexture)]
    pub fn set_texture(&mut self, bitmap: web_sys::ImageBitmap) {
        let albedo = Albedo::from_bitmap(self.screen.device(), self.screen.queue(), bitmap);
        self.renderer.set_albedo(&albedo);
        self.redraw = true;
    }

    /// Reads a motion and starts it from the beginning; returns what the reader has to say about it.
    #[wasm_bindgen(js_name = loadMotion)]
    pub fn load_motion(
        &mut self,
        bytes: &[u8],
        name: &str,
        frames_per_second: Option<f32>,
    ) -> Result<Vec<String>, Error> {
        let motion = Motion::read(bytes, name, frames_per_second).map_err(|error| named("motion", &error))?;
        let notes = motion.notes.clone();
        self.player.set_motion(Some(motion)).map_err(|error| named("motion", &error))?;
        Ok(notes)
    }

    /// Goes back to the rest pose.
    #[wasm_bindgen(js_name = clearMotion)]
    pub fn clear_motion(&mut self) -> Result<(), Error> {
        self.player.set_motion(None).map_err(|error| named("motion", &error))
    }

    /// Lets time pass until `now` (milliseconds of a clock that never goes back) and draws if anything changed and the GPU keeps up. Returns
    /// whether it drew.
    pub fn frame(&mut self, now: f64) -> Result<bool, Error> {
        self.check()?;
        if !self.screen.keeps_up() {
            return Ok(false);
        }
        let passed = self.last_milliseconds.map_or(0.0, |last| 1e-3 * (now - last).max(0.0));
        self.last_milliseconds = Some(now);
        let started = milliseconds();
        let posed = match &mut self.gpu {
            None => {
                let posed = self.player.advance(passed);
                if posed {
                    self.renderer.set_vertices(self.player.positions(), self.player.normals());
                }
                posed
            }
            Some(gpu) => match self.player.step(passed) {
                None => false,
                Some((pose, options)) => {
                    let mut encoder = self.screen.device().create_command_encoder(&Default::default());
                    gpu.animate(&mut encoder, pose, options, None);
                    self.screen.queue().submit([encoder.finish()]);
                    self.renderer.set_outline(&gpu.outline(pose));
                    true
                }
            },
        };
        self.redraw |= posed;
        let pose_milliseconds = posed.then(|| milliseconds() - started);
        self.camera.follow(self.player.root());
        let moving = !self.camera.settled();
        self.camera.advance(passed as f32);
        if !(self.redraw || moving) {
            return Ok(false);
        }
        let (renderer, camera, theme) = (&mut self.renderer, &self.camera, &self.theme);
        let drawn = self.screen.present(|view, size| renderer.draw(view, size, camera, theme));
        self.redraw = !drawn;
        self.pose_milliseconds = pose_milliseconds;
        Ok(drawn)
    }

    /// Forgets the time of the last frame: a pause of the page is no part of the motion.
    #[wasm_bindgen(js_name = skipTime)]
    pub fn skip_time(&mut self) {
        self.last_milliseconds = None;
    }

    /// Whether the next frame will differ from the last.
    #[wasm_bindgen(getter)]
    pub fn moving(&self) -> bool {
        self.redraw || self.player.clock.running() || !self.camera.settled()
    }

    /// Throws if the GPU has reported an error or was lost.
    pub fn check(&self) -> Result<(), Error> {
        self.screen.check().map_err(|error| screen_error(&error))
    }

    /// Size of the picture in pixels of the device.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.screen.resize([width, height]);
        self.redraw = true;
    }

    /// Turns the camera, radians to the right and up.
    pub fn orbit(&mut self, azimuth: f32, elevation: f32) {
        self.camera.orbit(azimuth, elevation);
    }

    /// Multiplies the camera's distance.
    pub fn zoom(&mut self, factor: f32) {
        self.camera.zoom(factor);
    }

    /// Moves the camera's target by shares of the picture's height, right and up.
    pub fn pan(&mut self, right: f32, up: f32) {
        self.camera.pan(right, up);
    }

    /// Goes back to the first view.
    #[wasm_bindgen(js_name = resetCamera)]
    pub fn reset_camera(&mut self) {
        self.camera.reset();
    }

    /// Starts time.
    pub fn play(&mut self) {
        self.player.clock.play();
    }

    /// Stops time.
    pub fn pause(&mut self) {
        self.player.clock.pause();
    }

    /// Goes to a time of the motion, seconds.
    pub fn seek(&mut self, seconds: f64) {
        self.player.clock.seek(seconds);
        self.redraw = true;
    }

    /// Media seconds per second.
    #[wasm_bindgen(js_name = setPlaybackRate)]
    pub fn set_playback_rate(&mut self, rate: f64) {
        self.player.clock.set_rate(rate);
    }

    /// Whether the motion starts over at its end.
    #[wasm_bindgen(js_name = setLoop)]
    pub fn set_loop(&mut self, looping: bool) {
        self.player.clock.set_looping(looping);
    }

    /// `body`, `base` or `detailed`.
    #[wasm_bindgen(js_name = setView)]
    pub fn set_view(&mut self, view: &str) -> Result<(), Error> {
        self.player.options.stage = match view {
            "body" => Stage::Body,
            "base" => Stage::Base,
            "detailed" => Stage::Detailed,
            other => return Err(Error::new(&format!("view: expected body, base or detailed, found {other}"))),
        };
        self.redraw = true;
        Ok(())
    }

    /// 0 is the base, 1 as trained, 2 exaggerated.
    #[wasm_bindgen(js_name = setDetail)]
    pub fn set_detail(&mut self, detail: f32) {
        self.player.options.detail = detail;
        self.redraw = true;
    }

    /// `light` or `dark`.
    #[wasm_bindgen(js_name = setTheme)]
    pub fn set_theme(&mut self, theme: &str) {
        self.theme = if theme == "dark" { Theme::DARK } else { Theme::LIGHT };
        self.redraw = true;
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

    /// What computes and what draws.
    #[wasm_bindgen(getter)]
    pub fn backend(&self) -> String {
        if self.gpu.is_some() { "webgpu" } else { "webgpu+cpu" }.into()
    }

    /// Vertices of the finest level.
    #[wasm_bindgen(getter)]
    pub fn vertices(&self) -> usize {
        self.player.vertex_count()
    }

    /// Milliseconds that the last drawn frame took to pose (networks, solve, normals, upload); nothing where only the camera moved.
    #[wasm_bindgen(getter, js_name = poseMilliseconds)]
    pub fn pose_milliseconds(&self) -> Option<f64> {
        self.pose_milliseconds
    }
}

/// What poses the avatar on the GPU, if that is wanted and possible; says on the console why not.
fn gpu_animator(screen: &Screen, player: &Player, renderer: &Renderer, backend: Option<&str>) -> Option<GpuAnimator> {
    let is_suitable = match backend {
        None => GpuAnimator::check_adapter(screen.adapter_info()),
        Some("webgpu") => Ok(()),
        Some(_) => return None,
    };
    let make = |()| GpuAnimator::new(screen.device(), screen.queue(), player.animator(), renderer.vertices());
    let warn = |error: &GpuError| web_sys::console::info_1(&format!("crease computes on the CPU: {error}").into());
    is_suitable.and_then(make).inspect_err(warn).ok()
}

fn named(code: &str, error: &dyn std::fmt::Display) -> Error {
    let value = Error::new(&error.to_string());
    // A plain data property on a fresh object: setting it cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &code.into());
    value
}

fn screen_error(error: &ScreenError) -> Error {
    named(error.code(), error)
}

#[wasm_bindgen]
extern "C" {
    /// A clock of this thread that never goes back.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn milliseconds() -> f64;
}
