//! The wasm module that web/ wraps. Linking optimises all crates together, at the level of the one that is linked: a crate of its own keeps
//! it from being that of `crease`, which is compiled for size.

#[cfg(target_arch = "wasm32")]
use crease as _;
