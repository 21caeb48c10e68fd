//! `faults`: what happens to a training run that is killed, starved, robbed of its input or told to stop; and that what is taken up again
//! ends as an undisturbed run does, bit for bit.

mod cases;
mod trial;

use std::fs;

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::{command, lint, workspace};
use trial::{Preset, Trial};

/// How often to kill.
#[derive(Args)]
pub struct Options {
    /// Random moments at which each preset's run is killed
    #[arg(long, default_value_t = 20)]
    kills: u32,
    /// Where the random moments start from
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// One line of the table.
#[derive(serde::Serialize)]
struct Row {
    fault: String,
    happened: String,
    /// Whether the run, taken up again, gave the undisturbed run's bytes; none where nothing could be tried.
    same: Option<bool>,
}

/// Builds the trainer, tries every fault, prints a table and writes target/faults.json. An error where a run did not end as it should.
pub fn run(options: &Options) -> Result<()> {
    let mut build = command::cargo("build");
    // The same selection and features as the tests': what they built is used here.
    build.args(["--workspace", "--bin", "crease", "--example", "write_sequence"]).args(lint::FEATURES);
    command::run(&mut build)?;

    let mut rows = Vec::new();
    for preset in [Preset::Compact, Preset::Paper] {
        let trial = Trial::new(preset)?;
        eprintln!("{}: undisturbed in {:.1} s", preset.name(), trial.duration.as_secs_f64());
        for (name, case) in cases::all(options.kills, options.seed) {
            let fault = format!("{}: {name}", preset.name());
            let row = match case(&trial) {
                Ok(Some(happened)) => Row { fault, happened, same: Some(true) },
                Ok(None) => Row { fault, happened: "not tried: mounting needs root on Linux".into(), same: None },
                Err(error) => Row { fault, happened: format!("{error:#}"), same: Some(false) },
            };
            eprintln!("{}: {}", row.fault, row.happened);
            rows.push(row);
            if command::interrupted() {
                anyhow::bail!("interrupted");
            }
        }
    }
    println!("| fault | what happened | same bytes after going on |\n|---|---|---|");
    for Row { fault, happened, same } in &rows {
        let same = same.map_or("not tried", |same| if same { "yes" } else { "NO" });
        println!("| {fault} | {happened} | {same} |");
    }
    let record = workspace::root().join("target/faults.json");
    fs::write(&record, serde_json::to_string_pretty(&rows)? + "\n").context("cannot write target/faults.json")?;
    let failed = rows.iter().filter(|row| row.same == Some(false)).count();
    ensure!(failed == 0, "{failed} faults left damage");
    Ok(())
}
