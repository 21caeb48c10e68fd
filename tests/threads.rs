//! A frame on several threads is the frame of one thread.

use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::motion::Motion;
use crease::threads;
use glam::Vec3A;
use std::path::Path;
use std::sync::Arc;

fn asset(path: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/assets").join(path);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Frames that follow each other, of an avatar that is large enough to be shared out.
fn frames() -> Vec<Vec<Vec3A>> {
    let avatar = Avatar::read(&asset("shirt-dancer.glb"), "shirt-dancer.glb").unwrap();
    let motion = Motion::read(&asset("motions/dance_a.pkl"), "dance_a.pkl", Some(60.0)).unwrap();
    let mut animator = Animator::new(Arc::new(avatar)).unwrap();
    let options = Options { warm_start: true, ..Options::default() };
    let frame = |frame: u8| animator.animate(&motion.sample_looped(f32::from(frame) / 30.0), &options).to_vec();
    (0..4).map(frame).collect()
}

#[test]
fn it_is_the_same_to_the_bit() {
    let alone = frames();
    for _ in 0..3 {
        std::thread::spawn(|| threads::join());
    }
    while threads::joined() < 3 {
        std::thread::yield_now();
    }
    let together = frames();
    for (frame, (alone, together)) in alone.iter().zip(&together).enumerate() {
        assert!(alone == together, "frame {frame}");
    }
    assert!(alone[0] != alone[1], "there is something to compare");
}
