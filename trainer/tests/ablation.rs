//! The paper's ablations on a small made sequence: every study has its lines, and what is varied tells.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, write_body_model, write_sequence};
use crease_trainer::ablation::{PaperRow, PaperRuns, Study, paper, paper_table};
use crease_trainer::config::{ChosenFrames, RunConfig};
use crease_trainer::options::{NetworkOptions, TrainOptions};
use crease_trainer::sequence::Reading;

/// Makes one study of training on frames 0, 2 and 4, measured on frame 1.
fn rows(study: Study, change: fn(&mut TrainOptions)) -> Vec<PaperRow> {
    let directory = Directory::new(&format!("paper-{}", study.name()));
    let sequence = directory.0.join("bumpy");
    let body = write_sequence(&sequence);
    write_body_model(&directory.0.join("body.npz"), &body);
    let config = |mut options: TrainOptions| {
        options.texture_size = 16;
        options.frequency_count = 4;
        options.compact.base_fit.smoothness = vec![3.0, 1.0];
        options.compact.detail_fit.smoothness = vec![1.0, 0.3];
        options.deformation.points_a_frame = 1_000;
        options.laplacian.points_a_step = 1_000;
        for network in [&mut options.deformation.network, &mut options.laplacian.network] {
            *network = NetworkOptions { layer_count: 3, width: 16, learning_rate: 5e-3, epoch_count: 8 };
        }
        change(&mut options);
        RunConfig {
            output: "bumpy.glb".into(),
            body: Some(directory.0.join("body.npz")),
            name: None,
            preset: "compact".into(),
            sequences: vec![ChosenFrames {
                directory: sequence.clone(),
                poses: None,
                reading: Reading::default(),
                frames: "0::2".parse().unwrap(),
            }],
            options,
        }
    };
    let (compact, own) = (config(TrainOptions::compact()), config(TrainOptions::paper()));
    let mut told = 0;
    let runs = PaperRuns { compact: &compact, paper: &own, test: "1:2".parse().unwrap() };
    let rows = paper(&runs, &[study], |_| told += 1).unwrap();
    assert_eq!(told, rows.len());
    assert_eq!(paper_table(&rows).matches(&study.name()).count(), rows.len());
    rows
}

fn distance(row: &PaperRow) -> f64 {
    row.detailed.or(row.base).unwrap().scan_to_mesh_cm
}

#[test]
fn few_anchors_let_the_absolute_form_drift() {
    let rows = rows(Study::Anchors, |_| ());
    let (relative, absolute) = rows.split_at(6);
    assert!(absolute[0].value.contains("100, absolute"), "{rows:?}");
    assert!(distance(&absolute[0]) > 1.02 * distance(&absolute[5]), "{rows:?}");
    // With many anchors the absolute form, whose mean is in f_l alone, comes as close.
    assert!(distance(&absolute[5]) < 1.1 * distance(&relative[5]), "{rows:?}");
    let apart = |rows: &[PaperRow]| distance(&rows[0]) - distance(&rows[5]);
    assert!(apart(relative).abs() < 0.5 * apart(absolute), "{rows:?}");
}

#[test]
fn both_operators_come_close() {
    let rows = rows(Study::Operator, |_| ());
    let [uniform, cotangent] = &rows[..] else { panic!("two operators: {rows:?}") };
    let (base, uniform_detail, cotangent_detail) =
        (uniform.base.unwrap(), uniform.detailed.unwrap(), cotangent.detailed.unwrap());
    assert_ne!(uniform_detail, cotangent_detail);
    assert!((uniform_detail.nc - cotangent_detail.nc).abs() < 0.01, "{rows:?}");
    for detailed in [uniform_detail, cotangent_detail] {
        assert!(detailed.scan_to_mesh_cm < 1.05 * base.scan_to_mesh_cm, "{rows:?}");
    }
    assert!(rows.iter().all(|row| row.frame_ms.is_some_and(|time| time > 0.0)));
}

#[test]
fn a_denser_mesh_has_truer_normals() {
    let rows = rows(Study::Density, |_| ());
    assert_eq!(rows.iter().map(|row| row.value.as_str()).collect::<Vec<_>>(), ["×1", "×4", "×16"]);
    let consistency = [0, 1, 2].map(|row: usize| rows[row].detailed.unwrap().nc);
    assert!(consistency.is_sorted() && consistency[2] > consistency[0] + 0.003, "{rows:?}");
}

#[test]
fn a_wide_neighbourhood_is_another_than_a_narrow_one() {
    let rows = rows(Study::Neighbourhood, |_| ());
    assert_eq!(rows.len(), 6);
    assert!(rows[0].base.is_some() && rows[1..].iter().all(|row| row.base.is_none()), "one base for all");
    for pair in rows.windows(2) {
        assert_ne!(pair[0].detailed, pair[1].detailed, "{rows:?}");
    }
}

#[test]
fn a_strong_regulariser_holds_a_dense_base_back() {
    let rows = rows(Study::Regulariser, |options| options.deformation.network.epoch_count = 40);
    assert_eq!(rows.len(), 6);
    assert!(distance(&rows[5]) > 1.2 * distance(&rows[1]), "{rows:?}");
}
