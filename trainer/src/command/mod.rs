//! The subcommands: arguments in, library calls, a summary out.

pub mod ablate;
pub mod animate;
pub mod compact;
pub mod demo;
pub mod eval;
pub mod inspect;
pub mod train;

use crease::avatar::Avatar;
use crease_trainer::sequence::read;
use std::path::Path;

fn read_avatar(path: &Path) -> anyhow::Result<Avatar> {
    Ok(Avatar::read(&read(path)?, &path.display().to_string())?)
}
