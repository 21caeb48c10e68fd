//! The committed fixtures still mean what they meant when they were written (examples/write_fixtures.rs): natively, and as wasm in a
//! headless browser.

#[cfg(feature = "render")]
mod allocations;

use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::motion::Motion;
use glam::{Vec3, Vec3A};
use std::sync::Arc;
#[cfg(target_arch = "wasm32")]
use wasm_bindgen_test::wasm_bindgen_test as test;

#[cfg(target_arch = "wasm32")]
wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_browser);

/// Metres: the solver's tolerance and rounding, on any machine.
const TOLERANCE: f32 = 5e-5;

fn fixture(name: &str) -> &'static [u8] {
    match name {
        "tiny.glb" => include_bytes!("fixtures/tiny.glb"),
        "tiny_plain.glb" => include_bytes!("fixtures/tiny_plain.glb"),
        "tiny.positions" => include_bytes!("fixtures/tiny.positions"),
        "tiny_plain.positions" => include_bytes!("fixtures/tiny_plain.positions"),
        "tiny.pose.json" => include_bytes!("fixtures/tiny.pose.json"),
        _ => panic!("there is no fixture {name}"),
    }
}

fn pose() -> Pose {
    let json: serde_json::Value = serde_json::from_slice(fixture("tiny.pose.json")).unwrap();
    let numbers: Vec<f32> = serde_json::from_value(json["pose"].clone()).unwrap();
    let translation: [f32; 3] = serde_json::from_value(json["translation"].clone()).unwrap();
    Pose::from_axis_angle(&numbers, Vec3::from_array(translation))
}

fn largest_error(name: &str, pose: &Pose) -> f32 {
    let avatar = Avatar::read(fixture(&format!("{name}.glb")), name).unwrap();
    let expected: Vec<f32> = fixture(&format!("{name}.positions"))
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    let mut animator = Animator::new(Arc::new(avatar)).unwrap();
    let positions = animator.animate(pose, &Options::default());
    assert_eq!(3 * positions.len(), expected.len());
    positions.iter().zip(expected.chunks_exact(3)).map(|(p, e)| p.distance(Vec3A::from_slice(e))).fold(0.0, f32::max)
}

#[test]
fn the_fixtures_animate_as_they_did() {
    for name in ["tiny", "tiny_plain"] {
        let error = largest_error(name, &pose());
        assert!(error < TOLERANCE, "{name}: {error} m");
    }
}

#[test]
fn another_pose_is_told_apart() {
    let mut other = pose();
    other.rotations[18] *= glam::Quat::from_rotation_y(0.01);
    assert!(largest_error("tiny", &other) > TOLERANCE);
}

#[test]
fn the_fixtures_say_the_same_when_written_again() {
    for name in ["tiny.glb", "tiny_plain.glb"] {
        let file = fixture(name);
        let avatar = Avatar::read(file, name).unwrap();
        let rewritten = avatar.write();
        // The rest pose's positions, which no reader of avatars uses, may round otherwise on another machine.
        // In the browser another library deflates, a little worse.
        if cfg!(not(target_arch = "wasm32")) {
            assert_eq!(rewritten.len(), file.len(), "{name}");
        }
        assert!(Avatar::read(&rewritten, name).unwrap() == avatar, "{name}");
    }
}

#[test]
fn a_pickled_motion_moves_the_fixture() {
    let bytes = include_bytes!("fixtures/pickles/motion-numpy2.pkl");
    let motion = Motion::read(bytes, "motion-numpy2.pkl", Some(2.0)).unwrap();
    let avatar = Avatar::read(fixture("tiny.glb"), "tiny").unwrap();
    let mut animator = Animator::new(Arc::new(avatar)).unwrap();
    let first = animator.animate(&motion.sample(0.0), &Options::default()).to_vec();
    let last = animator.animate(&motion.sample(motion.duration()), &Options::default());
    assert!(last.iter().all(|position| position.is_finite()));
    assert!(first.iter().zip(last).any(|(a, b)| a.distance(*b) > 0.01), "the motion moves something");
}
