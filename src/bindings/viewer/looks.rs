//! How the figure is shown: quality, view, detail and light.

use super::Viewer;
use crate::animate::Stage;
use crate::player::QUALITY_LEVELS;
use crate::render::{Environment, Theme, View};
use js_sys::Error;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
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
}
