//! What strangers send: for every reader, the player and the animator a check that no input may break, valid inputs to start from, and
//! mutations that keep a file's outer form.
//!
//! `cargo xtask fuzz` searches with coverage; what it finds goes to found/ and is checked by `cargo test` from then on.

pub mod allocation;
mod animation;
pub mod containers;
pub mod coverage;
pub mod mutation;
mod readers;
pub mod search;
mod seeds;

/// One thing to break.
pub struct Target {
    /// Its name on the command line, and of its folder in found/.
    pub name: &'static str,
    /// Panics where the input breaks it.
    pub check: fn(&[u8]),
    /// Valid inputs to start from.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// The form that mutations keep: parts of the input, and the input of parts.
    pub container: Option<Container>,
}

/// A file's outer form, whose checksums and lengths a blind mutation would only break.
#[derive(Clone, Copy)]
pub struct Container {
    /// The parts inside; none where the input has another form.
    pub open: fn(&[u8]) -> Option<Vec<Part>>,
    /// The file of the parts.
    pub close: fn(&[Part]) -> Vec<u8>,
}

/// A named stretch of bytes inside a container.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of the entry or chunk.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Every target.
pub const TARGETS: [Target; 15] = [
    Target { name: "avatar", check: readers::avatar, seeds: seeds::avatars, container: Some(containers::GLB) },
    Target { name: "motion_pickle", check: readers::motion, seeds: seeds::motion_pickles, container: None },
    Target {
        name: "motion_npz",
        check: readers::motion,
        seeds: seeds::motion_archives,
        container: Some(containers::NPZ),
    },
    Target { name: "body_pickle", check: readers::body, seeds: seeds::body_pickles, container: None },
    Target { name: "body_npz", check: readers::body, seeds: seeds::body_archives, container: Some(containers::NPZ) },
    Target { name: "arrays_pickle", check: readers::arrays, seeds: seeds::array_pickles, container: None },
    Target { name: "ply", check: readers::ply, seeds: seeds::plys, container: None },
    Target { name: "obj", check: readers::obj, seeds: seeds::objs, container: None },
    Target {
        name: "scan_npz",
        check: readers::scan_npz,
        seeds: seeds::scan_archives,
        container: Some(containers::NPZ),
    },
    Target { name: "depth", check: readers::depth, seeds: seeds::views, container: Some(containers::VIEW) },
    Target { name: "sequence", check: readers::sequence, seeds: seeds::sequences, container: None },
    Target { name: "run", check: readers::run, seeds: seeds::runs, container: None },
    Target {
        name: "checkpoint",
        check: readers::checkpoint,
        seeds: seeds::checkpoints,
        container: Some(containers::CHECKPOINT),
    },
    Target { name: "player", check: animation::player, seeds: seeds::noise, container: None },
    Target { name: "animate", check: animation::animate, seeds: seeds::noise, container: None },
];

/// The target of a name.
pub fn target(name: &str) -> Option<&'static Target> {
    const { &TARGETS }.iter().find(|target| target.name == name)
}
