//! The figure for painters outside of this module, and what is to tell about it.

use super::{EncodedImage, Viewer};
use crate::bindings::drawing::DrawnMesh;
use js_sys::Error;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
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

    /// Vertices of the finest level.
    #[wasm_bindgen(getter)]
    pub fn vertices(&self) -> usize {
        self.player.vertex_count()
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

    /// Milliseconds that the last drawn frame took to pose (networks, solve, normals, packing); nothing where only the camera moved.
    #[wasm_bindgen(getter, js_name = poseMilliseconds)]
    pub fn pose_milliseconds(&self) -> Option<f64> {
        self.pose_milliseconds
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

    /// Whether it wears another avatar's wrinkles.
    #[wasm_bindgen(getter, js_name = wearsOtherDetail)]
    pub fn wears_other_detail(&self) -> bool {
        self.own_avatar.is_some()
    }
}
