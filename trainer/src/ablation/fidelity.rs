//! What each part of the method buys: body, base, displacements in place of Laplacians, detail in compact and in plain form, the paper's form.

use super::{Fits, measured_avatar, plain_avatar};
use crate::compact::{CompactDisplacement, CompactLaplacian};
use crate::context::{Sample, TrainContext};
use crate::evaluate::{Measures, evaluate_meshes};
use crate::train::{Facts, assemble, train};
use crease::network::SurfaceFunction;

/// One line of the table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// What was measured.
    pub name: String,
    /// How close it came.
    pub measures: Measures,
}

/// Trains on `context`'s frames and measures on `frames` of its first sequence. Fits and tables are as its options say; plain networks too,
/// unless they have no epochs. `paper` is a context of the paper's options, or none to leave that out. Each row is given to `each_row` as it
/// is done.
pub fn fidelity(
    context: &TrainContext,
    paper: Option<&mut TrainContext>,
    frames: &[usize],
    mut each_row: impl FnMut(&Row),
) -> anyhow::Result<Vec<Row>> {
    let sequence = &context.sequences[0];
    let facts = Facts { name: sequence.capture.name.clone(), preset: "compact".into(), ..Facts::default() };
    let mut rows = Vec::new();
    let mut add = |name: &str, measures: Measures| {
        let row = Row { name: name.into(), measures };
        each_row(&row);
        rows.push(row);
    };

    let Fits { offsets, deformation, surfaces, appearance } = Fits::new(context)?;
    let deltas = CompactLaplacian.measure(context, &deformation, &surfaces)?;
    let laplacian = SurfaceFunction::Compact(CompactLaplacian.regress(context, &deltas)?);
    let avatar = assemble(context, &facts, deformation.clone(), laplacian, appearance.clone())?;
    let evaluation = measured_avatar(&avatar, sequence, frames)?.1;
    add("body", evaluation.body);
    add("base", evaluation.base);
    add("displacement in place of f_l", {
        let displacements = CompactDisplacement.measure(context, &deformation, &surfaces)?;
        let displacement = SurfaceFunction::Compact(CompactDisplacement.regress(context, &displacements)?);
        let triangles = context.subdivision.triangles(context.level_count());
        evaluate_meshes(sequence, frames, triangles, |frame| {
            Ok(CompactDisplacement.surface(context, &deformation, &displacement, Sample { sequence: 0, frame }))
        })?
    });
    add("detailed, compact", evaluation.detailed);
    if context.options.deformation.network.epoch_count > 0 {
        let avatar = plain_avatar(context, &facts, &offsets, &surfaces, appearance)?;
        let evaluation = measured_avatar(&avatar, sequence, frames)?.1;
        add("base, plain", evaluation.base);
        add("detailed, plain", evaluation.detailed);
    }
    if let Some(paper) = paper {
        let evaluation = measured_avatar(&train(paper, &facts)?, sequence, frames)?.1;
        add("base, the paper's form", evaluation.base);
        add("detailed, the paper's form", evaluation.detailed);
    }
    Ok(rows)
}

/// The rows as a table for people, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let head = "| | scan→mesh, cm | mesh→scan, cm | NC |\n|---|---|---|---|\n";
    rows.iter().map(Row::line).fold(head.into(), |text, line| text + &line)
}

impl Row {
    /// The row's line of [`table`].
    pub fn line(&self) -> String {
        let Measures { scan_to_mesh_cm, mesh_to_scan_cm, nc } = self.measures;
        format!("| {} | {scan_to_mesh_cm:.3} | {mesh_to_scan_cm:.3} | {nc:.4} |\n", self.name)
    }
}
