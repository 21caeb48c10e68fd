//! Once every buffer has its size, a frame allocates nothing.

use allocation_counter::measure;
use crease::avatar::Avatar;
use crease::motion::Motion;
use crease::player::{Player, QUALITY_LEVELS};
use crease::render::Scene;
use std::sync::Arc;
#[cfg(target_arch = "wasm32")]
use wasm_bindgen_test::wasm_bindgen_test as test;

/// Frames that may allocate: the solver looks back on two of them.
const SETTLING: usize = 4;
const FRAMES: usize = 40;
/// Seconds a frame, through the whole motion and over its end.
const STEP: f64 = 1.0 / 30.0;

const AVATARS: [(&str, &[u8]); 2] = [
    ("tiny.glb", include_bytes!("../fixtures/tiny.glb")),
    ("tiny_plain.glb", include_bytes!("../fixtures/tiny_plain.glb")),
];

fn player(name: &str, bytes: &[u8]) -> Player {
    let mut player = Player::new(Arc::new(Avatar::read(bytes, name).unwrap())).unwrap();
    let motion = include_bytes!("../fixtures/pickles/motion-numpy2.pkl");
    player.set_crossfade(0.2);
    player.set_motions(vec![Motion::read(motion, "motion-numpy2.pkl", Some(2.0)).unwrap()]).unwrap();
    player.clock.set_looping(true);
    player.clock.play();
    player
}

/// Plays one frame into `scene`, as a page does.
fn frame(player: &mut Player, scene: &mut Scene) -> bool {
    let posed = player.advance(STEP, &mut |_| ()).unwrap();
    if let Some(posed) = posed {
        scene.set_figure(posed.positions, posed.normals, posed.coarser);
        player.count_frame(STEP, 0.5 * STEP);
        return true;
    }
    false
}

/// Allocations of `FRAMES` frames after the first, and how many of them posed something.
fn allocations(player: &mut Player, scene: &mut Scene) -> (u64, usize) {
    for _ in 0..SETTLING {
        frame(player, scene);
    }
    let mut posed = 0;
    let info = measure(|| posed = (0..FRAMES).filter(|_| frame(player, scene)).count());
    (info.count_total, posed)
}

#[test]
fn a_frame_of_any_quality_allocates_nothing() {
    for (name, bytes) in AVATARS {
        let (mut player, mut scene) = (player(name, bytes), Scene::default());
        for quality in [None].into_iter().chain((0..QUALITY_LEVELS.len()).map(Some)) {
            player.set_quality(quality);
            let (count, posed) = allocations(&mut player, &mut scene);
            assert_eq!(count, 0, "{name}, quality {quality:?}");
            assert!(posed > FRAMES / 2, "{posed} frames moved");
        }
    }
}

#[test]
fn the_first_frame_is_seen_to_allocate() {
    let (name, bytes) = AVATARS[0];
    let (mut player, mut scene) = (player(name, bytes), Scene::default());
    assert!(measure(|| assert!(frame(&mut player, &mut scene))).count_total > 0);
}
