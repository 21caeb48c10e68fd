//! A short training run, the undisturbed result, and the means to start the same run again elsewhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use crate::{command, workspace};

/// A run that takes longer than this has hung.
const PATIENCE: Duration = Duration::from_secs(120);

/// Which form is trained.
#[derive(Clone, Copy)]
pub enum Preset {
    Compact,
    Paper,
}

impl Preset {
    pub fn name(self) -> &'static str {
        match self {
            Self::Compact => "compact",
            Self::Paper => "paper",
        }
    }

    /// Small enough for a few seconds.
    fn assignments(self) -> &'static [&'static str] {
        match self {
            Self::Compact => &["anchor_count=100", "texture_size=64"],
            Self::Paper => &[
                "anchor_count=100",
                "texture_size=64",
                "frequency_count=4",
                "deformation.network.width=32",
                "deformation.network.epoch_count=20",
                "deformation.points_a_frame=1000",
                "deformation.frames_a_step=3",
                "laplacian.network.width=32",
                "laplacian.network.epoch_count=6",
                "laplacian.points_a_step=2000",
            ],
        }
    }
}

/// The run and what it gives undisturbed.
pub struct Trial {
    preset: Preset,
    folder: PathBuf,
    /// The avatar's bytes.
    undisturbed: Vec<u8>,
    /// How long that took.
    pub duration: Duration,
}

/// One run in a folder of its own.
pub struct Run<'a> {
    trial: &'a Trial,
    /// Its sequence, which a case may spoil.
    pub sequence: PathBuf,
    /// Where its avatar goes.
    pub output: PathBuf,
    /// Where its work is kept.
    pub checkpoint: PathBuf,
}

impl Trial {
    pub fn new(preset: Preset) -> Result<Self> {
        let folder = workspace::root().join("target/faults").join(preset.name());
        if folder.exists() {
            fs::remove_dir_all(&folder).context("cannot empty target/faults")?;
        }
        let mut trial = Self { preset, folder, undisturbed: Vec::new(), duration: Duration::ZERO };
        command::run(command::program(programs().join("examples/write_sequence")).arg(trial.folder.join("sequence")))?;
        let run = trial.run("undisturbed")?;
        let begin = Instant::now();
        let output = wait(run.start()?)?;
        ensure!(output.status.success(), "the undisturbed run failed: {}", last_words(&output));
        let duration = begin.elapsed();
        let undisturbed = fs::read(&run.output).context("the undisturbed run wrote no avatar")?;
        (trial.undisturbed, trial.duration) = (undisturbed, duration);
        Ok(trial)
    }

    /// A fresh run in the folder `name`.
    pub fn run(&self, name: &str) -> Result<Run<'_>> {
        let folder = self.folder.join(name);
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        let sequence = folder.join("sequence");
        copy_folder(&self.folder.join("sequence"), &sequence)?;
        Ok(Run { trial: self, sequence, output: folder.join("avatar.glb"), checkpoint: folder.join("kept") })
    }
}

impl Run<'_> {
    /// The command that starts it.
    pub fn command(&self) -> Command {
        let mut crease = self.crease();
        crease.arg(&self.sequence).arg("-o").arg(&self.output).arg("--checkpoint").arg(&self.checkpoint);
        crease.arg("--body").arg(self.sequence.join("model.npz")).args(["--preset", self.trial.preset.name()]);
        for assignment in self.trial.preset.assignments() {
            crease.args(["--set", assignment]);
        }
        crease
    }

    fn crease(&self) -> Command {
        let mut crease = Command::new(programs().join("crease"));
        crease.args(["train", "--quiet", "--checkpoint-every", "0"]);
        crease.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        crease
    }

    pub fn start(&self) -> Result<Child> {
        self.command().spawn().context("cannot start crease")
    }

    /// Runs to the end and expects a failure: its last words.
    pub fn fails(&self) -> Result<String> {
        let output = wait(self.start()?)?;
        ensure!(!output.status.success(), "the run did not fail");
        ensure!(output.status.code() == Some(1), "the run ended with {}: {}", output.status, last_words(&output));
        self.nothing_half()?;
        Ok(last_words(&output))
    }

    /// Goes on to the end and compares.
    pub fn goes_on(&self) -> Result<()> {
        let has_begun = self.checkpoint.join("run.toml").exists();
        let mut crease = if has_begun { self.crease() } else { self.command() };
        if has_begun {
            crease.arg("--resume").arg(&self.checkpoint);
        }
        let output = wait(crease.spawn().context("cannot start crease")?)?;
        ensure!(output.status.success(), "it did not go on: {}", last_words(&output));
        self.nothing_half()?;
        let bytes = fs::read(&self.output).context("no avatar was written")?;
        ensure!(bytes == self.trial.undisturbed, "the avatar differs from that of the undisturbed run");
        Ok(())
    }

    /// No part of a file is left beside the output, and the output is whole or missing.
    fn nothing_half(&self) -> Result<()> {
        let folder = self.output.parent().context("the output has a folder")?;
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            ensure!(path.extension().is_none_or(|ending| ending != "part"), "{} was left", path.display());
        }
        match fs::read(&self.output) {
            Ok(bytes) => ensure!(bytes == self.trial.undisturbed, "a damaged avatar was left"),
            Err(error) => ensure!(error.kind() == std::io::ErrorKind::NotFound, "{error}"),
        }
        Ok(())
    }

    /// Waits until the run has kept something.
    pub fn has_kept(&self, process: &mut Child) -> Result<()> {
        let begin = Instant::now();
        loop {
            if kept(&self.checkpoint) > 0 {
                return Ok(());
            }
            ensure!(process.try_wait()?.is_none(), "the run ended before it kept anything");
            ensure!(begin.elapsed() < PATIENCE, "the run kept nothing");
            thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Results and states in a checkpoint.
pub fn kept(checkpoint: &Path) -> usize {
    let endings = ["result", "last"];
    let entries = fs::read_dir(checkpoint).into_iter().flatten().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|e| endings.iter().any(|ending| e == *ending))).count()
}

/// The program's end and all that it said; killed, and an error, where it hangs.
pub fn wait(mut process: Child) -> Result<Output> {
    let begin = Instant::now();
    while process.try_wait()?.is_none() {
        if begin.elapsed() > PATIENCE || command::interrupted() {
            process.kill()?;
            process.wait()?;
            bail!("the run hung, or was interrupted");
        }
        thread::sleep(Duration::from_millis(10));
    }
    process.wait_with_output().context("cannot read what the run said")
}

/// What a program said last, without the paths of this machine.
pub fn last_words(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let folder = format!("{}/", workspace::root().join("target/faults").display());
    text.lines().last().unwrap_or("nothing").replace(&folder, "").replace('|', "/")
}

fn programs() -> PathBuf {
    workspace::root().join("target/debug")
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from).with_context(|| format!("cannot list {}", from.display()))? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
