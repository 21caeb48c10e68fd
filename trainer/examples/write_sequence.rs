//! Writes a sequence made in code, and the small body that it shows: `write_sequence DIRECTORY [FRAMES] [POINTS]`.
//!
//! The commands that try the trainer's endurance start from it.

#[allow(dead_code, reason = "tests use the rest")]
#[path = "../tests/common/mod.rs"]
mod common;

use std::path::Path;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, numbers @ ..] = arguments.as_slice() else {
        panic!("expected DIRECTORY [FRAMES] [POINTS], found {arguments:?}");
    };
    let number = |index: usize, default: usize| {
        numbers.get(index).map_or(default, |text| text.parse().expect("FRAMES and POINTS are numbers"))
    };
    let directory = Path::new(directory);
    let body = common::write_frames(directory, number(0, common::FRAME_COUNT), number(1, 4_000));
    common::write_body_model(&directory.join("model.npz"), &body);
}
