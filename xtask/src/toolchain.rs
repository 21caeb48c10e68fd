//! The compiler for the web: rustup's own wasm target where it can be had, else Debian's compiler with std built anew.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result};

use crate::{command, progress, workspace};

const TARGET: &str = "wasm32-unknown-unknown";
const RUSTUP_LIMIT: Duration = Duration::from_secs(300);
const RETRY_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Which compiler builds the wasm module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The compiler that builds everything else; its precompiled std for wasm is installed.
    Active,
    /// Debian's `rustc-web`, which ships std as source.
    Debian,
}

/// Finds the route that applies here, adding rustup's wasm target where that is possible.
pub fn choose() -> Result<Toolchain> {
    if std_is_installed() {
        return Ok(Toolchain::Active);
    }
    if command::exists("rustup") && !recently_failed() && add_target() {
        return Ok(Toolchain::Active);
    }
    Ok(Toolchain::Debian)
}

impl Toolchain {
    /// Cargo for the wasm target, with SIMD, into a target folder of its own.
    pub fn cargo(self, subcommand: &str) -> Command {
        self.cargo_in(workspace::root(), &workspace::wasm_target(), subcommand)
    }

    /// The same for the repository at `root`, into `target`.
    pub fn cargo_in(self, root: &Path, target: &Path, subcommand: &str) -> Command {
        let mut cargo = match self {
            Toolchain::Active => command::cargo(subcommand),
            Toolchain::Debian => debian_cargo(subcommand),
        };
        let flags = ["-C", "target-feature=+simd128"].map(str::to_owned).into_iter().chain(self.renamed_paths(root));
        let flags: Vec<String> = flags.collect();
        // A space in a path must not end a flag.
        cargo.env_remove("RUSTFLAGS").env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        cargo.current_dir(root).args(["--target", TARGET, "--target-dir"]).arg(target);
        if self == Toolchain::Debian {
            cargo.arg("-Zbuild-std=std,panic_abort");
        }
        cargo
    }

    /// Flags that keep this machine's folders out of what is built: it would differ elsewhere, and tell where it was made.
    fn renamed_paths(self, root: &Path) -> Vec<String> {
        let rustc = |arguments: &[&str]| {
            let name = if self == Toolchain::Active { "rustc" } else { "/usr/bin/rustc" };
            command::output(command::program(name).args(arguments)).ok()
        };
        let sources = rustc(&["--print", "sysroot"]).map(|root| Path::new(root.trim()).join("lib/rustlib/src/rust"));
        // As the precompiled standard library calls itself, whether its sources are installed or not.
        let version = rustc(&["--version", "--verbose"]).unwrap_or_default();
        let commit = version.lines().find_map(|line| line.strip_prefix("commit-hash: ")).unwrap_or("unknown");
        let standard_library = format!("/rustc/{commit}");
        let crates = std::env::var_os("CARGO_HOME").map(PathBuf::from);
        let crates =
            crates.or_else(|| Some(std::env::home_dir()?.join(".cargo"))).map(|home| home.join("registry/src"));
        let renamed = [(Some(root.to_owned()), "crease"), (crates, "crates"), (sources, &standard_library)];
        let flag =
            |(path, name): (Option<PathBuf>, &str)| Some(format!("--remap-path-prefix={}={name}", path?.display()));
        renamed.into_iter().filter_map(flag).collect()
    }

    /// Where a profile's outputs for the wasm target lie.
    pub fn output_folder(self, target: &Path, profile: &str) -> PathBuf {
        target.join(TARGET).join(profile)
    }
}

fn debian_cargo(subcommand: &str) -> Command {
    let mut cargo = command::program("/usr/bin/cargo");
    command::forget_outer_cargo(&mut cargo);
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        if ["RUST", "CARGO_BUILD_", "CARGO_PROFILE_"].iter().any(|prefix| text.starts_with(prefix)) || text == "CARGO" {
            cargo.env_remove(&name);
        }
    }
    // Debian's compiler is a stable one; building std anew needs the switch for unstable features.
    cargo.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld");
    cargo.arg(subcommand);
    cargo
}

fn std_is_installed() -> bool {
    let printed = command::output(command::program("rustc").args(["--print", "target-libdir", "--target", TARGET]));
    printed.is_ok_and(|folder| has_core(Path::new(folder.trim())))
}

fn has_core(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return false };
    entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
}

fn add_target() -> bool {
    let added = progress::aloud("Adding the wasm target with rustup", || {
        command::run_at_most(command::program("rustup").args(["target", "add", TARGET]), RUSTUP_LIMIT)
    });
    let Err(error) = added else { return true };
    eprintln!("rustup cannot add the wasm target here ({error:#}): using Debian's compiler");
    if !command::interrupted()
        && let Err(error) = remember_failure()
    {
        eprintln!("{error:#}");
    }
    false
}

/// The note that rustup could not help, so that the next run does not wait for the network again.
fn failure_note() -> PathBuf {
    workspace::wasm_target().join("rustup-has-no-wasm-target")
}

fn remember_failure() -> Result<()> {
    let note = failure_note();
    fs::create_dir_all(workspace::wasm_target())
        .and_then(|()| fs::write(&note, "Tried again a day later, or when this file is gone.\n"))
        .with_context(|| format!("cannot write {}", workspace::relative(&note)))
}

fn recently_failed() -> bool {
    let age = fs::metadata(failure_note()).and_then(|note| note.modified()).map(|time| time.elapsed());
    matches!(age, Ok(Ok(age)) if age < RETRY_AFTER)
}
