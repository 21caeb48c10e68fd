//! Bars with the time left, or silence.

use indicatif::{ProgressBar, ProgressStyle};

/// Where progress is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Progress {
    /// Bars on standard error.
    Bars,
    /// Nothing: for tests and for callers that show their own.
    #[default]
    Silent,
}

impl Progress {
    /// Begins a stage of `count` steps. The bar goes away when it is dropped.
    pub fn bar(self, title: &str, count: usize) -> Bar {
        let bar = match self {
            Self::Silent => ProgressBar::hidden(),
            Self::Bars => ProgressBar::new(count as u64),
        };
        let style = ProgressStyle::with_template("{prefix:28} {bar:30} {pos}/{len}  {eta} left  {msg}")
            .expect("the template is well-formed");
        bar.set_style(style);
        bar.set_prefix(title.to_owned());
        Bar { bar }
    }
}

/// A stage under way. Threads may share it.
pub struct Bar {
    bar: ProgressBar,
}

impl Bar {
    /// `count` more steps are done.
    pub fn advance(&self, count: u64) {
        self.bar.inc(count);
    }

    /// Shows a short note beside the bar: a loss, for instance.
    pub fn note(&self, text: String) {
        self.bar.set_message(text);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
