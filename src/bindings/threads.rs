//! Threads for the frames: workers of the page that share this module's memory.

use wasm_bindgen::prelude::*;

/// Has this worker take part in the frames that others compute. It does not come back.
#[wasm_bindgen(js_name = joinThreads)]
pub fn join_threads() {
    crate::threads::join()
}
