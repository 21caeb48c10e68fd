//! One option of training at several values.

use super::{cell, measured_avatar};
use crate::config::RunConfig;
use crate::evaluate::Evaluation;
use crate::frames::FrameRange;
use crate::progress::Progress;
use crate::refinement::refine_poses;
use crate::train::{Facts, train};
use std::time::Instant;

/// Training with one value.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// The option's value, as it was given.
    pub value: String,
    /// The whole file.
    pub bytes: usize,
    /// Of training, all stages.
    pub seconds: f64,
    /// How close it came.
    pub evaluation: Evaluation,
}

/// Trains as `config` says but for the option `key`, which takes each of `values`, and measures on `frames` of the first sequence. Each row
/// is given to `each_row` as it is done.
pub fn option(
    config: &RunConfig,
    key: &str,
    values: &[String],
    frames: FrameRange,
    mut each_row: impl FnMut(&Row),
) -> anyhow::Result<Vec<Row>> {
    // All of them are looked at before any of them takes its time.
    let all = values.iter().map(|value| Ok((value, config.options.with(&format!("{key}={value}"))?)));
    let mut rows = Vec::new();
    for (value, options) in all.collect::<anyhow::Result<Vec<_>>>()? {
        let begin = Instant::now();
        let mut context = RunConfig { options, ..config.clone() }.prepare(Progress::Bars)?;
        refine_poses(&mut context)?;
        let name = context.sequences[0].capture.name.clone();
        let facts = Facts { name, preset: config.preset.clone(), ..Facts::default() };
        let avatar = train(&mut context, &facts)?;
        let seconds = begin.elapsed().as_secs_f64();
        let sequence = &context.sequences[0];
        let frames = frames.indices(sequence.capture.frame_count)?;
        let (bytes, evaluation) = measured_avatar(&avatar, sequence, &frames)?;
        let row = Row { value: value.clone(), bytes, seconds, evaluation };
        each_row(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// The rows as a table for people, in Markdown.
pub fn table(key: &str, rows: &[Row]) -> String {
    let head =
        format!("| {key} | MB | seconds | base, cm / cm / NC | detailed, cm / cm / NC |\n|---|---|---|---|---|\n");
    rows.iter().map(Row::line).fold(head, |text, line| text + &line)
}

impl Row {
    /// The row's line of [`table`].
    pub fn line(&self) -> String {
        let [base, detailed] = [self.evaluation.base, self.evaluation.detailed].map(cell);
        format!("| {} | {:.2} | {:.0} | {base} | {detailed} |\n", self.value, self.bytes as f64 / 1e6, self.seconds)
    }
}
