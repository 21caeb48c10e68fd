//! How a viewer's figure is looked at.

use super::viewer::Viewer;
use crate::render::Follow;
use glam::Vec3;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
    /// Turns the camera, radians to the right and up.
    pub fn orbit(&mut self, azimuth: f32, elevation: f32) {
        self.scene_mut().camera.orbit(azimuth, elevation);
    }

    /// Multiplies the camera's distance.
    pub fn zoom(&mut self, factor: f32) {
        self.scene_mut().camera.zoom(factor);
    }

    /// Moves the camera's target by shares of the picture's height, right and up.
    pub fn pan(&mut self, right: f32, up: f32) {
        self.scene_mut().camera.pan(right, up);
    }

    /// Goes back to the first view.
    #[wasm_bindgen(js_name = resetCamera)]
    pub fn reset_camera(&mut self) {
        self.scene_mut().camera.reset();
    }

    /// Ends the camera's movement at once.
    #[wasm_bindgen(js_name = jumpCamera)]
    pub fn jump_camera(&mut self) {
        self.scene_mut().camera.jump();
        self.redraw();
    }

    /// Ends the camera's movement where it ends for the pose of this moment.
    #[wasm_bindgen(js_name = settleCamera)]
    pub fn settle_camera(&mut self) {
        let root = self.player().root_at_clock();
        self.scene_mut().camera.follow(root);
        self.jump_camera();
    }

    /// Sets the first view, and goes there: radians, metres or a share of the usual distance; what is not given is as usual.
    #[wasm_bindgen(js_name = setOrbit)]
    pub fn set_orbit(&mut self, azimuth: Option<f32>, elevation: Option<f32>, distance: Option<f32>, share: f32) {
        self.scene_mut().camera.set_orbit(azimuth, elevation, distance, share);
    }

    /// Sets what the first view looks at, metres; none is the usual point.
    #[wasm_bindgen(js_name = setTarget)]
    pub fn set_target(&mut self, target: Option<Vec<f32>>) {
        let target = target.and_then(|target| <[f32; 3]>::try_from(target).ok()).map(Vec3::from);
        self.scene_mut().camera.set_target(target);
    }

    /// Sets the vertical field of view, radians; none is the usual one.
    #[wasm_bindgen(js_name = setFieldOfView)]
    pub fn set_field_of_view(&mut self, radians: Option<f32>) {
        self.scene_mut().camera.set_field_of_view(radians);
        self.redraw();
    }

    /// Turns about the figure, radians a second, except for `rest` seconds after the camera was moved.
    #[wasm_bindgen(js_name = setTurn)]
    pub fn set_turn(&mut self, radians_per_second: f32, rest: f32) {
        self.scene_mut().camera.set_turn(radians_per_second, rest);
    }

    /// `soft`, `root` or `none`.
    #[wasm_bindgen(js_name = setFollow)]
    pub fn set_follow(&mut self, follow: &str) {
        self.scene_mut().camera.set_follow(match follow {
            "root" => Follow::Root,
            "none" => Follow::Stay,
            _ => Follow::Soft,
        });
        self.redraw();
    }

    /// Where the camera is: azimuth, elevation (radians), distance, target (metres), vertical field of view (radians).
    #[wasm_bindgen(getter, js_name = cameraPlace)]
    pub fn camera_place(&self) -> Vec<f32> {
        let camera = &self.scene().camera;
        let orbit = camera.orbit_now();
        let [x, y, z] = orbit.target.to_array();
        vec![orbit.azimuth, orbit.elevation, orbit.distance, x, y, z, camera.field_of_view()]
    }
}
