//! Writes the fixtures of tests/fixtures: `cargo run --features fixture --example write_fixtures`.
//!
//! - `tiny.glb`: compact functions, Loop base, relative form, vertex colours.
//! - `tiny_plain.glb`: perceptrons, midpoint base, absolute form, a texture.
//! - `tiny.pose.json`: one pose, SMPL's axis-angle numbers and a translation.
//! - `tiny.positions`, `tiny_plain.positions`: the detailed mesh in that pose, x y z of each vertex of the finest level as
//!   little-endian f32, metres. Whoever animates the file gets them within 0.05 mm.

use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::fixture;
use crease::rotation::axis_angle_from_quat;
use crease::solver::Stop;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    fs::create_dir_all(&folder)?;
    let bent = fixture::bent_pose();
    let angles: Vec<f32> = bent.rotations.iter().flat_map(|&q| axis_angle_from_quat(q).to_array()).collect();
    let pose_json = serde_json::json!({ "pose": angles, "translation": bent.translation.to_array() });
    fs::write(folder.join("tiny.pose.json"), format!("{pose_json:#}\n"))?;
    let pose = Pose::from_axis_angle(&angles, bent.translation);

    for (name, avatar) in [("tiny", fixture::compact_avatar()), ("tiny_plain", fixture::plain_avatar())] {
        let file = avatar.write();
        fs::write(folder.join(name).with_extension("glb"), &file)?;
        let mut animator = Animator::new(Arc::new(Avatar::read(&file, name)?))?;
        let options = Options { stop: Stop::Iterations(30), ..Options::default() };
        let positions = animator.animate(&pose, &options);
        let bytes: Vec<u8> = positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect();
        fs::write(folder.join(name).with_extension("positions"), bytes)?;
        println!("{name}: {} bytes, {} positions", file.len(), positions.len());
    }
    Ok(())
}
