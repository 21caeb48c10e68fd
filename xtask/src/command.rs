//! Running other programs: their output on stderr, their failure as an error, a clean stop on Ctrl-C.

use std::io::{Read, stderr};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::workspace;

const POLL: Duration = Duration::from_millis(50);
const GRACE: Duration = Duration::from_secs(5);

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C (or a request to terminate) ends the running program and then this one.
pub fn stop_on_interrupt() -> Result<()> {
    ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed)).context("cannot listen for Ctrl-C")
}

/// Whether the user has asked to stop.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A program run in the repository's root. Standard output goes to stderr: ours is for results only.
pub fn program(name: impl Into<PathBuf>) -> Command {
    let mut command = Command::new(name.into());
    command.current_dir(workspace::root()).stdin(Stdio::null()).stdout(Stdio::from(stderr()));
    command
}

/// The native cargo, free of what `cargo xtask` itself was started with.
pub fn cargo(subcommand: &str) -> Command {
    let mut command = program(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    forget_outer_cargo(&mut command);
    command.arg(subcommand);
    command
}

/// Removes what cargo tells a program that it runs: an inner cargo must not take it for its own settings.
pub fn forget_outer_cargo(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        let about_the_package = ["CARGO_PKG_", "CARGO_MANIFEST_", "CARGO_BIN_", "CARGO_CRATE_"];
        if about_the_package.iter().any(|prefix| text.starts_with(prefix)) || text == "LD_LIBRARY_PATH" {
            command.env_remove(&name);
        }
    }
}

/// Whether a program of this name is on the PATH.
pub fn exists(name: &str) -> bool {
    find(name).is_some()
}

/// The first program of this name on the PATH.
pub fn find(name: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| path.is_file())
}

/// Runs to the end; anything but success is an error that names the command.
pub fn run(command: &mut Command) -> Result<()> {
    let mut child = spawn(command)?;
    let status = wait(&mut child, None)?;
    require_success(command, status)
}

/// As [`run`], but gives up after `limit`.
pub fn run_at_most(command: &mut Command, limit: Duration) -> Result<()> {
    let mut child = spawn(command)?;
    let status = wait(&mut child, Some(limit))?;
    require_success(command, status)
}

/// Runs to the end and returns what the program printed on standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let mut child = spawn(command.stdout(Stdio::piped()))?;
    let mut pipe = child.stdout.take().context("the program's output is not piped")?;
    let reader = thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).map(|_| text)
    });
    let status = wait(&mut child, None)?;
    require_success(command, status)?;
    let text = reader.join().ok().context("the reader of the program's output stopped")?;
    text.with_context(|| format!("cannot read the output of `{}`", describe(command)))
}

fn spawn(command: &mut Command) -> Result<Child> {
    command.spawn().with_context(|| format!("cannot start `{}`", describe(command)))
}

fn wait(child: &mut Child, limit: Option<Duration>) -> Result<ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            if interrupted() {
                bail!("interrupted");
            }
            return Ok(status);
        }
        if interrupted() {
            end(child)?;
            bail!("interrupted");
        }
        if limit.is_some_and(|limit| start.elapsed() > limit) {
            end(child)?;
            bail!("not done after {} s", start.elapsed().as_secs());
        }
        thread::sleep(POLL);
    }
}

/// Asks the program to end, so that it can end its own children, and insists after a while.
fn end(child: &mut Child) -> Result<()> {
    #[cfg(unix)]
    {
        use nix::sys::signal::{Signal, kill};
        let process = nix::unistd::Pid::from_raw(child.id() as i32);
        // An error means that it has just ended by itself.
        let _ = kill(process, Signal::SIGTERM);
        let start = Instant::now();
        while start.elapsed() < GRACE {
            if child.try_wait()?.is_some() {
                return Ok(());
            }
            thread::sleep(POLL);
        }
    }
    child.kill().context("cannot end a program")?;
    child.wait()?;
    Ok(())
}

fn require_success(command: &Command, status: ExitStatus) -> Result<()> {
    if !status.success() {
        bail!("`{}` failed ({status})", describe(command));
    }
    Ok(())
}

/// The command as a person would type it, without the folder of the program.
fn describe(command: &Command) -> String {
    let name = std::path::Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let words = std::iter::once(name).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_what_the_program_printed() {
        assert_eq!(output(program("echo").arg("hello")).unwrap(), "hello\n");
    }

    #[test]
    fn a_failing_program_is_named_with_its_arguments() {
        let error = run(program("/bin/sh").args(["-c", "exit 3"])).unwrap_err().to_string();
        assert!(error.contains("sh -c exit 3") && error.contains('3'), "{error}");
    }

    #[test]
    fn a_missing_program_is_named() {
        let error = run(&mut program("no-such-program")).unwrap_err().to_string();
        assert!(error.contains("no-such-program"), "{error}");
    }

    #[test]
    fn a_program_that_takes_too_long_is_ended() {
        let error = run_at_most(program("sleep").arg("60"), Duration::from_millis(1)).unwrap_err().to_string();
        assert!(error.contains("not done"), "{error}");
    }
}
