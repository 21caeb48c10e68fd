//! What the number of basis functions buys and costs, and plain networks beside it.

use super::{cell, measured_avatar, plain_avatar};
use crate::appearance::bake;
use crate::compact::{CompactDeformation, CompactLaplacian};
use crate::context::TrainContext;
use crate::evaluate::Evaluation;
use crate::options::TrainOptions;
use crate::sequence::Sequence;
use crate::train::{Facts, assemble};
use anyhow::Context;
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::mesh::Subdivision;
use crease::network::{Domain, Layer, Mlp, Scratch, SurfaceFunction};
use glam::Vec3A;
use rand::{RngExt, SeedableRng};
use std::time::Instant;

/// One line of the comparison.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// `compact`, or `plain` with its layers and widths.
    pub form: String,
    /// K of the narrow parts of f_d and f_l; none for networks.
    pub basis_count: Option<usize>,
    /// The whole file.
    pub bytes: usize,
    /// f_d and f_l together, milliseconds a frame: native, one thread, the least of several frames.
    pub frame_ms: f64,
    /// Fidelity; none where the networks were not trained.
    pub evaluation: Option<Evaluation>,
}

/// Fits `context`'s scans once, makes the compact form of the fits with each of `basis_counts` and plain networks as `context.options` say
/// (unless they have no epochs), and measures all on `frames` of `sequence`. Each row is given to `each_row` as it is done. The last one is
/// an avatar with untrained networks of the paper's widths: its size and cost do not depend on the weights.
pub fn compact_against_plain(
    context: &mut TrainContext,
    basis_counts: &[usize],
    sequence: &Sequence,
    frames: &[usize],
    mut each_row: impl FnMut(&Row),
) -> anyhow::Result<Vec<Row>> {
    let facts = Facts { name: sequence.capture.name.clone(), preset: "compact".into(), ..Facts::default() };
    let pose = context.pose(context.samples[0]).clone();
    let mut rows = Vec::new();
    let mut add = |row: Row| {
        each_row(&row);
        rows.push(row);
    };
    let measured = |form: String, basis_count: Option<usize>, avatar: Avatar| -> anyhow::Result<Row> {
        let (bytes, evaluation) = measured_avatar(&avatar, sequence, frames)?;
        Ok(Row { form, basis_count, bytes, frame_ms: frame_ms(&avatar, &pose), evaluation: Some(evaluation) })
    };

    let largest = *basis_counts.iter().max().context("counts: expected at least one, found none")?;
    let offsets = CompactDeformation.fit(context)?;
    set_basis_count(context, largest);
    let deformation = SurfaceFunction::Compact(CompactDeformation.regress(context, &offsets)?);
    let surfaces = CompactLaplacian.fit_surfaces(context, &deformation)?;
    let appearance = bake(context, &deformation)?;
    for &basis_count in basis_counts {
        set_basis_count(context, basis_count);
        let deformation = SurfaceFunction::Compact(CompactDeformation.regress(context, &offsets)?);
        let deltas = CompactLaplacian.measure(context, &deformation, &surfaces)?;
        let laplacian = SurfaceFunction::Compact(CompactLaplacian.regress(context, &deltas)?);
        let avatar = assemble(context, &facts, deformation, laplacian, appearance.clone())?;
        add(measured("compact".into(), Some(basis_count), avatar)?);
    }
    if context.options.deformation.network.epoch_count > 0 {
        let avatar = plain_avatar(context, &facts, &offsets, &surfaces, appearance.clone())?;
        add(measured(plain_form(&context.options), None, avatar)?);
    }
    let [deformation, laplacian] = networks_of_the_papers_widths(context.level_count() as u32);
    let avatar = assemble(context, &facts, deformation, laplacian, appearance)?;
    add(Row {
        form: plain_form(&TrainOptions::paper()),
        basis_count: None,
        bytes: avatar.write().len(),
        frame_ms: frame_ms(&avatar, &pose),
        evaluation: None,
    });
    Ok(rows)
}

fn set_basis_count(context: &mut TrainContext, basis_count: usize) {
    context.options.compact.deformation.narrow.basis_count = basis_count;
    context.options.compact.laplacian.narrow.basis_count = basis_count;
}

fn plain_form(options: &TrainOptions) -> String {
    let (base, detail) = (&options.deformation.network, &options.laplacian.network);
    format!("plain {} × {}, {} × {}", base.layer_count, base.width, detail.layer_count, detail.width)
}

fn networks_of_the_papers_widths(finest: u32) -> [SurfaceFunction; 2] {
    let paper = TrainOptions::paper();
    [(0, paper.deformation.network), (finest, paper.laplacian.network)].map(|(level, network)| {
        SurfaceFunction::Mlp(random_network(level, network.layer_count, network.width, paper.frequency_count))
    })
}

fn random_network(level: u32, layer_count: usize, width: usize, frequency_count: u32) -> Mlp {
    let encoding = PositionalEncoding { frequency_count };
    let mut random = rand_pcg::Pcg32::seed_from_u64(u64::from(level));
    let mut numbers = |count: usize| (0..count).map(|_| random.random_range(-0.05f32..0.05)).collect::<Vec<_>>();
    let mut widths = vec![width; layer_count + 1];
    widths[0] = encoding.length() + 3 * 24;
    widths[layer_count] = 3;
    let layers = widths.windows(2).map(|pair| Layer { weight: numbers(pair[0] * pair[1]), bias: numbers(pair[1]) });
    Mlp { level, encoding, layers: layers.collect(), output_scale: 1.0 }
}

/// The least of five evaluations of f_d and f_l.
fn frame_ms(avatar: &Avatar, pose: &Pose) -> f64 {
    let subdivision = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, avatar.level_count as usize);
    let domains = Domain::levels(&avatar.canonical, &avatar.rig.skin, &subdivision, subdivision.level_count());
    let mut scratch = Scratch::default();
    let functions = [&avatar.deformation, &avatar.laplacian];
    let mut values = functions.map(|function| vec![Vec3A::ZERO; subdivision.vertex_count(function.level())]);
    let mut evaluate = || {
        let begin = Instant::now();
        for (function, values) in functions.iter().zip(&mut values) {
            function.evaluate(&domains[function.level()], pose, &mut scratch, values);
        }
        1e3 * begin.elapsed().as_secs_f64()
    };
    (0..5).map(|_| evaluate()).fold(f64::INFINITY, f64::min)
}

/// The rows as a table for people, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let head =
        "| form | K | MB | f_d + f_l, ms | base, cm / cm / NC | detailed, cm / cm / NC |\n|---|---|---|---|---|---|\n";
    rows.iter().map(Row::line).fold(head.into(), |text, line| text + &line)
}

impl Row {
    /// The row's line of [`table`].
    pub fn line(&self) -> String {
        let basis_count = self.basis_count.map_or("".into(), |count| count.to_string());
        let [base, detailed] = match &self.evaluation {
            Some(evaluation) => [cell(evaluation.base), cell(evaluation.detailed)],
            None => ["not trained".into(), "not trained".into()],
        };
        let megabytes = self.bytes as f64 / 1e6;
        format!("| {} | {basis_count} | {megabytes:.2} | {:.2} | {base} | {detailed} |\n", self.form, self.frame_ms)
    }
}
