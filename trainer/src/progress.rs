//! How long work shows that it goes on: bars with the time left, lines of JSON, or silence.

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Lines of JSON come no closer than this, but for a stage's last.
const BETWEEN_LINES: Duration = Duration::from_secs(1);

/// Where progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Progress {
    /// Bars on standard error.
    Bars,
    /// Lines on standard output, each an object: `stage`, `done`, `count`, `seconds` since the stage began, and `left_seconds` and `note`
    /// where there is any.
    Json,
    /// Nothing: for tests and for callers that show their own.
    #[default]
    Silent,
}

impl Progress {
    /// Begins a stage of `count` steps. The bar goes away when it is dropped.
    pub fn bar(self, title: &str, count: usize) -> Bar {
        let bar = match self {
            Self::Silent | Self::Json => ProgressBar::hidden(),
            Self::Bars => ProgressBar::new(count as u64),
        };
        let style = ProgressStyle::with_template("{prefix:28} {bar:30} {pos}/{len}  {eta} left  {msg}")
            .expect("the template is well-formed");
        bar.set_style(style);
        bar.set_prefix(title.to_owned());
        let lines = (self == Self::Json).then(|| Mutex::new(Lines::new(title, count as u64)));
        Bar { bar, lines }
    }
}

/// A stage under way. Threads may share it.
pub struct Bar {
    bar: ProgressBar,
    lines: Option<Mutex<Lines>>,
}

impl Bar {
    /// `count` more steps are done.
    pub fn advance(&self, count: u64) {
        self.bar.inc(count);
        self.with_lines(|lines| lines.advance(count));
    }

    /// Shows a short note beside the bar: a loss, for instance.
    pub fn note(&self, text: String) {
        self.with_lines(|lines| lines.note = Some(text.clone()));
        self.bar.set_message(text);
    }

    fn with_lines(&self, change: impl FnOnce(&mut Lines)) {
        if let Some(lines) = &self.lines {
            change(&mut lines.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A stage told in lines.
struct Lines {
    stage: String,
    done: u64,
    count: u64,
    begin: Instant,
    printed: Option<Instant>,
    note: Option<String>,
}

impl Lines {
    fn new(stage: &str, count: u64) -> Self {
        Self { stage: stage.to_owned(), done: 0, count, begin: Instant::now(), printed: None, note: None }
    }

    fn advance(&mut self, count: u64) {
        self.done += count;
        let is_due = self.printed.is_none_or(|printed| printed.elapsed() >= BETWEEN_LINES);
        if is_due || self.done >= self.count {
            self.printed = Some(Instant::now());
            println!("{}", self.line(self.begin.elapsed().as_secs_f64()));
        }
    }

    fn line(&self, seconds: f64) -> String {
        let mut line = json!({ "stage": self.stage, "done": self.done, "count": self.count, "seconds": seconds });
        if self.done > 0 {
            line["left_seconds"] = json!(seconds * self.count.saturating_sub(self.done) as f64 / self.done as f64);
        }
        if let Some(note) = &self.note {
            line["note"] = json!(note);
        }
        line.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_how_far_a_stage_is_and_what_is_left() {
        let mut lines = Lines::new("fitting", 4);
        lines.done = 1;
        lines.note = Some("E 0.5".into());
        let line: serde_json::Value = serde_json::from_str(&lines.line(2.0)).unwrap();
        let expected =
            json!({ "stage": "fitting", "done": 1, "count": 4, "seconds": 2.0, "left_seconds": 6.0, "note": "E 0.5" });
        assert_eq!(line, expected);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&Lines::new("a", 0).line(0.0)).unwrap()["count"], 0);
    }
}
