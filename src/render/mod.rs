//! Drawing: a lit, textured figure with soft shadows on a floor, through wgpu, within WebGPU's baseline.
//!
//! A [`Scene`] is what there is to see, for any device. [`Renderer`] draws it through wgpu: it takes a device, a queue and a target format.
//! Surfaces, windows and canvases are its caller's business, so that it draws to a texture as well as to a page. Where there is no WebGPU,
//! web/ draws the same scene through WebGL2, with the same shaders in GLSL. Space is metres, y up, the floor at y = 0. Colour is linear until a shader
//! encodes it as sRGB at its end.

mod albedo;
mod backdrop;
mod camera;
mod depth_map;
mod drawn_surface;
mod environment;
mod figure;
mod globals;
mod light;
mod renderer;
mod scene;
#[cfg(all(target_arch = "wasm32", feature = "web"))]
pub mod screen;
mod shader_sources;
mod targets;
mod view;

#[cfg(test)]
mod shader_tests;
#[cfg(test)]
mod webgl2_shader_sources;

pub use albedo::{ANISOTROPY, Albedo};
pub use camera::{Follow, Orbit, OrbitCamera};
pub use crease_posing::surface_vertex::SurfaceVertex;
pub use drawn_surface::{DrawnSurface, DrawnVertex};
pub use environment::Environment;
pub use globals::{Globals, Theme};
pub use light::{BELOW_MAP, KEY_MAP, MapSize};
pub use renderer::Renderer;
pub use scene::Scene;
pub use targets::SAMPLE_COUNT;
pub use view::{VALUE_RANGE, View};
