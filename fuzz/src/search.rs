//! The search: mutate what reached something new, check it, keep what reaches something new or breaks something.

use crate::Target;
use crate::coverage::Coverage;
use crate::mutation::mutated;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::collections::HashSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// One input may take so long.
const LIMIT: Duration = Duration::from_secs(1);
/// After so long it will not end.
const ENDLESS: Duration = Duration::from_secs(60);

/// Inputs that are checked between two looks at the counters, which take as long as reading a small file …
const BATCH: u64 = 64;
/// … but once in so many times one alone, as only then orders of magnitude are seen.
const ALONE: u32 = 4;

/// Bounds of a search.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How long.
    pub duration: Duration,
    /// How many executions at most.
    pub executions: u64,
    /// Longest input, bytes.
    pub longest: usize,
    /// Of all random choices.
    pub seed: u64,
    /// Inputs that reached something, from earlier searches and for later ones.
    pub corpus: PathBuf,
    /// Inputs that break something.
    pub found: PathBuf,
}

/// What a search did.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Report {
    /// Name of the target.
    pub target: String,
    /// Inputs that were checked.
    pub executions: u64,
    /// How long that took.
    pub seconds: f64,
    /// Inputs that reached something new, seeds included.
    pub inputs: usize,
    /// Branch counters of the build; none where it has no instrumentation, and the search is blind.
    pub counters: usize,
    /// What broke, one line for each place.
    pub found: Vec<String>,
}

thread_local! {
    /// Where the last panic of this thread was, and what it said.
    static LAST_PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Searches until the plan ends. Fails where files cannot be read or written.
pub fn search(target: &Target, plan: &Plan) -> std::io::Result<Report> {
    std::panic::set_hook(Box::new(|panic| LAST_PANIC.set(panic.to_string().replace('\n', " "))));
    fs::create_dir_all(&plan.corpus)?;
    let watch = Watch::new(&plan.found);
    let begin = Instant::now();
    let mut coverage = Coverage::new();
    let mut random = Pcg64Mcg::seed_from_u64(plan.seed);
    let mut places = HashSet::new();
    let mut report = Report {
        target: target.name.into(),
        executions: 0,
        seconds: 0.0,
        inputs: 0,
        counters: coverage.len(),
        found: Vec::new(),
    };
    let mut given = (target.seeds)();
    for entry in fs::read_dir(&plan.corpus)? {
        given.push(fs::read(entry?.path())?);
    }
    let mut corpus: Vec<Vec<u8>> = Vec::new();
    while report.executions < plan.executions && begin.elapsed() < plan.duration {
        let is_given = !given.is_empty();
        let batch: Vec<Vec<u8>> = match given.pop() {
            Some(input) => vec![input],
            None => {
                let left = plan.executions - report.executions;
                let count = if random.random_range(0..ALONE) == 0 { 1 } else { BATCH.min(left) };
                (0..count).map(|_| mutant(target, &corpus, plan.longest, &mut random)).collect()
            }
        };
        coverage.reset();
        let mut outcomes = Vec::with_capacity(batch.len());
        for input in &batch {
            watch.begin(input);
            outcomes.push(outcome(target, input));
            watch.end();
        }
        report.executions += batch.len() as u64;
        let is_alone = batch.len() == 1;
        // Which of many reached something new is seen by checking each again.
        let is_new = if is_alone { coverage.is_new() } else { coverage.has_more() };
        for (input, outcome) in batch.into_iter().zip(outcomes) {
            if let Err((place, complaint)) = outcome {
                if places.insert(place) {
                    save(&plan.found, &input)?;
                    report.found.push(complaint);
                }
            } else if is_given {
                corpus.push(input);
            } else if is_new && (is_alone || reaches_something(target, &input, &mut coverage)) {
                save(&plan.corpus, &input)?;
                corpus.push(input);
            }
        }
        if corpus.is_empty() {
            corpus.push(Vec::new());
        }
    }
    report.inputs = corpus.len();
    report.seconds = begin.elapsed().as_secs_f64();
    Ok(report)
}

/// A change of something that reached something.
fn mutant(target: &Target, corpus: &[Vec<u8>], longest: usize, random: &mut Pcg64Mcg) -> Vec<u8> {
    // The latest finds are the likeliest to lead on.
    let newest = corpus.len() - 1 - random.random_range(0..corpus.len().min(1 + corpus.len() / 4));
    let index = if random.random() { newest } else { random.random_range(0..corpus.len()) };
    let other = random.random_range(0..corpus.len());
    mutated(&corpus[index], &corpus[other], target.container, longest, random)
}

/// Whether an input that breaks nothing reaches something new by itself.
fn reaches_something(target: &Target, input: &[u8], coverage: &mut Coverage) -> bool {
    coverage.reset();
    (target.check)(input);
    coverage.is_new()
}

/// Checks one input; where it broke something, the place and all that is to be said.
fn outcome(target: &Target, input: &[u8]) -> Result<(), (String, String)> {
    let check = || {
        let begin = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| (target.check)(input)));
        (result.is_err(), begin.elapsed())
    };
    let (panicked, mut took) = check();
    if panicked {
        let complaint = LAST_PANIC.take();
        let place = complaint.split_whitespace().find(|word| word.contains(".rs:")).unwrap_or_default().to_owned();
        return Err((place, complaint));
    }
    // A busy machine makes anything slow: only what is slow each time counts.
    for _ in 0..3 {
        if took < LIMIT {
            return Ok(());
        }
        took = took.min(check().1);
    }
    let complaint = format!("{:.1} s for {} bytes", took.as_secs_f64(), input.len());
    if took < LIMIT { Ok(()) } else { Err(("slow".into(), complaint)) }
}

fn save(folder: &Path, input: &[u8]) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    let digest = Sha256::digest(input);
    let name: String = digest.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    fs::write(folder.join(name), input)
}

/// Ends the process, the input saved, where one check does not end.
struct Watch(Arc<Mutex<Option<Current>>>);

/// The input that is checked now, and since when.
struct Current {
    begin: Instant,
    input: Vec<u8>,
}

impl Watch {
    fn new(found: &Path) -> Self {
        let current: Arc<Mutex<Option<Current>>> = Arc::default();
        let (watched, found) = (Arc::clone(&current), found.to_owned());
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_secs(1));
                let current = watched.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(Current { input, .. }) = current.as_ref().filter(|now| now.begin.elapsed() > ENDLESS) {
                    // Nothing else can be done about an error here: the process ends in any case.
                    let _ = save(&found, input);
                    std::process::exit(1);
                }
            }
        });
        Self(current)
    }

    fn begin(&self, input: &[u8]) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) =
            Some(Current { begin: Instant::now(), input: input.to_vec() });
    }

    fn end(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(name: &str) -> Plan {
        let folder = std::env::temp_dir().join(format!("crease-search-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        Plan {
            duration: Duration::from_secs(60),
            executions: 20_000,
            longest: 64,
            seed: 1,
            corpus: folder.join("corpus"),
            found: folder.join("found"),
        }
    }

    #[test]
    fn what_breaks_is_found_once_for_each_place_and_saved() {
        fn check(bytes: &[u8]) {
            assert!(bytes.first() != Some(&b'!'), "an exclamation");
            assert!(bytes.len() < 40, "too long");
        }
        let target = Target { name: "test", check, seeds: || vec![b"hello".to_vec()], container: None };
        let plan = plan("breaks");
        let report = search(&target, &plan).unwrap();
        assert_eq!((report.executions, report.found.len()), (20_000, 2), "{report:?}");
        let saved: Vec<Vec<u8>> =
            fs::read_dir(&plan.found).unwrap().map(|entry| fs::read(entry.unwrap().path()).unwrap()).collect();
        assert!(saved.iter().any(|input| input[0] == b'!') && saved.iter().any(|input| input.len() >= 40));
        fs::remove_dir_all(plan.found.parent().unwrap()).unwrap();
    }

    #[test]
    fn what_holds_is_not_found() {
        let target = Target { name: "test", check: |_| (), seeds: || vec![vec![1]], container: None };
        let plan = plan("holds");
        let report = search(&target, &plan).unwrap();
        assert!(report.found.is_empty() && !plan.found.exists());
        fs::remove_dir_all(plan.corpus.parent().unwrap()).unwrap();
    }
}
