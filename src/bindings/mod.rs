//! What JavaScript sees of the runtime: wasm-bindgen only, no logic.

mod camera;
mod drawing;
mod transfer;
mod viewer;
mod webgpu;

use js_sys::{Error, Reflect};
use wasm_bindgen::prelude::*;

/// Reports panics on the console with their place; called by the module itself.
#[wasm_bindgen(start)]
fn start() {
    console_error_panic_hook::set_once();
}

/// `error` as JavaScript's, with a `code` for programs.
fn named(code: &str, error: &dyn std::fmt::Display) -> Error {
    let value = Error::new(&error.to_string());
    // A plain data property on a fresh object: setting it cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &code.into());
    value
}
