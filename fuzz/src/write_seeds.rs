//! Writes a target's valid inputs as files: `seeds TARGET FOLDER`. Without arguments, prints the names of all targets.

use crease_fuzz::{TARGETS, target};
use std::path::Path;

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, folder] = arguments.as_slice() else {
        TARGETS.iter().for_each(|target| println!("{}", target.name));
        return Ok(());
    };
    let target = target(name).ok_or_else(|| std::io::Error::other(format!("{name}: expected the name of a target")))?;
    std::fs::create_dir_all(folder)?;
    for (index, seed) in (target.seeds)().iter().enumerate() {
        std::fs::write(Path::new(folder).join(format!("seed-{index}")), seed)?;
    }
    Ok(())
}
