//! Scans in, avatar out: by the paper's method at a width that a processor trains in seconds, and in compact form.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, open, write_sequence};
use crease::animate::{Options, Stage, animate};
use crease::avatar::Avatar;
use crease::network::SurfaceFunction;
use crease_trainer::ablation::{compact_against_plain, compact_table, fidelity};
use crease_trainer::context::{Sample, TrainContext};
use crease_trainer::evaluate::evaluate;
use crease_trainer::options::{FunctionForm, LaplacianTarget, NetworkOptions, TrainOptions};
use crease_trainer::plain::{Fit, PlainDeformation, PlainLaplacian};
use crease_trainer::progress::Progress;
use crease_trainer::train::{Facts, train};
use std::sync::Arc;

fn reduced() -> TrainOptions {
    let mut options = TrainOptions::paper();
    let network =
        |layer_count, epoch_count| NetworkOptions { layer_count, width: 32, learning_rate: 5e-3, epoch_count };
    options.frequency_count = 4;
    options.anchor_count = 200;
    options.texture_size = 64;
    options.deformation.network = network(5, 120);
    options.deformation.points_a_frame = 1_000;
    // The tiny body's edges are long, and so are its umbrella Laplacians.
    options.deformation.regulariser_weight = 0.1;
    options.laplacian.network = network(3, 10);
    options.laplacian.points_a_step = 1_000;
    options
}

fn context(directory: &Directory, options: TrainOptions) -> TrainContext {
    let body = write_sequence(&directory.0);
    let sequence = open(&directory.0).unwrap();
    let samples = (0..FRAME_COUNT).step_by(2).map(|frame| Sample { sequence: 0, frame }).collect();
    TrainContext::new(body, vec![sequence], samples, options, Progress::Silent).unwrap()
}

#[test]
fn the_paper_preset_makes_an_avatar_that_beats_the_body() {
    let directory = Directory::new("end-to-end");
    let mut context = context(&directory, reduced());
    let facts = Facts { name: "bumpy".into(), command: "a test".into(), preset: "paper".into(), notices: vec![] };
    let avatar = train(&mut context, &facts).unwrap();

    let bytes = avatar.write();
    let read = Avatar::read(&bytes, "bumpy.glb").unwrap();
    assert_eq!(read.provenance["sequences"][0]["licence"], "none needed");
    assert_eq!(read.provenance["sequences"][0]["frames"], serde_json::json!([0, 2, 4]));

    let sequence = &context.sequences[0];
    let mesh = animate(&read, &sequence.poses[3], &Options::default()).unwrap();
    assert!(mesh.positions.iter().all(|position| position.is_finite()));
    let base = animate(&read, &sequence.poses[3], &Options { stage: Stage::Base, ..Options::default() }).unwrap();
    let moved = mesh.positions.iter().zip(&base.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved > 1e-4, "the detail changes the surface");

    let unseen: Vec<usize> = (1..FRAME_COUNT).step_by(2).collect();
    let evaluation = evaluate(Arc::new(read), sequence, &unseen, 0.0, || ()).unwrap();
    let (body, detailed) = (evaluation.body, evaluation.detailed);
    assert!(body.scan_to_mesh_cm > 1.5, "the clothes stand off: {evaluation:?}");
    assert!(evaluation.base.scan_to_mesh_cm < 0.5 * body.scan_to_mesh_cm, "{evaluation:?}");
    assert!(detailed.scan_to_mesh_cm < 0.6 * body.scan_to_mesh_cm, "{evaluation:?}");
    assert!(detailed.mesh_to_scan_cm < 0.6 * body.mesh_to_scan_cm, "{evaluation:?}");
}

#[test]
fn the_compact_preset_beats_its_base_and_the_body() {
    let directory = Directory::new("compact");
    let mut options = TrainOptions::compact();
    options.anchor_count = 200;
    options.texture_size = 64;
    // Few points for each vertex of the tiny body: the data must outweigh the smoothing.
    options.compact.base_fit.smoothness = vec![3.0, 1.0];
    options.compact.detail_fit.smoothness = vec![1.0, 0.3];
    let mut context = context(&directory, options);
    let facts = Facts { name: "bumpy".into(), command: "a test".into(), preset: "compact".into(), notices: vec![] };
    let bytes = train(&mut context, &facts).unwrap().write();
    assert_eq!(train(&mut context, &facts).unwrap().write(), bytes, "the same input, the same file");
    let read = Avatar::read(&bytes, "bumpy.glb").unwrap();
    let SurfaceFunction::Compact(laplacian) = &read.laplacian else { panic!("tables were asked for") };
    assert_eq!(laplacian.level, 1);

    let sequence = &context.sequences[0];
    let unseen: Vec<usize> = (1..FRAME_COUNT).step_by(2).collect();
    let evaluation = evaluate(Arc::new(read), sequence, &unseen, 0.0, || ()).unwrap();
    let (body, base, detailed) = (evaluation.body, evaluation.base, evaluation.detailed);
    // Between three poses that are far from each other the smooth part says most, and a tenth of it is held back.
    assert!(base.scan_to_mesh_cm < 0.4 * body.scan_to_mesh_cm, "{evaluation:?}");
    assert!(base.mesh_to_scan_cm < 0.4 * body.mesh_to_scan_cm, "{evaluation:?}");
    assert!(base.nc > body.nc, "{evaluation:?}");
    assert!(detailed.scan_to_mesh_cm < base.scan_to_mesh_cm, "{evaluation:?}");
    assert!(detailed.nc > base.nc - 0.002, "{evaluation:?}");
}

#[test]
fn more_basis_functions_cost_bytes_and_networks_cost_most() {
    let directory = Directory::new("ablation");
    let mut options = TrainOptions::compact();
    options.anchor_count = 200;
    options.texture_size = 64;
    options.compact.deformation.wide.basis_count = 0;
    for network in [&mut options.deformation.network, &mut options.laplacian.network] {
        (network.width, network.epoch_count, network.learning_rate) = (32, 60, 5e-3);
    }
    options.frequency_count = 4;
    options.laplacian.points_a_step = 500;
    let mut context = context(&directory, options);
    let sequence = context.sequences[0].clone();
    let mut seen = 0;
    let rows = compact_against_plain(&mut context, &[1, 2], &sequence, &[1], |_| seen += 1).unwrap();
    assert_eq!((rows.len(), seen), (4, 4));
    assert!(rows[0].bytes < rows[1].bytes && rows[1].bytes < rows[3].bytes, "{rows:?}");
    let [two, plain] = [&rows[1], &rows[2]].map(|row| row.evaluation.unwrap());
    assert!(plain.base.scan_to_mesh_cm < 0.4 * plain.body.scan_to_mesh_cm, "networks learn the fits: {plain:?}");
    assert!(plain.detailed.scan_to_mesh_cm < 3.0 * two.detailed.scan_to_mesh_cm, "{plain:?} {two:?}");
    assert!(rows[3].evaluation.is_none());
    let text = compact_table(&rows);
    assert!(text.lines().count() == 6 && text.contains("plain 5 × 600, 3 × 800"), "{text}");
}

#[test]
fn every_part_of_the_method_has_its_line() {
    let directory = Directory::new("fidelity");
    let small = |mut options: TrainOptions| {
        options.anchor_count = 200;
        options.texture_size = 64;
        options.frequency_count = 4;
        options.laplacian.points_a_step = 1_000;
        for network in [&mut options.deformation.network, &mut options.laplacian.network] {
            *network = NetworkOptions { layer_count: 3, width: 16, learning_rate: 5e-3, epoch_count: 8 };
        }
        options
    };
    let context = context(&directory, small(TrainOptions::compact()));
    let paper = TrainContext::new(
        context.body.clone(),
        context.sequences.clone(),
        context.samples.clone(),
        small(TrainOptions::paper()),
        Progress::Silent,
    );
    let rows = fidelity(&context, Some(&mut paper.unwrap()), &[1, 3], |_| ()).unwrap();
    let named = |name: &str| rows.iter().find(|row| row.name == name).unwrap().measures;
    let (body, base) = (named("body"), named("base"));
    let [displaced, compact] = ["displacement in place of f_l", "detailed, compact"].map(named);
    assert!(base.scan_to_mesh_cm < 0.4 * body.scan_to_mesh_cm, "{rows:?}");
    for detailed in [displaced, compact] {
        assert!(detailed.scan_to_mesh_cm < 1.1 * base.scan_to_mesh_cm && detailed.nc > base.nc - 0.01, "{rows:?}");
    }
    // Two ways to say the same fits, of which one goes through the solver.
    assert_ne!(displaced, compact);
    assert!((displaced.nc - compact.nc).abs() < 0.02, "{rows:?}");
    for name in ["base, plain", "detailed, plain", "base, the paper's form", "detailed, the paper's form"] {
        assert!(named(name).nc.is_finite());
    }
    assert_eq!(rows.len(), 8);
}

#[test]
fn plain_networks_learn_operator_laplacians_and_tables_need_them() {
    let directory = Directory::new("fitted");
    let mut options = TrainOptions { function: FunctionForm::Plain, ..TrainOptions::compact() };
    options.deformation.network = NetworkOptions { layer_count: 3, width: 16, learning_rate: 5e-3, epoch_count: 2 };
    options.laplacian.network = options.deformation.network.clone();
    options.texture_size = 64;
    let mut context = context(&directory, options);
    let facts = Facts { name: "bumpy".into(), ..Facts::default() };
    let avatar = train(&mut context, &facts).unwrap();
    assert!(matches!(avatar.deformation, SurfaceFunction::Mlp(_)));
    let SurfaceFunction::Mlp(laplacian) = &avatar.laplacian else { panic!("a network was asked for") };
    assert_eq!(laplacian.level, 1, "the level of the tables");
    context.options.function = FunctionForm::Compact;
    context.options.target = LaplacianTarget::Quadratic;
    let message = train(&mut context, &facts).unwrap_err().to_string();
    assert!(message.contains("target: expected operator"), "{message}");
}

#[test]
fn losses_fall_and_a_seed_decides() {
    let directory = Directory::new("losses");
    let mut context = context(&directory, reduced());
    context.options.deformation.network.epoch_count = 30;
    context.options.laplacian.network.epoch_count = 4;
    let Fit { network: deformation, energies, poses } = PlainDeformation.fit(&context).unwrap();
    assert!(energies[29] < 0.6 * energies[0], "{energies:?}");
    assert!(poses.is_none());
    let again = PlainDeformation.fit(&context).unwrap().network;
    assert_eq!(deformation, again, "the same seed, the same weights");
    let function = SurfaceFunction::Mlp(deformation);
    let (_, detail_history) = PlainLaplacian.fit(&context, &function).unwrap();
    assert!(detail_history[3] < 0.95 * detail_history[0], "{detail_history:?}");
    // Where nothing stays in memory f_d sees the same, and f_l one frame after the other.
    context.options.memory_mib = 0;
    assert_eq!(SurfaceFunction::Mlp(PlainDeformation.fit(&context).unwrap().network), function);
    let (_, streamed_history) = PlainLaplacian.fit(&context, &function).unwrap();
    assert!(streamed_history[3] < 0.95 * streamed_history[0], "{streamed_history:?}");
    assert_ne!(streamed_history, detail_history);
    context.options.seed = 1;
    assert_ne!(SurfaceFunction::Mlp(PlainDeformation.fit(&context).unwrap().network), function);
}
