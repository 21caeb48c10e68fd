//! `crease report`.

use super::{open_sequence, read_avatar};
use anyhow::Context;
use clap::Args;
use crease::animate::Animator;
use crease::avatar::Avatar;
use crease::body::Pose;
use crease_trainer::files::write_whole;
use crease_trainer::frames::FrameRange;
use crease_trainer::progress::Progress;
use crease_trainer::report::{Photographer, Report, Row, Truth, hardest, page};
use crease_trainer::residue::{Residue, Wishes, residue};
use crease_trainer::run_log::{Line, read_log};
use crease_trainer::sequence::{Reading, Sequence};
use crease_trainer::studio::Studio;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Args)]
pub struct Arguments {
    /// The avatar (.glb); its run's .csv and .toml are taken in where they lie beside it
    pub avatar: PathBuf,
    /// Directory of a sequence of the same person; measured against its ground truth, or else its scans
    pub sequence: PathBuf,
    /// Where to write the page; beside the avatar (.html) if left out
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Shape and poses; body.npz of the sequence if left out
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Frames to measure, as a Python slice; those that were not trained on if left out
    #[arg(long, value_name = "START:STOP:STEP")]
    pub frames: Option<FrameRange>,
    /// Further sequences that the avatar was trained on, for the distance from the nearest training pose
    #[arg(long, value_name = "SEQUENCE")]
    pub trained_on: Vec<PathBuf>,
    /// How many frames to show
    #[arg(long, default_value_t = 3)]
    pub pictures: usize,
    /// In how many frames to measure detail, by fitting the truth: seconds each
    #[arg(long, default_value_t = 4)]
    pub energy_frames: usize,
    /// What poses far from training wear, in figures and pictures: 0 what is likeliest, 1 the folds of the nearest training poses, as a page
    /// shows
    #[arg(long, default_value_t = 0.0)]
    pub liveliness: f32,
    /// Print what was measured as one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let avatar = Arc::new(read_avatar(&arguments.avatar)?);
    let sequence = open_sequence(&avatar, &arguments.sequence, arguments.poses.as_ref(), &arguments.reading)?;
    let others = (arguments.trained_on.iter())
        .map(|directory| open_sequence(&avatar, directory, None, &arguments.reading))
        .collect::<Result<Vec<_>, _>>()?;
    let wanted = Wanted {
        avatar: &arguments.avatar,
        output: arguments.output.clone().unwrap_or_else(|| arguments.avatar.with_extension("html")),
        frames: arguments.frames,
        pictures: arguments.pictures,
        energy_frames: arguments.energy_frames,
        liveliness: arguments.liveliness,
        progress: Progress::Bars,
    };
    let (residue, bytes) = write(&wanted, avatar, &sequence, &others)?;
    if arguments.json {
        println!("{}", serde_json::to_string(&residue)?);
    } else {
        let (output, frames) = (wanted.output.display(), residue.frames.len());
        println!("{output}: {:.1} MB, {frames} frames", bytes as f64 / 1e6);
    }
    Ok(())
}

/// What a page is to be about.
pub struct Wanted<'a> {
    /// The avatar's file.
    pub avatar: &'a Path,
    pub output: PathBuf,
    /// Those that were not trained on if left out.
    pub frames: Option<FrameRange>,
    pub pictures: usize,
    pub energy_frames: usize,
    /// [`crease::animate::Options::liveliness`].
    pub liveliness: f32,
    pub progress: Progress,
}

/// Writes the page about `avatar` on `sequence`; `others` are further ones that it may have been trained on. Gives what was measured, and the
/// page's bytes.
pub fn write(
    wanted: &Wanted,
    avatar: Arc<Avatar>,
    sequence: &Sequence,
    others: &[Sequence],
) -> anyhow::Result<(Residue, usize)> {
    let trained = trained_frames(&avatar, sequence);
    let truth = Truth::new(sequence, Arc::clone(&avatar))?;
    let frames = match wanted.frames {
        Some(frames) => frames.indices(sequence.capture.frame_count)?,
        None => unseen(truth.frames(), &trained),
    };
    let mut training_poses: Vec<Pose> = trained.iter().map(|&frame| sequence.poses[frame].clone()).collect();
    for other in others {
        training_poses.extend(trained_frames(&avatar, other).into_iter().map(|frame| other.poses[frame].clone()));
    }
    let wishes = Wishes {
        frames: &frames,
        training_poses: &training_poses,
        energy_frame_count: wanted.energy_frames,
        liveliness: wanted.liveliness,
    };
    let residue = residue(Arc::clone(&avatar), sequence, |frame| truth.truth(frame), &wishes, wanted.progress)?;

    let (rows, adapter) = match pictures(&avatar, sequence, &truth, &residue, wanted) {
        Ok((rows, adapter)) => (Ok(rows), adapter),
        Err(error) => (Err(format!("{error:#}")), String::new()),
    };
    let beside = |ending: &str| Some(wanted.avatar.with_extension(ending)).filter(|path| path.exists());
    let log: Vec<Line> = beside("csv").map(|path| read_log(&path)).transpose()?.unwrap_or_default();
    let config = beside("toml").map(|path| read_text(&path)).transpose()?;
    let page = page(&Report {
        avatar: &avatar,
        bytes: std::fs::metadata(wanted.avatar)?.len() as usize,
        sequence: &sequence.capture.name,
        against: truth.name(),
        residue: &residue,
        liveliness: wanted.liveliness,
        pictures: rows.as_deref().map_err(String::as_str),
        adapter: &adapter,
        log: &log,
        config: config.as_deref(),
    });
    write_whole(&wanted.output, page.as_bytes())?;
    Ok((residue, page.len()))
}

fn read_text(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}

/// Frames of `sequence` that the avatar says it was trained on.
fn trained_frames(avatar: &Avatar, sequence: &Sequence) -> Vec<usize> {
    let sequences = avatar.provenance.get("sequences").and_then(|value| value.as_array());
    let same = |entry: &&serde_json::Value| entry["name"] == sequence.capture.name.as_str();
    let frames = sequences.into_iter().flatten().filter(same).filter_map(|entry| entry["frames"].as_array()).flatten();
    let index =
        |frame: &serde_json::Value| Some(frame.as_u64()? as usize).filter(|&frame| frame < sequence.poses.len());
    frames.filter_map(index).collect()
}

/// Those of `frames` that were not trained on; all where that leaves none.
fn unseen(frames: Vec<usize>, trained: &[usize]) -> Vec<usize> {
    let unseen: Vec<usize> = frames.iter().copied().filter(|frame| !trained.contains(frame)).collect();
    if unseen.is_empty() { frames } else { unseen }
}

/// The hardest frames, but for one in the middle, and the adapter that drew them.
fn pictures(
    avatar: &Arc<Avatar>,
    sequence: &Sequence,
    truth: &Truth,
    residue: &Residue,
    wanted: &Wanted,
) -> anyhow::Result<(Vec<Row>, String)> {
    let studio = Studio::open()?;
    let mut photographer = Photographer::new(&studio, Animator::new(Arc::clone(avatar))?, wanted.liveliness)?;
    let hardest = hardest(&residue.frames);
    let mut chosen: Vec<usize> =
        hardest.iter().take(wanted.pictures.saturating_sub(1)).map(|frame| frame.frame).collect();
    chosen.extend(hardest.get(hardest.len() / 2).map(|frame| frame.frame).filter(|_| wanted.pictures > 0));
    let bar = wanted.progress.bar("drawing", chosen.len());
    let mut rows = Vec::new();
    for frame in chosen {
        let (scan, truth) = (truth.scan(frame)?, truth.truth(frame)?);
        rows.extend(photographer.rows(frame, &sequence.poses[frame], &scan, &truth)?);
        bar.advance(1);
    }
    drop(bar);
    Ok((rows, studio.adapter().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_trained_on_is_measured() {
        assert_eq!(unseen(vec![0, 1, 2, 4], &[1, 3]), [0, 2, 4]);
        assert_eq!(unseen(vec![0, 1], &[0, 1]), [0, 1]);
    }
}
