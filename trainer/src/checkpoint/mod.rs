//! Work that survives its process: results kept on disk as they come, found again by what they depend on.
//!
//! Every file stands for itself: it says what its result depends on, by a [`Fingerprint`], and carries a checksum. A file that is damaged,
//! of another version, or about other inputs is as good as none, and its result is computed again. So a run that is taken up gives what
//! an undisturbed one gives, whatever happened in between.

mod fingerprint;
mod keep;
mod record;

pub use fingerprint::{Fingerprint, Ingredients};
pub use keep::Keep;
pub use record::Record;

use crate::files::write_whole;
use crate::interrupt::Interrupt;
use crate::sequence::read_error;
use anyhow::Context;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Ending of results, of a stage's last state and of the one before.
const RESULT: &str = "result";
const LAST: &str = "last";
const PREVIOUS: &str = "previous";

/// A directory of results, locked while this lives; or none, which keeps nothing.
#[derive(Debug, Default)]
pub struct Checkpoint {
    place: Option<Place>,
    /// Looked at before each result is computed.
    pub interrupt: Interrupt,
}

#[derive(Debug)]
struct Place {
    directory: PathBuf,
    /// Held open for its lock, which the system releases when the process ends, however it ends.
    _lock: File,
    interval: Duration,
    saved: Mutex<Instant>,
}

impl Checkpoint {
    /// Keeps results in `directory`, which is made if need be, and finds those that are there; states of a stage under way are kept every
    /// `interval`.
    ///
    /// Fails where the directory cannot be made or written, and where another process keeps its results there.
    pub fn open(directory: &Path, interval: Duration, interrupt: Interrupt) -> anyhow::Result<Self> {
        fs::create_dir_all(directory)
            .with_context(|| format!("{}: the checkpoint's directory cannot be made", directory.display()))?;
        let path = directory.join("lock");
        let lock = File::create(&path).with_context(|| format!("{}: cannot be written", path.display()))?;
        lock.try_lock().map_err(|error| {
            let found = format!("another process that trains there ({error})");
            read_error(directory, "lock", "a checkpoint that nobody uses", found)
        })?;
        remove_parts(directory)?;
        let place = Place { directory: directory.to_owned(), _lock: lock, interval, saved: Mutex::new(Instant::now()) };
        Ok(Self { place: Some(place), interrupt })
    }

    /// The result `name` of `inputs`, kept from earlier or computed and kept now.
    ///
    /// Fails where computing fails, where the result cannot be kept, and, before computing, where somebody asked to stop.
    pub fn remember<T: Keep>(
        &self,
        name: &str,
        inputs: Fingerprint,
        compute: impl FnOnce() -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        if let Some(kept) = self.place.as_ref().and_then(|place| place.load(name, RESULT, inputs)) {
            return Ok(kept);
        }
        self.interrupt.check()?;
        let result = compute()?;
        if let Some(place) = &self.place {
            let bytes = Record { inputs, result: &result.to_bytes() }.write();
            write_whole(&place.path(name, RESULT), &bytes)?;
        }
        Ok(result)
    }

    /// The latest sound state of a stage under way, if one of `inputs` was kept.
    pub fn state<T: Keep>(&self, name: &str, inputs: Fingerprint) -> Option<T> {
        let place = self.place.as_ref()?;
        [LAST, PREVIOUS].into_iter().find_map(|ending| place.load(name, ending, inputs))
    }

    /// Keeps the state of a stage under way if it is time to, or if somebody asked to stop: then the error says so. The state before the
    /// last stays beside it.
    pub fn keep_state<T: Keep>(
        &self,
        name: &str,
        inputs: Fingerprint,
        state: impl FnOnce() -> T,
    ) -> anyhow::Result<()> {
        if let Some(place) = &self.place
            && (self.interrupt.is_set() || place.is_due())
        {
            place.keep_state(name, inputs, &state())?;
        }
        Ok(self.interrupt.check()?)
    }

    /// Keeps the state of a stage that is done.
    pub fn keep_last_state<T: Keep>(&self, name: &str, inputs: Fingerprint, state: &T) -> anyhow::Result<()> {
        self.place.as_ref().map_or(Ok(()), |place| place.keep_state(name, inputs, state))
    }

    /// Where results are kept, if they are.
    pub fn directory(&self) -> Option<&Path> {
        self.place.as_ref().map(|place| place.directory.as_path())
    }
}

/// Removes what a process left that was killed while it wrote.
fn remove_parts(directory: &Path) -> anyhow::Result<()> {
    for entry in fs::read_dir(directory).with_context(|| format!("{}: cannot be listed", directory.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending == "part") {
            fs::remove_file(&path).with_context(|| format!("{}: cannot be removed", path.display()))?;
        }
    }
    Ok(())
}

impl Place {
    fn path(&self, name: &str, ending: &str) -> PathBuf {
        self.directory.join(format!("{name}.{ending}"))
    }

    /// Nothing where there is no file, where it is about something else, and, with a note, where it is damaged.
    fn load<T: Keep>(&self, name: &str, ending: &str, inputs: Fingerprint) -> Option<T> {
        let path = self.path(name, ending);
        let bytes = fs::read(&path).ok()?;
        match Record::read(&bytes, &path.display().to_string()) {
            Ok(record) if record.inputs == inputs => T::from_bytes(record.result),
            Ok(_) => None,
            Err(error) => {
                eprintln!("note: {error}: computed again");
                None
            }
        }
    }

    fn keep_state<T: Keep>(&self, name: &str, inputs: Fingerprint, state: &T) -> anyhow::Result<()> {
        let last = self.path(name, LAST);
        if last.exists() {
            fs::rename(&last, self.path(name, PREVIOUS))
                .with_context(|| format!("{}: cannot be renamed", last.display()))?;
        }
        write_whole(&last, &Record { inputs, result: &state.to_bytes() }.write())
    }

    fn is_due(&self) -> bool {
        let mut saved = self.saved.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let due = saved.elapsed() >= self.interval;
        if due {
            *saved = Instant::now();
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interrupt::Interrupted;
    use anyhow::bail;
    use glam::Vec3A;

    const INPUTS: Fingerprint = Fingerprint([1; 32]);

    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("crease-checkpoint-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }

        fn open(&self) -> Checkpoint {
            Checkpoint::open(&self.0, Duration::ZERO, Interrupt::default()).unwrap()
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn remember(checkpoint: &Checkpoint, inputs: Fingerprint, value: f32) -> f32 {
        checkpoint.remember("a", inputs, || Ok(vec![Vec3A::splat(value)])).unwrap()[0].x
    }

    #[test]
    fn results_are_computed_once_for_the_same_inputs() {
        let scratch = Scratch::new("once");
        assert_eq!(remember(&scratch.open(), INPUTS, 1.0), 1.0);
        assert_eq!(remember(&scratch.open(), INPUTS, 2.0), 1.0, "kept");
        assert_eq!(remember(&scratch.open(), Fingerprint([2; 32]), 3.0), 3.0, "other inputs");
        assert_eq!(remember(&Checkpoint::default(), INPUTS, 4.0), 4.0, "nothing is kept without a directory");
    }

    #[test]
    fn damaged_results_are_computed_again() {
        let scratch = Scratch::new("damage");
        remember(&scratch.open(), INPUTS, 1.0);
        fs::write(scratch.0.join(".a.result.7.part"), b"half").unwrap();
        let path = scratch.0.join("a.result");
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(&path, &bytes).unwrap();
        assert_eq!(remember(&scratch.open(), INPUTS, 2.0), 2.0);
        assert_eq!(remember(&scratch.open(), INPUTS, 3.0), 2.0, "and kept");
        assert!(!scratch.0.join(".a.result.7.part").exists(), "halves go away");
    }

    #[test]
    fn the_last_two_states_are_kept_and_the_one_before_stands_in() {
        let scratch = Scratch::new("states");
        let checkpoint = scratch.open();
        for value in [1.0, 2.0, 3.0] {
            checkpoint.keep_state("s", INPUTS, || vec![Vec3A::splat(value)]).unwrap();
        }
        let state = || checkpoint.state::<Vec<Vec3A>>("s", INPUTS).map(|state| state[0].x);
        assert_eq!(state(), Some(3.0));
        fs::write(scratch.0.join("s.last"), b"half").unwrap();
        assert_eq!(state(), Some(2.0));
        assert_eq!(checkpoint.state::<Vec<Vec3A>>("s", Fingerprint([9; 32])), None);
        fs::remove_file(scratch.0.join("s.previous")).unwrap();
        assert_eq!(state(), None);
    }

    #[test]
    fn states_wait_for_their_time() {
        let scratch = Scratch::new("time");
        let hour = Duration::from_secs(3600);
        let checkpoint = Checkpoint::open(&scratch.0, hour, Interrupt::default()).unwrap();
        checkpoint.keep_state("s", INPUTS, || -> Vec<Vec3A> { panic!("it is not time") }).unwrap();
        checkpoint.interrupt.set();
        let error = checkpoint.keep_state("s", INPUTS, || vec![Vec3A::X]).unwrap_err();
        assert!(error.is::<Interrupted>());
        assert!(checkpoint.state::<Vec<Vec3A>>("s", INPUTS).is_some(), "kept before stopping");
    }

    #[test]
    fn nothing_new_begins_after_an_interrupt() {
        let scratch = Scratch::new("interrupt");
        let checkpoint = scratch.open();
        remember(&checkpoint, INPUTS, 1.0);
        checkpoint.interrupt.set();
        assert_eq!(remember(&checkpoint, INPUTS, 2.0), 1.0, "what is there is there");
        let error =
            checkpoint.remember("b", INPUTS, || -> anyhow::Result<Vec<Vec3A>> { bail!("it began") }).unwrap_err();
        assert!(error.is::<Interrupted>());
    }

    #[test]
    fn two_processes_do_not_share_a_directory() {
        let scratch = Scratch::new("lock");
        let first = scratch.open();
        let error = Checkpoint::open(&scratch.0, Duration::ZERO, Interrupt::default()).unwrap_err();
        assert!(error.to_string().contains("lock"), "{error}");
        drop(first);
        scratch.open();
    }
}
