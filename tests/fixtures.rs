//! The committed fixtures still mean what they meant when they were written (examples/write_fixtures.rs).

use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::body::Pose;
use glam::{Vec3, Vec3A};
use std::sync::Arc;

/// Metres: the solver's tolerance and rounding, on any machine.
const TOLERANCE: f32 = 5e-5;

fn fixture(name: &str) -> Vec<u8> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn pose() -> Pose {
    let json: serde_json::Value = serde_json::from_slice(&fixture("tiny.pose.json")).unwrap();
    let numbers: Vec<f32> = serde_json::from_value(json["pose"].clone()).unwrap();
    let translation: [f32; 3] = serde_json::from_value(json["translation"].clone()).unwrap();
    Pose::from_axis_angle(&numbers, Vec3::from_array(translation))
}

fn largest_error(name: &str, pose: &Pose) -> f32 {
    let avatar = Avatar::read(&fixture(&format!("{name}.glb")), name).unwrap();
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
        let avatar = Avatar::read(&file, name).unwrap();
        let rewritten = avatar.write();
        // The rest pose's positions, which no reader of avatars uses, may round otherwise on another machine.
        assert_eq!(rewritten.len(), file.len(), "{name}");
        assert!(Avatar::read(&rewritten, name).unwrap() == avatar, "{name}");
    }
}
