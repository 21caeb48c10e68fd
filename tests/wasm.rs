//! What must hold on the wasm target too, run in a headless browser by `cargo xtask test`.
#![cfg(target_arch = "wasm32")]

use crease::rotation::{axis_angle_from_quat, quat_from_axis_angle};
use glam::Vec3;
use wasm_bindgen_test::{wasm_bindgen_test, wasm_bindgen_test_configure};

wasm_bindgen_test_configure!(run_in_browser);

#[wasm_bindgen_test]
fn axis_angle_round_trip_keeps_angles_up_to_pi() {
    for vector in [Vec3::ZERO, Vec3::new(0.3, -1.2, 0.7), Vec3::new(0.0, 3.1, 0.0)] {
        let back = axis_angle_from_quat(quat_from_axis_angle(vector));
        assert!((back - vector).length() < 1e-5, "{vector} came back as {back}");
    }
}
