//! What a run tells of itself when it is over: how long its stages took, and how the energy of each network fell.

use crate::files::write_whole;
use anyhow::Context;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// One line of the log. A file of them is CSV, with these names in its first line.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Line {
    /// What was being done.
    pub stage: String,
    /// Epoch of a network's training, from 1; none where the line is about the whole stage.
    pub epoch: Option<usize>,
    /// Mean energy over that epoch.
    pub energy: Option<f32>,
    /// What the whole stage took, in the process that ended it.
    pub seconds: Option<f64>,
}

/// Lines as they come. Threads may share it.
#[derive(Debug, Default)]
pub struct RunLog {
    lines: Mutex<Vec<Line>>,
}

impl RunLog {
    /// The mean energies of all epochs of `stage`.
    pub fn energies(&self, stage: &str, energies: &[f32]) {
        self.extend(energies.iter().enumerate().map(|(index, &energy)| Line {
            stage: stage.into(),
            epoch: Some(index + 1),
            energy: Some(energy),
            seconds: None,
        }));
    }

    /// Runs a stage and notes what it took.
    pub fn timed<T>(&self, stage: &str, run: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
        let begin = Instant::now();
        let result = run()?;
        let seconds = Some(begin.elapsed().as_secs_f64());
        self.extend([Line { stage: stage.into(), epoch: None, energy: None, seconds }]);
        Ok(result)
    }

    fn extend(&self, lines: impl IntoIterator<Item = Line>) {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).extend(lines);
    }

    /// The lines so far.
    pub fn lines(&self) -> Vec<Line> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Writes them as CSV.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for line in self.lines() {
            writer.serialize(line)?;
        }
        write_whole(path, &writer.into_inner().context("the log cannot be written")?)
    }
}

/// Reads what [`RunLog::write`] wrote.
pub fn read_log(path: &Path) -> anyhow::Result<Vec<Line>> {
    let name = || path.display().to_string();
    let mut reader = csv::Reader::from_path(path).with_context(name)?;
    reader.deserialize().collect::<Result<_, _>>().with_context(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_read_as_it_was_written() {
        let log = RunLog::default();
        log.energies("training, the base", &[0.5, 0.25]);
        assert_eq!(log.timed("appearance", || Ok(3)).unwrap(), 3);
        assert!(log.timed::<()>("broken", || anyhow::bail!("no")).is_err());
        let path = std::env::temp_dir().join(format!("crease-log-{}.csv", std::process::id()));
        log.write(&path).unwrap();
        let lines = read_log(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(lines, log.lines());
        assert_eq!(lines.len(), 3, "a stage that failed is not there");
        assert_eq!((lines[1].epoch, lines[1].energy), (Some(2), Some(0.25)));
        assert!(lines[2].seconds.is_some());
    }

    #[test]
    fn a_wrong_file_is_named() {
        let path = std::env::temp_dir().join(format!("crease-log-wrong-{}.csv", std::process::id()));
        std::fs::write(&path, "stage,epoch\nbase,x\n").unwrap();
        let message = format!("{:#}", read_log(&path).unwrap_err());
        std::fs::remove_file(&path).unwrap();
        assert!(message.contains("crease-log-wrong"), "{message}");
    }
}
