//! What a painter outside of this module needs: where the scene lies in wasm memory, and the numbers of the picture.
//! Addresses are bytes from the start of wasm's memory and hold until the object they belong to is freed or changed.

use crate::render::{ANISOTROPY, BELOW_MAP, DrawnSurface, DrawnVertex, Globals, KEY_MAP, SAMPLE_COUNT, SurfaceVertex};
use std::mem::offset_of;
use wasm_bindgen::prelude::*;

/// The surface as it is drawn; see [`DrawnSurface`].
#[wasm_bindgen]
pub struct DrawnMesh {
    surface: DrawnSurface,
    /// Edges of the level that was asked for last.
    edges: Vec<[u32; 2]>,
}

impl DrawnMesh {
    pub(super) fn new(surface: DrawnSurface) -> Self {
        Self { surface, edges: Vec::new() }
    }
}

#[wasm_bindgen]
impl DrawnMesh {
    /// Address of the drawn vertices.
    #[wasm_bindgen(getter, js_name = verticesAddress)]
    pub fn vertices_address(&self) -> usize {
        self.surface.vertices.as_ptr().addr()
    }

    /// Bytes of the drawn vertices.
    #[wasm_bindgen(getter, js_name = verticesBytes)]
    pub fn vertices_bytes(&self) -> usize {
        size_of_val(self.surface.vertices.as_slice())
    }

    /// Levels of triangles.
    #[wasm_bindgen(getter, js_name = levelCount)]
    pub fn level_count(&self) -> usize {
        self.surface.levels.len()
    }

    /// Address of a level's indices, 32 bits each.
    #[wasm_bindgen(js_name = indicesAddress)]
    pub fn indices_address(&self, level: usize) -> usize {
        self.surface.levels[level].as_ptr().addr()
    }

    /// Makes a level's edges and returns their address: two indices each, 32 bits.
    #[wasm_bindgen(js_name = edgesAddress)]
    pub fn edges_address(&mut self, level: usize) -> usize {
        self.edges = self.surface.edges(level);
        self.edges.as_ptr().addr()
    }

    /// Number of the indices of the edges that were made last.
    #[wasm_bindgen(getter, js_name = edgeIndexCount)]
    pub fn edge_index_count(&self) -> usize {
        2 * self.edges.len()
    }

    /// Number of a level's indices.
    #[wasm_bindgen(js_name = indexCount)]
    pub fn index_count(&self, level: usize) -> usize {
        3 * self.surface.levels[level].len()
    }
}

/// The numbers of the picture, the same for whatever draws it.
#[wasm_bindgen]
pub struct PictureLayout {
    /// Texels a side of the key light's map.
    #[wasm_bindgen(readonly, js_name = keyMapTexels)]
    pub key_map_texels: u32,
    /// Levels by which the figure is coarser there.
    #[wasm_bindgen(readonly, js_name = keyMapCoarser)]
    pub key_map_coarser: usize,
    /// Texels a side of the map from beneath.
    #[wasm_bindgen(readonly, js_name = belowMapTexels)]
    pub below_map_texels: u32,
    /// Levels by which the figure is coarser there.
    #[wasm_bindgen(readonly, js_name = belowMapCoarser)]
    pub below_map_coarser: usize,
    /// Samples a pixel.
    #[wasm_bindgen(readonly, js_name = sampleCount)]
    pub sample_count: u32,
    /// Anisotropy of the albedo.
    #[wasm_bindgen(readonly)]
    pub anisotropy: u16,
    /// Bytes of the globals.
    #[wasm_bindgen(readonly, js_name = globalsBytes)]
    pub globals_bytes: usize,
    /// Where in the globals the key light's matrix lies.
    #[wasm_bindgen(readonly, js_name = keyMatrixOffset)]
    pub key_matrix_offset: usize,
    /// Where in the globals the matrix of the map from beneath lies.
    #[wasm_bindgen(readonly, js_name = belowMatrixOffset)]
    pub below_matrix_offset: usize,
    /// Bytes of a figure's vertex.
    #[wasm_bindgen(readonly, js_name = surfaceVertexBytes)]
    pub surface_vertex_bytes: usize,
    /// Bytes of a drawn vertex.
    #[wasm_bindgen(readonly, js_name = drawnVertexBytes)]
    pub drawn_vertex_bytes: usize,
    /// Where in a drawn vertex its texture coordinates lie; the body's vertex comes first.
    #[wasm_bindgen(readonly, js_name = textureCoordinatesOffset)]
    pub texture_coordinates_offset: usize,
    /// Where in a drawn vertex its colour lies.
    #[wasm_bindgen(readonly, js_name = colourOffset)]
    pub colour_offset: usize,
}

#[wasm_bindgen]
impl PictureLayout {
    /// The one there is.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self {
            key_map_texels: KEY_MAP.texels,
            key_map_coarser: KEY_MAP.coarser,
            below_map_texels: BELOW_MAP.texels,
            below_map_coarser: BELOW_MAP.coarser,
            sample_count: SAMPLE_COUNT,
            anisotropy: ANISOTROPY,
            globals_bytes: size_of::<Globals>(),
            key_matrix_offset: Globals::KEY_MATRIX_OFFSET,
            below_matrix_offset: Globals::BELOW_MATRIX_OFFSET,
            surface_vertex_bytes: size_of::<SurfaceVertex>(),
            drawn_vertex_bytes: size_of::<DrawnVertex>(),
            texture_coordinates_offset: offset_of!(DrawnVertex, texture_coordinates),
            colour_offset: offset_of!(DrawnVertex, colour),
        }
    }
}

impl Default for PictureLayout {
    fn default() -> Self {
        Self::new()
    }
}
