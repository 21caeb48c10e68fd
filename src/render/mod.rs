//! Drawing: a lit, textured figure with soft shadows on a floor, through wgpu, within WebGPU's baseline.
//!
//! [`Renderer`] takes a device, a queue and a target format. Surfaces, windows and canvases are its caller's business, so that it draws
//! to a texture as well as to a page. Space is metres, y up, the floor at y = 0. Colour is linear until a shader
//! encodes it as sRGB at its end.

mod albedo;
mod backdrop;
mod camera;
mod depth_map;
mod drawn_surface;
mod figure;
mod globals;
mod light;
mod renderer;
#[cfg(all(target_arch = "wasm32", feature = "web"))]
pub mod screen;
mod surface_vertex;
mod targets;

#[cfg(test)]
mod shader_tests;

pub use albedo::Albedo;
pub use camera::{Orbit, OrbitCamera};
pub use drawn_surface::{DrawnSurface, DrawnVertex};
pub use globals::Theme;
pub use renderer::Renderer;
