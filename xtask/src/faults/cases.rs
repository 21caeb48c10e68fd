//! The faults, one function each: what happened in words, or none where it could not be tried here, or what went wrong.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::thread;
use std::time::{Duration, SystemTime};

use anyhow::{Context, Result, ensure};

use super::trial::{Run, Trial, kept, last_words, wait};

type Happened = Result<Option<String>>;
type Case = Box<dyn Fn(&Trial) -> Happened>;

/// Every fault by name.
pub fn all(kills: u32, seed: u64) -> Vec<(&'static str, Case)> {
    vec![
        ("killed at random moments", Box::new(move |trial| killed(trial, kills, seed))),
        ("Ctrl-C", Box::new(interrupted)),
        ("a scan vanishes in mid-run", Box::new(scan_vanishes)),
        ("a scan cut short", Box::new(scan_cut_short)),
        ("a checkpoint file damaged", Box::new(damaged)),
        ("files dated 1990 and 2090", Box::new(clock_jumps)),
        ("two trainers, one checkpoint", Box::new(two_at_once)),
        ("disk full", Box::new(disk_full)),
        ("output read-only", Box::new(read_only)),
    ]
}

fn killed(trial: &Trial, kills: u32, seed: u64) -> Happened {
    let (mut early, mut late) = (0, 0);
    for (index, moment) in moments(kills, seed).into_iter().enumerate() {
        let run = trial.run(&format!("killed-{index}"))?;
        let mut process = run.start()?;
        thread::sleep(trial.duration.mul_f64(moment));
        // SIGKILL on Unix: the process cannot answer.
        process.kill()?;
        let ended = wait(process)?;
        early += u32::from(kept(&run.checkpoint) == 0);
        late += u32::from(ended.status.success());
        run.goes_on().with_context(|| format!("killed at {moment:.3} of the run"))?;
        fs::remove_dir_all(run.sequence.parent().context("a run has a folder")?)?;
    }
    Ok(Some(format!("{kills} kills, {early} of them before anything was kept, {late} after the end")))
}

/// So many of 0 .. 1, evenly spread but for chance (a linear congruential generator, Knuth's constants).
fn moments(count: u32, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|index| (f64::from(index) + random()) / f64::from(count)).collect()
}

fn interrupted(trial: &Trial) -> Happened {
    let run = trial.run("interrupted")?;
    let mut process = run.start()?;
    run.has_kept(&mut process)?;
    stop(&process)?;
    let output = wait(process)?;
    let words = last_words(&output);
    ensure!(output.status.code() == Some(130), "it ended with {}: {words}", output.status);
    ensure!(words.contains("crease train --resume"), "it does not say how to go on: {words}");
    ensure!(!run.output.exists(), "an avatar was written");
    run.goes_on()?;
    Ok(Some(format!("exit code 130, \u{201c}{words}\u{201d}")))
}

#[cfg(unix)]
fn stop(process: &Child) -> Result<()> {
    use nix::sys::signal::{Signal, kill};
    kill(nix::unistd::Pid::from_raw(process.id() as i32), Signal::SIGINT).context("cannot send Ctrl-C")
}

#[cfg(not(unix))]
fn stop(_: &Child) -> Result<()> {
    anyhow::bail!("Ctrl-C can be sent on Unix only")
}

fn scan(run: &Run) -> PathBuf {
    run.sequence.join("frames/0005.ply")
}

fn scan_vanishes(trial: &Trial) -> Happened {
    let run = trial.run("vanishes")?;
    let aside = run.sequence.join("aside");
    let mut process = run.start()?;
    run.has_kept(&mut process)?;
    fs::rename(scan(&run), &aside)?;
    let output = wait(process)?;
    let words = last_words(&output);
    ensure!(output.status.code() == Some(1) && words.contains("0005.ply"), "it ended with {}: {words}", output.status);
    fs::rename(&aside, scan(&run))?;
    run.goes_on()?;
    Ok(Some(words))
}

fn scan_cut_short(trial: &Trial) -> Happened {
    let run = trial.run("cut")?;
    let whole = fs::read(scan(&run))?;
    fs::write(scan(&run), &whole[..whole.len() / 2])?;
    let words = run.fails()?;
    ensure!(words.contains("0005.ply"), "it does not name the scan: {words}");
    fs::write(scan(&run), whole)?;
    run.goes_on()?;
    Ok(Some(words))
}

/// A run that was stopped with something kept.
fn stopped<'a>(trial: &'a Trial, name: &str) -> Result<Run<'a>> {
    let run = trial.run(name)?;
    let mut process = run.start()?;
    run.has_kept(&mut process)?;
    process.kill()?;
    wait(process)?;
    Ok(run)
}

fn kept_files(run: &Run) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(&run.checkpoint)?.map(|entry| entry.map(|entry| entry.path()));
    let mut files = entries.collect::<std::io::Result<Vec<PathBuf>>>()?;
    files.retain(|path| path.extension().is_some_and(|ending| ending == "result" || ending == "last"));
    Ok(files)
}

fn damaged(trial: &Trial) -> Happened {
    let run = stopped(trial, "damaged")?;
    let files = kept_files(&run)?;
    for (index, path) in files.iter().enumerate() {
        let mut bytes = fs::read(path)?;
        match index % 2 {
            0 => bytes.truncate(bytes.len() / 2),
            _ => bytes.iter_mut().step_by(1000).for_each(|byte| *byte ^= 0x40),
        }
        fs::write(path, bytes)?;
    }
    run.goes_on()?;
    Ok(Some(format!("{} files noticed by their checksums and computed again", files.len())))
}

fn clock_jumps(trial: &Trial) -> Happened {
    let run = stopped(trial, "clock")?;
    const YEAR: Duration = Duration::from_secs(365 * 24 * 60 * 60);
    for (index, path) in kept_files(&run)?.iter().enumerate() {
        let years = if index % 2 == 0 { 20 } else { 120 };
        File::options().write(true).open(path)?.set_modified(SystemTime::UNIX_EPOCH + years * YEAR)?;
    }
    run.goes_on()?;
    Ok(Some("no matter: no result depends on a clock".into()))
}

fn two_at_once(trial: &Trial) -> Happened {
    let run = trial.run("two")?;
    let mut first = run.start()?;
    run.has_kept(&mut first)?;
    let second = wait(run.start()?)?;
    let words = last_words(&second);
    ensure!(
        second.status.code() == Some(1) && words.contains("lock"),
        "the second ended with {}: {words}",
        second.status
    );
    let first = wait(first)?;
    ensure!(first.status.success(), "the first was disturbed: {}", last_words(&first));
    run.goes_on()?;
    Ok(Some(words))
}

/// A small disk of memory, which goes away with this.
struct Disk(PathBuf);

impl Disk {
    /// None where this process may not mount.
    fn new(folder: &Path, kilobytes: u32) -> Result<Option<Self>> {
        fs::create_dir_all(folder)?;
        let mounted = mount(&["-t", "tmpfs", "-o", &format!("size={kilobytes}k"), "tmpfs"], folder);
        Ok(mounted.then(|| Self(folder.to_owned())))
    }

    fn remount(&self, options: &str) -> Result<()> {
        ensure!(mount(&["-o", &format!("remount,{options}")], &self.0), "cannot remount the disk");
        Ok(())
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // Nothing can be done where it fails; the disk is a few megabytes.
        let _ = Command::new("umount").arg(&self.0).output();
    }
}

fn mount(arguments: &[&str], folder: &Path) -> bool {
    let ended = Command::new("mount").args(arguments).arg(folder).output();
    ended.is_ok_and(|output| output.status.success())
}

fn disk_full(trial: &Trial) -> Happened {
    let run = trial.run("full")?;
    // Enough for a few results and not for all.
    let Some(disk) = Disk::new(&run.checkpoint, 64)? else { return Ok(None) };
    let words = run.fails()?;
    ensure!(words.to_lowercase().contains("space"), "it does not name the lack of space: {words}");
    let before = kept(&run.checkpoint);
    disk.remount("size=65536k")?;
    run.goes_on()?;
    Ok(Some(format!("{before} results intact; {words}")))
}

fn read_only(trial: &Trial) -> Happened {
    let mut run = trial.run("read-only")?;
    let folder = run.output.with_file_name("out");
    let Some(disk) = Disk::new(&folder, 65536)? else { return Ok(None) };
    run.output = folder.join("avatar.glb");
    disk.remount("ro")?;
    let words = run.fails()?;
    ensure!(words.contains("avatar.glb"), "it does not name the output: {words}");
    disk.remount("rw")?;
    run.goes_on()?;
    Ok(Some(words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_cover_the_run() {
        let moments = moments(20, 3);
        assert!(moments.iter().enumerate().all(|(i, &m)| (i as f64 / 20.0..=(i + 1) as f64 / 20.0).contains(&m)));
        assert_ne!(moments, super::moments(20, 4));
    }
}
