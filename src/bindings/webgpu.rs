//! The painter that draws through WebGPU, and poses there, too, where that is wanted.

use super::named;
use super::viewer::Viewer;
use crate::gpu::{GpuAnimator, GpuError};
use crate::player::Wanted;
use crate::render::screen::{Screen, ScreenError};
use crate::render::{Albedo, Renderer};
use js_sys::Error;
use wasm_bindgen::prelude::*;

/// Devices that this thread's painters draw with: one for all of them.
#[wasm_bindgen(js_name = deviceCount)]
pub fn device_count() -> usize {
    crate::render::screen::device_count()
}

/// Draws one viewer's scene on one canvas through WebGPU.
#[wasm_bindgen]
pub struct WebGpuPainter {
    screen: Screen,
    renderer: Option<Renderer>,
    computes: bool,
    animator: Option<GpuAnimator>,
    /// Bytes of the animator's buffers.
    computing_bytes: u64,
    /// What the GPU posed last.
    posed: Option<Wanted>,
}

#[wasm_bindgen]
impl WebGpuPainter {
    /// Asks for a device that can draw on `canvas`, an OffscreenCanvas or a canvas element. `computes`: it poses the avatar as well;
    /// unless `forced`, only where the adapter is hardware.
    pub async fn create(canvas: JsValue, computes: bool, forced: bool) -> Result<WebGpuPainter, Error> {
        let screen = Screen::new(canvas, GpuAnimator::features()).await.map_err(|error| screen_error(&error))?;
        if computes && !forced {
            GpuAnimator::check_adapter(screen.adapter_info()).map_err(|error| gpu_error(&error))?;
        }
        Ok(Self { screen, renderer: None, computes, animator: None, computing_bytes: 0, posed: None })
    }

    /// Takes what never changes about the viewer's figure, its detail where that is there; again where its avatar was replaced.
    pub fn prepare(&mut self, viewer: &Viewer) -> Result<(), Error> {
        let surface = viewer.drawn_surface()?;
        let (device, queue) = (self.screen.device().clone(), self.screen.queue().clone());
        let renderer = Renderer::new(device, queue, self.screen.format(), &surface, viewer.vertices());
        self.renderer = Some(renderer);
        self.posed = None;
        self.animator = None;
        self.computing_bytes = 0;
        self.prepare_detail(viewer)
    }

    /// Takes what never changes about the viewer's detail, where there is some: from then on it poses by itself, if it is to.
    #[wasm_bindgen(js_name = prepareDetail)]
    pub fn prepare_detail(&mut self, viewer: &Viewer) -> Result<(), Error> {
        if self.computes
            && self.animator.is_none()
            && let (Some(animator), Some(renderer)) = (viewer.player().animator(), &self.renderer)
        {
            let (device, queue) = (self.screen.device(), self.screen.queue());
            let animator = GpuAnimator::new(device, queue, animator, renderer.vertices());
            let animator = animator.map_err(|error| gpu_error(&error))?;
            self.computing_bytes = animator.buffer_bytes();
            self.animator = Some(animator);
        }
        Ok(())
    }

    /// Takes the decoded texture of the figure.
    #[wasm_bindgen(js_name = setTexture)]
    pub fn set_texture(&mut self, bitmap: web_sys::ImageBitmap) {
        if let Some(renderer) = &mut self.renderer {
            let albedo = Albedo::from_bitmap(self.screen.device(), self.screen.queue(), bitmap);
            renderer.set_albedo(&albedo);
        }
    }

    /// Size of the picture in pixels of the device.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.screen.resize([width, height]);
    }

    /// Whether it poses the viewer's avatar by itself. Passes on the GPU do not tell of f_l.
    pub fn poses(&self, viewer: &Viewer) -> bool {
        self.animator.is_some() && !viewer.player().tells_laplacian
    }

    /// Bytes of buffers and textures on the GPU, without those that the browser has for the canvas.
    #[wasm_bindgen(getter, js_name = gpuBytes)]
    pub fn gpu_bytes(&self) -> f64 {
        let Some(renderer) = &self.renderer else { return 0.0 };
        // The vertices belong to both.
        let computing = self.computing_bytes.saturating_sub(renderer.vertices().size());
        (renderer.bytes() + computing) as f64
    }

    /// Whether the GPU keeps up, so that another picture may be drawn.
    #[wasm_bindgen(js_name = keepsUp)]
    pub fn keeps_up(&self) -> bool {
        self.screen.keeps_up()
    }

    /// Draws the viewer's scene. Returns whether there was something to draw on; throws where vertices of an earlier pose were not finite,
    /// which has kept them where they were.
    pub fn draw(&mut self, viewer: &mut Viewer) -> Result<bool, Error> {
        let poses = self.poses(viewer);
        let Some(renderer) = &mut self.renderer else { return Ok(false) };
        if !poses {
            self.posed = None;
        } else if let Some(animator) = &mut self.animator
            && let Some(wanted) = viewer.player().wanted()
            && self.posed.as_ref() != Some(wanted)
        {
            animator.animate(&wanted.pose, &wanted.options, None);
            let (outline, coarser) = (animator.outline(&wanted.pose), wanted.coarser);
            self.posed = Some(wanted.clone());
            viewer.scene_mut().set_outline(&outline, coarser);
        }
        if renderer.wants_lines(viewer.scene()) {
            renderer.set_lines(&viewer.drawn_surface()?);
        }
        let drawn = self.screen.present(|view, size| renderer.draw(view, size, viewer.scene()));
        match self.animator.as_mut().map_or(0, GpuAnimator::take_not_finite) {
            0 => Ok(drawn),
            count => Err(named("avatar", &viewer.player().not_finite(count))),
        }
    }

    /// Throws if the GPU has reported an error or was lost.
    pub fn check(&self) -> Result<(), Error> {
        self.screen.check().map_err(|error| screen_error(&error))
    }

    /// Loses the device as a driver's restart does, for tests.
    pub fn lose(&self) {
        self.screen.lose();
    }
}

fn screen_error(error: &ScreenError) -> Error {
    named(error.code(), error)
}

fn gpu_error(error: &GpuError) -> Error {
    named("unsupported", error)
}
