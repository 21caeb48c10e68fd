//! The paper's other ablations: how many anchors, which operator, how dense a mesh, how wide a neighbourhood, how smooth a base without f_l,
//! and whether near points weigh more.

mod neighbourhood;
mod reconstruction;
mod regulariser;
mod subdivided_body;

use super::{OptionRow, cell, option};
use crate::config::RunConfig;
use crate::evaluate::Measures;
use crate::frames::FrameRange;
use clap::ValueEnum;

/// What is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Study {
    /// Number of anchors of the reconstruction, in the relative and in the absolute form
    Anchors,
    /// Uniform angles against the cotangents of each frame's base
    Operator,
    /// Vertex density: no, one or two subdivisions
    Density,
    /// Neighbourhood of the quadratic fits
    Neighbourhood,
    /// λ_r of f_d on a mesh subdivided twice, without f_l
    Regulariser,
    /// Selective weighting of depth images, c = 2 against none
    Weighting,
}

impl Study {
    /// Its name for people, as it is given.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |name| name.get_name().to_owned())
    }
}

/// One line of the table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// What is varied.
    pub study: Study,
    /// Its value.
    pub value: String,
    /// The base mesh, where it is another than in the line before.
    pub base: Option<Measures>,
    /// The final mesh; none where there is nothing but the base.
    pub detailed: Option<Measures>,
    /// The final mesh of one frame, milliseconds on the mean of all that were measured; none where it was not timed.
    pub frame_ms: Option<f64>,
}

/// The runs that are varied, each with the same sequence first.
pub struct Runs<'a> {
    /// In compact form.
    pub compact: &'a RunConfig,
    /// In the paper's form.
    pub paper: &'a RunConfig,
    /// Frames of the first sequence that are measured.
    pub test: FrameRange,
}

/// Makes `studies` in their order. Each row is given to `each_row` as it is done.
pub fn paper(runs: &Runs, studies: &[Study], mut each_row: impl FnMut(&Row)) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for &study in studies {
        let mut add = |value: &str, base, detailed, frame_ms| {
            let row = Row { study, value: value.into(), base, detailed, frame_ms };
            each_row(&row);
            rows.push(row);
        };
        match study {
            Study::Anchors => reconstruction::anchors(runs, &mut add)?,
            Study::Operator => reconstruction::operators(runs, &mut add)?,
            Study::Density => of_option(runs, "level_count", &[("0", "×1"), ("1", "×4"), ("2", "×16")], &mut add)?,
            Study::Neighbourhood => neighbourhood::neighbourhoods(runs, &mut add)?,
            Study::Regulariser => regulariser::regularisers(runs, &mut add)?,
            Study::Weighting => of_option(runs, "nearness", &[("0", "c = 0"), ("2", "c = 2")], &mut add)?,
        }
    }
    Ok(rows)
}

/// Takes a row's value, base, detail and time.
type Add<'a> = dyn FnMut(&str, Option<Measures>, Option<Measures>, Option<f64>) + 'a;

/// The compact form with an option at each of `values`, which have names for people.
fn of_option(runs: &Runs, key: &str, values: &[(&str, &str)], add: &mut Add) -> anyhow::Result<()> {
    let settings: Vec<String> = values.iter().map(|&(value, _)| value.into()).collect();
    let mut names = values.iter().map(|&(_, name)| name);
    let report = |row: &OptionRow| {
        let evaluation = row.evaluation;
        add(names.next().unwrap_or_default(), Some(evaluation.base), Some(evaluation.detailed), None);
    };
    option(runs.compact, key, &settings, runs.test, report)?;
    Ok(())
}

/// The rows as a table for people, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let head = "| | | base, cm / cm / NC | final mesh, cm / cm / NC | a frame, ms |\n|---|---|---|---|---|\n";
    rows.iter().map(Row::line).fold(head.into(), |text, line| text + &line)
}

impl Row {
    /// The row's line of [`table`].
    pub fn line(&self) -> String {
        let study = self.study.name();
        let [base, detailed] = [self.base, self.detailed].map(|measures| measures.map_or_else(String::new, cell));
        let milliseconds = self.frame_ms.map_or_else(String::new, |time| format!("{time:.0}"));
        format!("| {study} | {} | {base} | {detailed} | {milliseconds} |\n", self.value)
    }
}
