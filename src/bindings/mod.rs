//! What JavaScript sees of the runtime: wasm-bindgen only, no logic.

mod camera;
mod drawing;
#[cfg(feature = "threads")]
mod threads;
mod transfer;
mod viewer;
mod webgpu;

use js_sys::{Error, Reflect};

/// `error` as JavaScript's, with a `code` for programs.
fn named(code: &str, error: &dyn std::fmt::Display) -> Error {
    let value = Error::new(&error.to_string());
    // A plain data property on a fresh object: setting it cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &code.into());
    value
}
