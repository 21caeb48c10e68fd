//! Steps on the terminal: a name, a sign of life, a duration.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};

/// Runs a step that prints nothing itself: a spinner shows that it is alive.
pub fn quietly<T>(name: &str, step: impl FnOnce() -> Result<T>) -> Result<T> {
    if !stderr().is_terminal() {
        return aloud(name, step);
    }
    let style = ProgressStyle::with_template("{spinner} {msg} ({elapsed})").expect("a valid template");
    let spinner = ProgressBar::new_spinner().with_style(style).with_message(name.to_owned());
    spinner.enable_steady_tick(Duration::from_millis(100));
    let start = Instant::now();
    let result = step();
    spinner.finish_and_clear();
    close(name, start, &result);
    result
}

/// Runs a step whose programs print their own progress.
pub fn aloud<T>(name: &str, step: impl FnOnce() -> Result<T>) -> Result<T> {
    eprintln!("── {name} …");
    let start = Instant::now();
    let result = step();
    close(name, start, &result);
    result
}

fn close<T>(name: &str, start: Instant, result: &Result<T>) {
    let outcome = if result.is_ok() { "done" } else { "FAILED" };
    eprintln!("── {name}: {outcome} ({:.1} s)", start.elapsed().as_secs_f64());
}
