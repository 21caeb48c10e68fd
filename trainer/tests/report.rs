//! A whole training from the command line, small, with the page about it at its end.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, write_body_model, write_sequence};
use crease_trainer::sequence::{Up, read_body};
use std::fs;
use std::process::{Command, Output};

const SMALL: [&str; 5] = [
    "anchor_count=100",
    "texture_size=32",
    "compact.coarse_fit.smoothness=[60]",
    "compact.base_fit.smoothness=[3, 1]",
    "compact.detail_fit.smoothness=[1]",
];

/// A small training on a made sequence, in a folder of its own, and what it said.
fn trained(name: &str, arguments: &[&str]) -> (Directory, Output) {
    let directory = Directory::new(name);
    let body = write_sequence(&directory.0.join("bumpy"));
    write_body_model(&directory.0.join("body.npz"), &body);
    let output = Command::new(env!("CARGO_BIN_EXE_crease"))
        .args(["train", "bumpy", "--body", "body.npz"])
        .args(arguments)
        .args(SMALL.iter().flat_map(|assignment| ["--set", assignment]))
        .current_dir(&directory.0)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (directory, output)
}

#[test]
fn a_training_ends_with_its_report() {
    let (directory, output) = trained("train-report", &["-o", "bumpy.glb", "--frames", "0::2", "--report", "--json"]);
    for written in ["bumpy.glb", "bumpy.toml", "bumpy.csv"] {
        assert!(directory.0.join(written).exists(), "{written}");
    }
    let page = fs::read_to_string(directory.0.join("bumpy.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("3 frames, against the ground truth"));
    // The run's own log, its options, and the command that trains it again.
    for part in ["By part of the body", "How it was made", "<th>f_d</th>", "anchor_count = 100", "crease train bumpy"] {
        assert!(page.contains(part), "{part}");
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let last: serde_json::Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert_eq!(last["report"], "bumpy.html");
    let of = |stage: &str| last["evaluation"][stage]["scan_to_mesh_cm"].as_f64().unwrap();
    assert!(of("detailed") < 0.5 * of("body"), "{last}");
    assert_eq!(last["evaluation"]["frames"], 3);
}

#[test]
fn refined_poses_lie_beside_the_avatar_and_the_report_takes_them() {
    let (directory, _) = trained("train-refine", &["-o", "out/a.glb", "--refine", "--report", "--quiet"]);
    let refined = read_body(&directory.0.join("out/a-bumpy.npz")).unwrap();
    assert_eq!((refined.parameters.poses.len(), refined.up), (FRAME_COUNT, Some(Up::Y)));
    let run = fs::read_to_string(directory.0.join("out/a.toml")).unwrap();
    assert!(run.contains("[options.refinement]\nround_count = 2"), "{run}");
    assert!(directory.0.join("out/a.html").exists());
}
