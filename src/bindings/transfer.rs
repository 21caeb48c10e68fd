//! What leaves a viewer as a file, and what it takes from other avatars.

use super::named;
use super::viewer::{EncodedImage, Viewer};
use crate::avatar::{Avatar, Texture};
use crate::export::{ExportedMesh, MeshFormat, Texels};
use crate::mesh::vertex_normals;
use glam::Vec3A;
use js_sys::Error;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
    /// The mesh of this moment, at its finest, as a file (`glb`, `obj` or `ply`) with the texture that is shown: `mime` and `image` encoded;
    /// `texels` decoded, for formats that hold colours but no picture: width and height, 32 bits each, then RGBA.
    #[wasm_bindgen(js_name = exportMesh)]
    pub fn export_mesh(
        &mut self,
        format: &str,
        mime: Option<String>,
        image: Option<Vec<u8>>,
        texels: Option<Vec<u8>>,
    ) -> Result<Vec<u8>, Error> {
        let Some(format) = MeshFormat::ALL.into_iter().find(|known| known.extension() == format) else {
            return Err(Error::new(&format!("format: expected glb, obj or ply, found {format}")));
        };
        let surface = self.drawn_surface()?;
        let positions = self.player_mut().finest_mesh();
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        vertex_normals(&positions, self.player().triangles(), &mut normals);
        let drawn = |values: &[Vec3A]| -> Vec<Vec3A> {
            surface.vertices.iter().map(|vertex| values[vertex.body_vertex as usize]).collect()
        };
        let has_texture = image.is_some();
        let mut mesh = ExportedMesh {
            positions: drawn(&positions),
            normals: drawn(&normals),
            triangles: surface.levels.last().cloned().unwrap_or_default(),
            texture: mime.zip(image).map(|(mime, bytes)| Texture { mime, bytes }),
            ..ExportedMesh::default()
        };
        if has_texture {
            mesh.texture_coordinates = surface.vertices.iter().map(|vertex| vertex.texture_coordinates).collect();
            if let Some(texels) = texels.as_deref().and_then(texels_of) {
                mesh.colour_by(&texels);
            }
        } else {
            mesh.colours = surface.vertices.iter().map(|vertex| vertex.srgb()).collect();
        }
        Ok(mesh.encode(format))
    }

    /// Wears the wrinkles of the avatar in `bytes` (`name` is for messages) on its own base.
    #[wasm_bindgen(js_name = wearDetailOf)]
    pub fn wear_detail_of(&mut self, bytes: &[u8], name: &str) -> Result<(), Error> {
        let other = Avatar::read(bytes, name).map_err(|error| named("avatar", &error))?;
        let own = self.own_avatar();
        let both = own.with_detail_of(&other, name).map_err(|error| named("avatar", &error))?;
        self.wear(Arc::new(both), Some(own))
    }

    /// Wears its own wrinkles again.
    #[wasm_bindgen(js_name = wearOwnDetail)]
    pub fn wear_own_detail(&mut self) -> Result<(), Error> {
        self.wear(self.own_avatar(), None)
    }

    /// The texture of the avatar in `bytes` (`name` is for messages), laid out as this one's.
    #[wasm_bindgen(js_name = textureOf)]
    pub fn texture_of(&self, bytes: &[u8], name: &str) -> Result<EncodedImage, Error> {
        let other = Avatar::read(bytes, name).map_err(|error| named("avatar", &error))?;
        let own = self.player().avatar();
        let texture = own.texture_of(&other, name).map_err(|error| named("texture", &error))?;
        Ok(EncodedImage { mime: texture.mime.clone(), bytes: texture.bytes.clone() })
    }
}

fn texels_of(bytes: &[u8]) -> Option<Texels<'_>> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    Texels::new(word(0)?, word(4)?, bytes.get(8..)?)
}
