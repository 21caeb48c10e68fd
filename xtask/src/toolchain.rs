//! The compiler for the web: whichever has std's sources here, rustup's or Debian's. std is built anew with what is built: for
//! size and with SIMD.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result};

use crate::{command, progress, workspace};

const TARGET: &str = "wasm32-unknown-unknown";
const RUSTUP_LIMIT: Duration = Duration::from_secs(300);
const RETRY_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

const SIMD: [&str; 2] = ["-C", "target-feature=+simd128"];

/// How std is built.
const STD: [&str; 2] = ["-Zbuild-std=std,panic_abort", "-Zbuild-std-features=optimize_for_size"];

/// Which compiler builds the wasm module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// The compiler that builds everything else, with rustup's component `rust-src`.
    Active,
    /// Debian's `rustc-web` and `rust-web-src`.
    Debian,
}

/// Finds the route that applies here, adding std's sources with rustup where that is possible.
pub fn choose() -> Toolchain {
    if has_sources() || (command::exists("rustup") && !recently_failed() && add_sources()) {
        return Toolchain::Active;
    }
    Toolchain::Debian
}

impl Toolchain {
    /// Cargo for tests and checks of the wasm target, with SIMD.
    pub fn cargo(self, subcommand: &str) -> Command {
        self.cargo_in(workspace::root(), &checks(), &[], subcommand)
    }

    /// Cargo for the wasm target in the repository at `root`, into `target`, with SIMD, std and all dependencies with the compiler's `flags`.
    pub fn cargo_in(self, root: &Path, target: &Path, flags: &[&str], subcommand: &str) -> Command {
        let mut cargo = match self {
            Toolchain::Active => command::cargo(subcommand),
            Toolchain::Debian => debian_cargo(subcommand),
        };
        let flags = SIMD.iter().chain(flags).map(|&flag| flag.to_owned());
        let flags: Vec<String> = flags.chain(self.renamed_paths(root)).collect();
        // A space in a path must not end a flag.
        cargo.env_remove("RUSTFLAGS").env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        // Both compilers are stable ones: std is built anew with what only this lets them do.
        cargo.env("RUSTC_BOOTSTRAP", "1");
        cargo.current_dir(root).args(["--target", TARGET, "--target-dir"]).arg(target).args(STD);
        cargo
    }

    /// Clippy for the wasm target; none where only Debian's compiler can build for it, which comes without.
    pub fn clippy(self) -> Option<Command> {
        if self == Toolchain::Active {
            return Some(self.cargo("clippy"));
        }
        has_compiled_std().then(|| {
            let mut clippy = command::cargo("clippy");
            clippy.args(["--target", TARGET, "--target-dir"]).arg(checks());
            clippy
        })
    }

    /// Flags that keep this machine's folders out of what is built: it would differ elsewhere, and tell where it was made.
    fn renamed_paths(self, root: &Path) -> Vec<String> {
        let rustc = if self == Toolchain::Active { "rustc" } else { "/usr/bin/rustc" };
        let sources = sources_of(rustc);
        // As the precompiled standard library calls itself, whether its sources are installed or not.
        let version = command::output(command::program(rustc).args(["--version", "--verbose"])).unwrap_or_default();
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

/// A folder of their own: the module has other flags, and each would undo the other's work.
fn checks() -> PathBuf {
    workspace::wasm_target().join("checks")
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
    cargo.env("RUSTC", "/usr/bin/rustc");
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld");
    cargo.arg(subcommand);
    cargo
}

/// Whether the active compiler has std's sources.
fn has_sources() -> bool {
    sources_of("rustc").is_some_and(|sources| sources.join("library/std/Cargo.toml").is_file())
}

/// Where the installation of a compiler has std's sources, if it has them.
fn sources_of(rustc: &str) -> Option<PathBuf> {
    let sysroot = command::output(command::program(rustc).args(["--print", "sysroot"])).ok()?;
    Some(Path::new(sysroot.trim()).join("lib/rustlib/src/rust"))
}

/// Whether the active compiler comes with a std for wasm that is compiled already.
fn has_compiled_std() -> bool {
    let printed = command::output(command::program("rustc").args(["--print", "target-libdir", "--target", TARGET]));
    printed.is_ok_and(|folder| has_core(Path::new(folder.trim())))
}

fn has_core(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return false };
    entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
}

fn add_sources() -> bool {
    let added = progress::aloud("Adding the standard library's sources with rustup", || {
        command::run_at_most(command::program("rustup").args(["component", "add", "rust-src"]), RUSTUP_LIMIT)
    });
    let Err(error) = added else { return true };
    eprintln!("rustup cannot add the standard library's sources here ({error:#}): using Debian's compiler");
    if !command::interrupted()
        && let Err(error) = remember_failure()
    {
        eprintln!("{error:#}");
    }
    false
}

/// The note that rustup could not help, so that the next run does not wait for the network again.
fn failure_note() -> PathBuf {
    workspace::wasm_target().join("rustup-has-no-sources")
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
