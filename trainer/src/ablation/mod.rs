//! Choices of the method varied one by one, and what each does to the result.

mod compact;
mod fidelity;
mod option;
mod paper;

pub use compact::{Row as CompactRow, compact_against_plain, table as compact_table};
pub use fidelity::{Row as FidelityRow, fidelity, table as fidelity_table};
pub use option::{Row as OptionRow, option, table as option_table};
pub use paper::{Row as PaperRow, Runs as PaperRuns, Study, paper, table as paper_table};

use crate::appearance::bake;
use crate::compact::{CompactDeformation, CompactLaplacian, View};
use crate::context::TrainContext;
use crate::evaluate::{Evaluation, Measures, evaluate};
use crate::plain::{FittedDeformation, FittedLaplacian};
use crate::sequence::Sequence;
use crate::train::{Facts, assemble};
use crease::avatar::{Appearance, Avatar};
use crease::network::SurfaceFunction;
use glam::Vec3A;
use std::sync::Arc;

/// What is fitted once, however often it is learned from.
struct Fits {
    /// Canonical offsets of the base in every training frame, metres.
    offsets: Vec<Vec<Vec3A>>,
    /// f_d of them.
    deformation: SurfaceFunction,
    /// The finest mesh of every training frame, metres.
    surfaces: Vec<View>,
    appearance: Appearance,
}

impl Fits {
    fn new(context: &TrainContext) -> anyhow::Result<Self> {
        let offsets = CompactDeformation.fit(context)?;
        let deformation = SurfaceFunction::Compact(CompactDeformation.regress(context, &offsets)?);
        let surfaces = CompactLaplacian.fit_surfaces(context, &deformation)?;
        let appearance = bake(context, &deformation)?;
        Ok(Self { offsets, deformation, surfaces, appearance })
    }
}

/// An avatar of plain networks that learn the same fits as the tables: `offsets` of the base, and `surfaces`.
fn plain_avatar(
    context: &TrainContext,
    facts: &Facts,
    offsets: &[Vec<Vec3A>],
    surfaces: &[View],
    appearance: Appearance,
) -> anyhow::Result<Avatar> {
    let deformation = SurfaceFunction::Mlp(FittedDeformation.regress(context, offsets)?);
    let deltas = CompactLaplacian.measure(context, &deformation, surfaces)?;
    let laplacian = SurfaceFunction::Mlp(FittedLaplacian.regress(context, &deltas)?);
    assemble(context, facts, deformation, laplacian, appearance)
}

/// Measures as a cell of a table: cm / cm / NC.
fn cell(Measures { scan_to_mesh_cm, mesh_to_scan_cm, nc }: Measures) -> String {
    format!("{scan_to_mesh_cm:.3} / {mesh_to_scan_cm:.3} / {nc:.4}")
}

/// Bytes of an avatar's file, and how close what is read from it comes.
fn measured_avatar(avatar: &Avatar, sequence: &Sequence, frames: &[usize]) -> anyhow::Result<(usize, Evaluation)> {
    let bytes = avatar.write();
    let read = Avatar::read(&bytes, &avatar.name)?;
    Ok((bytes.len(), evaluate(Arc::new(read), sequence, frames, 0.0, || ())?))
}
