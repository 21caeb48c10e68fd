//! A run that is broken off and taken up again gives what an undisturbed one gives, bit for bit.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, open, write_sequence};
use crease_trainer::checkpoint::{Checkpoint, Keep};
use crease_trainer::context::{Sample, TrainContext};
use crease_trainer::interrupt::{Interrupt, Interrupted};
use crease_trainer::options::{NetworkOptions, TrainOptions};
use crease_trainer::progress::Progress;
use crease_trainer::refinement::refine_poses;
use crease_trainer::train::{Facts, train};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn small(mut options: TrainOptions) -> TrainOptions {
    let network = |layer_count| NetworkOptions { layer_count, width: 8, learning_rate: 5e-3, epoch_count: 6 };
    options.frequency_count = 2;
    options.anchor_count = 50;
    options.texture_size = 16;
    options.deformation.network = network(3);
    options.deformation.frames_a_step = 2;
    options.deformation.points_a_frame = 200;
    options.laplacian.network = network(3);
    options.laplacian.points_a_step = 3_000;
    options.compact.coarse_fit.smoothness.truncate(1);
    options.compact.base_fit.smoothness.truncate(1);
    options.compact.detail_fit.smoothness.truncate(1);
    options
}

fn context(sequence: &Path, options: &TrainOptions) -> TrainContext {
    let body = crease::fixture::voxel_person();
    let sequence = open(sequence).unwrap();
    let samples = (0..FRAME_COUNT).map(|frame| Sample { sequence: 0, frame }).collect();
    TrainContext::new(body, vec![sequence], samples, options.clone(), Progress::Silent).unwrap()
}

/// Refines poses where the options ask for it, and trains.
fn avatar(mut context: TrainContext) -> anyhow::Result<Vec<u8>> {
    let facts = Facts { name: "bumpy".into(), ..Facts::default() };
    refine_poses(&mut context)?;
    let bytes = train(&mut context, &facts)?.write();
    // Refined poses are as much a result as the file is.
    let poses = context.sequences[0].poses.iter().flat_map(|pose| pose.to_bytes());
    Ok(bytes.into_iter().chain(poses).collect())
}

fn with_checkpoint(sequence: &Path, options: &TrainOptions, directory: &Path, interrupt: &Interrupt) -> TrainContext {
    let mut context = context(sequence, options);
    context.checkpoint = Checkpoint::open(directory, Duration::ZERO, interrupt.clone()).unwrap();
    context
}

/// Asks to stop as soon as `file` is there.
fn stop_at(file: PathBuf, interrupt: Interrupt) -> std::thread::JoinHandle<()> {
    std::thread::spawn(move || {
        while !file.exists() && !interrupt.is_set() {
            std::thread::sleep(Duration::from_millis(1));
        }
        interrupt.set();
    })
}

/// Breaks a run off at each of `files`, takes it up each time, and compares its end with that of an undisturbed one.
fn check(name: &str, options: &TrainOptions, files: &[&str]) {
    let scratch = Directory::new(name);
    let (sequence, kept) = (scratch.0.join("sequence"), scratch.0.join("kept"));
    write_sequence(&sequence);
    let undisturbed = avatar(context(&sequence, options)).unwrap();
    for file in files {
        let interrupt = Interrupt::default();
        let watcher = stop_at(kept.join(file), interrupt.clone());
        let result = avatar(with_checkpoint(&sequence, options, &kept, &interrupt));
        interrupt.set();
        watcher.join().unwrap();
        let error = result.map(|bytes| bytes.len()).expect_err("it was interrupted");
        assert!(error.is::<Interrupted>() && kept.join(file).exists(), "{file}: {error:#}");
    }
    // Files that a killed process or a bad disk left damaged are as good as none.
    for file in files {
        let damaged = kept.join(file);
        let mut bytes = fs::read(&damaged).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&damaged, bytes).unwrap();
    }
    let resumed = avatar(with_checkpoint(&sequence, options, &kept, &Interrupt::default())).unwrap();
    assert!(resumed == undisturbed, "the same bytes");
    // And what is complete is not trained again: an interrupt finds nothing left to stop.
    let interrupt = Interrupt::default();
    let context = with_checkpoint(&sequence, options, &kept, &interrupt);
    interrupt.set();
    assert!(avatar(context).is_ok_and(|again| again == undisturbed));
    // Other options are another run.
    let other = TrainOptions { seed: 7, ..options.clone() };
    let error = avatar(with_checkpoint(&sequence, &other, &kept, &interrupt)).unwrap_err();
    assert!(error.is::<Interrupted>(), "{error:#}");
}

#[test]
fn the_paper_preset_goes_on_after_any_step() {
    check("resume-paper", &small(TrainOptions::paper()), &["deformation.last", "targets-0-00000.result"]);
}

#[test]
fn frames_that_are_read_anew_each_time_change_nothing_of_that() {
    let options = TrainOptions { memory_mib: 0, ..small(TrainOptions::paper()) };
    check("resume-streaming", &options, &["deformation.last", "targets-0-00000.result", "laplacian.last"]);
}

#[test]
fn the_compact_preset_goes_on_after_any_frame() {
    let files = ["coarse-0-00000.result", "base-0-00000.result"];
    check("resume-compact", &small(TrainOptions::compact()), &files);
}

#[test]
fn poses_that_are_learnt_with_f_d_go_on_with_it() {
    let mut options = small(TrainOptions::paper());
    options.refinement.learning_rate = 1e-3;
    check("resume-joint", &options, &["deformation.last", "targets-0-00000.result"]);
}

#[test]
fn refined_poses_are_kept_round_by_round_and_frame_by_frame() {
    let mut options = small(TrainOptions::compact());
    options.refinement.round_count = 2;
    let files = ["refining-0-00002.result", "refined-0.result", "refined-1.result"];
    check("resume-refined", &options, &files);
}
