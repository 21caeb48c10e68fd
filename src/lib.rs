//! The runtime of a crease avatar: everything that a trained avatar needs in order to move.
//!
//! A pose goes in; a detailed, wrinkled mesh comes out ([`animate`]). Units are metres and radians, y is up,
//! Laplacian coordinates δ are in 1/m and point outward on a sphere (δ = −Δx, paper Eq. cotLap).
//!
//! Imports point one way:
//! `rotation ◂ mesh ◂ body ◂ motion`, `encoding ◂ network`, `mesh ◂ laplacian ◂ solver`, then `avatar`, `animate`,
//! `export`, `gpu`, `render`, `player`, `bindings`.

pub mod animate;
pub mod avatar;
#[cfg(all(target_arch = "wasm32", feature = "web"))]
pub mod bindings;
pub mod body;
pub mod colour;
mod decimal;
pub mod export;
#[cfg(any(feature = "render", feature = "gpu"))]
mod filled_buffer;
#[cfg(any(feature = "fixture", all(test, feature = "factor")))]
pub mod fixture;
#[cfg(feature = "gpu")]
pub mod gpu;
mod inflate;
pub mod memory;
pub mod motion;
pub mod numpy;
pub mod player;
#[cfg(feature = "render")]
pub mod render;
#[cfg(all(test, any(feature = "render", feature = "gpu")))]
mod shader_check;
#[cfg(any(feature = "render", feature = "gpu"))]
mod wgsl;

#[cfg(feature = "threads")]
pub use crease_posing::threads;
pub use crease_posing::{encoding, laplacian, mesh, network, pose_feature, rotation, solver};
