//! Choices of the method varied one by one, and what each does to the result.

mod compact;
mod fidelity;
mod option;

pub use compact::{Row as CompactRow, compact_against_plain, table as compact_table};
pub use fidelity::{Row as FidelityRow, fidelity, table as fidelity_table};
pub use option::{Row as OptionRow, option, table as option_table};

use crate::evaluate::{Evaluation, evaluate};
use crate::sequence::Sequence;
use crease::avatar::Avatar;
use std::sync::Arc;

/// Bytes of an avatar's file, and how close what is read from it comes.
fn measured_avatar(avatar: &Avatar, sequence: &Sequence, frames: &[usize]) -> anyhow::Result<(usize, Evaluation)> {
    let bytes = avatar.write();
    let read = Avatar::read(&bytes, &avatar.name)?;
    Ok((bytes.len(), evaluate(Arc::new(read), sequence, frames, || ())?))
}
