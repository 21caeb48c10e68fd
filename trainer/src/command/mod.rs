//! The subcommands: arguments in, library calls, a summary out.

pub mod ablate;
pub mod animate;
pub mod check;
pub mod compact;
pub mod compare;
pub mod demo;
pub mod eval;
pub mod import;
pub mod inspect;
pub mod register;
pub mod render;
pub mod report;
mod shown;
pub mod train;
pub mod transfer;

use anyhow::{Context, ensure};
use crease::avatar::Avatar;
use crease::body::Body;
use crease::numpy::ReadError;
use crease_trainer::check::misplacement;
use crease_trainer::interrupt::Interrupt;
use crease_trainer::sequence::{Capture, Reading, Sequence, read};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Reads a sequence of the avatar's person with the poses of a file, or its own.
fn open_sequence(
    avatar: &Avatar,
    directory: &Path,
    poses: Option<&PathBuf>,
    reading: &Reading,
) -> Result<Sequence, ReadError> {
    Sequence::open(directory, poses.map(PathBuf::as_path), reading, |_| avatar.rig.rest_joints[0])
}

fn read_avatar(path: &Path) -> anyhow::Result<Avatar> {
    Ok(Avatar::read(&read(path)?, &path.display().to_string())?)
}

/// Fails where the scans of `capture`, or `poses` beside them, lie otherwise than they are read: work on them would be for nothing.
fn ensure_placed(capture: &Capture, body: &Body, poses: &Path) -> anyhow::Result<()> {
    let problems = misplacement(capture, body, poses);
    ensure!(
        problems.is_empty(),
        "{}: {}\n--unchecked takes them as they are",
        capture.directory.display(),
        problems.join("\n")
    );
    Ok(())
}

/// Exit code of a command that its user stopped.
pub const STOPPED: u8 = 130;

/// Set by the first Ctrl-C, or request to terminate; the second ends the process at once.
fn interrupt() -> anyhow::Result<Interrupt> {
    static INTERRUPT: OnceLock<Interrupt> = OnceLock::new();
    static LISTENS: AtomicBool = AtomicBool::new(false);
    let interrupt = INTERRUPT.get_or_init(Interrupt::default).clone();
    if !LISTENS.swap(true, Ordering::Relaxed) {
        let listener = interrupt.clone();
        let stop = move || {
            if listener.is_set() {
                std::process::exit(STOPPED.into());
            }
            eprintln!("stopping as soon as what is under way can be kept; Ctrl-C again stops at once");
            listener.set();
        };
        ctrlc::set_handler(stop).context("cannot listen for Ctrl-C")?;
    }
    Ok(interrupt)
}
