//! Searches for inputs that break a target, and prints a line of JSON about it; without a target, prints the names of all.

use clap::Parser;
use crease_fuzz::allocation::Counted;
use crease_fuzz::search::{Plan, search};
use crease_fuzz::{TARGETS, target};
use std::path::PathBuf;
use std::time::Duration;

#[global_allocator]
static ALLOCATOR: Counted = Counted;

#[derive(Parser)]
struct Arguments {
    /// The target
    target: Option<String>,
    #[arg(long, default_value_t = 60)]
    seconds: u64,
    #[arg(long, default_value_t = u64::MAX)]
    executions: u64,
    #[arg(long, default_value_t = 16384)]
    longest: usize,
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[arg(long, default_value = "corpus")]
    corpus: PathBuf,
    #[arg(long, default_value = "found")]
    found: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let Arguments { target: name, seconds, executions, longest, seed, corpus, found } = Arguments::parse();
    let Some(name) = name else {
        TARGETS.iter().for_each(|target| println!("{}", target.name));
        return Ok(());
    };
    let target = target(&name).ok_or_else(|| anyhow::anyhow!("target: expected the name of one, found {name}"))?;
    // Small inputs gain nothing from threads, and waking one takes longer than reading them.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let plan = Plan { duration: Duration::from_secs(seconds), executions, longest, seed, corpus, found };
    println!("{}", serde_json::to_string(&search(target, &plan)?)?);
    Ok(())
}
