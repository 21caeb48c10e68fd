//! What the number of basis functions buys and costs, and what plain networks of the paper's size cost beside it.

use crate::appearance::bake;
use crate::compact::{CompactDeformation, CompactLaplacian};
use crate::context::TrainContext;
use crate::evaluate::{Evaluation, Measures, evaluate};
use crate::options::TrainOptions;
use crate::sequence::Sequence;
use crate::train::{Facts, assemble};
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::mesh::Subdivision;
use crease::network::{Domain, Layer, Mlp, Scratch, SurfaceFunction};
use glam::Vec3A;
use rand::{RngExt, SeedableRng};
use std::sync::Arc;
use std::time::Instant;

/// One line of the comparison.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// `compact`, or `plain` with its widths.
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

/// Trains `context`'s compact form with each of `basis_counts`, the base's fits shared, and measures on `frames` of `sequence`. The last row
/// is an avatar with untrained networks of the paper's widths: its size and cost do not depend on the weights.
pub fn compact_against_plain(
    context: &mut TrainContext,
    basis_counts: &[usize],
    sequence: &Sequence,
    frames: &[usize],
) -> anyhow::Result<Vec<Row>> {
    let facts = Facts { name: sequence.name.clone(), preset: "compact".into(), ..Facts::default() };
    let pose = context.pose(context.samples[0]).clone();
    let offsets = CompactDeformation.fit(context)?;
    let mut appearance = None;
    let mut rows = Vec::new();
    let mut last = None;
    for &basis_count in basis_counts {
        context.options.compact.deformation.narrow.basis_count = basis_count;
        context.options.compact.laplacian.narrow.basis_count = basis_count;
        let deformation = SurfaceFunction::Compact(CompactDeformation.regress(context, &offsets));
        let targets = CompactLaplacian.fit(context, &deformation)?;
        let laplacian = SurfaceFunction::Compact(CompactLaplacian.regress(context, &targets));
        if appearance.is_none() {
            appearance = Some(bake(context, &deformation)?);
        }
        let avatar = assemble(context, &facts, deformation, laplacian, appearance.clone().expect("baked"))?;
        let bytes = avatar.write();
        let avatar = Avatar::read(&bytes, &facts.name)?;
        rows.push(Row {
            form: "compact".into(),
            basis_count: Some(basis_count),
            bytes: bytes.len(),
            frame_ms: frame_ms(&avatar, &pose),
            evaluation: Some(evaluate(Arc::new(avatar.clone()), sequence, frames, || ())?),
        });
        last = Some(avatar);
    }
    rows.extend(last.map(|avatar| plain_row(avatar, &pose)));
    Ok(rows)
}

/// The same avatar with networks of the paper's widths.
fn plain_row(avatar: Avatar, pose: &Pose) -> Row {
    let paper = TrainOptions::paper();
    let (base, detail) = (&paper.deformation.network, &paper.laplacian.network);
    let plain = Avatar {
        deformation: SurfaceFunction::Mlp(random_network(0, base.layer_count, base.width, paper.frequency_count)),
        laplacian: SurfaceFunction::Mlp(random_network(
            avatar.level_count,
            detail.layer_count,
            detail.width,
            paper.frequency_count,
        )),
        ..avatar
    };
    Row {
        form: format!("plain {} × {}, {} × {}", base.layer_count, base.width, detail.layer_count, detail.width),
        basis_count: None,
        bytes: plain.write().len(),
        frame_ms: frame_ms(&plain, pose),
        evaluation: None,
    }
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
    let domains = Domain::levels(&avatar.canonical, &avatar.rig.skin, &subdivision);
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
    let mut text = String::from(
        "| form | K | MB | f_d + f_l, ms | base, cm / cm / NC | detailed, cm / cm / NC |\n|---|---|---|---|---|---|\n",
    );
    let measures = |m: Measures| format!("{:.3} / {:.3} / {:.4}", m.scan_to_mesh_cm, m.mesh_to_scan_cm, m.nc);
    for row in rows {
        let basis_count = row.basis_count.map_or("".into(), |count| count.to_string());
        let [base, detailed] = match &row.evaluation {
            Some(evaluation) => [measures(evaluation.base), measures(evaluation.detailed)],
            None => ["not trained".into(), "not trained".into()],
        };
        let megabytes = row.bytes as f64 / 1e6;
        text +=
            &format!("| {} | {basis_count} | {megabytes:.2} | {:.2} | {base} | {detailed} |\n", row.form, row.frame_ms);
    }
    text
}
