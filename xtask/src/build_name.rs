//! The name of a build, written into the scripts and the wasm module: files of two builds, mixed by a cache, do not work together.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use sha2::{Digest, Sha256};

use crate::wasm::Form;
use crate::{files, workspace};

/// Name of the custom section that holds it; web/src/internal/module.ts looks for it.
const SECTION: &str = "crease-build";

const TYPES: &str = "/** The build that these scripts belong to. */
export const BUILD: string;
/** Where its wasm module is. */
export const MODULE_URL: URL;
/** Where the module is that runs on several threads. */
export const THREADS_MODULE_URL: URL;
";

/// Names the build by what the scripts and the modules in `folder` are made of, in `build.js` and in a section of each module.
pub fn write(folder: &Path) -> Result<()> {
    let paths = Form::ALL.map(|form| folder.join(form.module()));
    let read = |path: &PathBuf| fs::read(path).with_context(|| format!("cannot read {}", workspace::relative(path)));
    let stamped = paths.iter().map(read).collect::<Result<Vec<_>>>()?;
    let build = name(&stamped, folder)?;
    for (path, stamped) in paths.iter().zip(&stamped) {
        let wanted = with_section(without_section(stamped), &build)?;
        if &wanted != stamped {
            fs::write(path, wanted).with_context(|| format!("cannot write {}", workspace::relative(path)))?;
        }
    }
    let mut code = format!("export const BUILD = \"{build}\";\n");
    for (constant, form) in [("MODULE_URL", Form::Single), ("THREADS_MODULE_URL", Form::Threads)] {
        // Bundlers know a file that belongs to a script by these very words.
        code += &format!("export const {constant} = new URL(\"{}\", import.meta.url);\n", form.module());
    }
    for (file, text) in [("build.js", code.as_str()), ("build.d.ts", TYPES)] {
        let path = folder.join(file);
        if !fs::read_to_string(&path).is_ok_and(|found| found == text) {
            files::write(&path, text)?;
        }
    }
    Ok(())
}

/// The release, and a hash of the modules, their bindings and the element's sources.
fn name(modules: &[Vec<u8>], folder: &Path) -> Result<String> {
    let mut hash = Sha256::new();
    modules.iter().for_each(|module| hash.update(without_section(module)));
    let mut scripts = vec![folder.join("webgl2_shaders.js")];
    scripts.extend(Form::ALL.map(|form| folder.join(form.bindings())));
    scripts.extend(files::below(&workspace::web().join("src"))?);
    for script in scripts {
        hash.update(files::read(&script)?);
    }
    Ok(format!("{}-{}", env!("CARGO_PKG_VERSION"), files::hex(&hash.finalize()[..6])))
}

/// The module with a last section that holds `build`.
fn with_section(module: &[u8], build: &str) -> Result<Vec<u8>> {
    let size = 1 + SECTION.len() + build.len();
    ensure!(size < 128, "the name of a build: expected a short one, found {build}");
    Ok([module, &[0, size as u8, SECTION.len() as u8], SECTION.as_bytes(), build.as_bytes()].concat())
}

/// The module without the section that [`with_section`] added, if there is one.
fn without_section(module: &[u8]) -> &[u8] {
    let name = SECTION.as_bytes();
    let start = module.windows(name.len()).rposition(|window| window == name).and_then(|at| at.checked_sub(3));
    match start {
        Some(start) if module[start] == 0 && start + 2 + usize::from(module[start + 1]) == module.len() => {
            &module[..start]
        }
        _ => module,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_is_added_and_taken_away() {
        let module = b"\0asm\x01\0\0\0";
        let stamped = with_section(module, "1.2.3-abc").unwrap();
        assert_eq!(&stamped[..8], module);
        assert_eq!(stamped[8..11], [0, 22, 12]);
        assert_eq!(&stamped[11..], b"crease-build1.2.3-abc");
        assert_eq!(without_section(&stamped), module);
        assert_eq!(without_section(module), module);
        // The same words elsewhere are no section of ours.
        let mut longer = stamped.clone();
        longer.push(0);
        assert_eq!(without_section(&longer), longer);
        assert!(with_section(module, &"long".repeat(40)).is_err());
    }
}
