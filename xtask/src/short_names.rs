//! Short names for what the wasm module and its bindings give each other: both are downloaded, and nobody reads the long ones.

use std::ops::Range;

use anyhow::{Result, ensure};
use wasm_encoder::{EntityType, ExportKind, ExportSection, ImportSection, Module, RawSection};
use wasmparser::{ExternalKind, Parser, Payload, TypeRef};

const THREAD_END: &str = "__wbindgen_thread_destroy";

/// `module` and the `script` that binds it, as wasm-bindgen writes them under `out_name`, with short names for the functions between them.
///
/// Fails where the script has a name in another place than wasm-bindgen puts it.
pub fn shorten(module: &[u8], script: &str, out_name: &str) -> Result<(Vec<u8>, String)> {
    // Where the bindings wait for the module's imports.
    let from = format!("./{out_name}_bg.js");
    let mut script = script.to_owned();
    let mut names = (0..).map(short_name);
    let mut shortened = Module::new();
    for payload in Parser::new(0).parse_all(module) {
        match payload? {
            Payload::ImportSection(section) => {
                let mut imports = ImportSection::new();
                for import in section.into_imports() {
                    let import = import?;
                    ensure!(
                        import.module == from,
                        "{}: expected to be of {from}, found {}",
                        import.name,
                        import.module
                    );
                    let index = match import.ty {
                        TypeRef::Func(index) => index,
                        TypeRef::Memory(memory) => {
                            imports.import("a", import.name, wasm_encoder::MemoryType::from(memory));
                            continue;
                        }
                        other => anyhow::bail!(
                            "{}: expected a function or a memory to be imported, found {other:?}",
                            import.name
                        ),
                    };
                    let name = names.next().unwrap_or_default();
                    replace_once(&mut script, &format!("\n        {}: ", import.name), &format!("\n        {name}: "))?;
                    imports.import("a", &name, EntityType::Function(index));
                }
                shortened.section(&imports);
            }
            Payload::ExportSection(section) => {
                let mut exports = ExportSection::new();
                for export in section {
                    let export = export?;
                    if export.kind == ExternalKind::Func {
                        let uses = uses(&script, &format!("wasm.{}", export.name));
                        // wasm-bindgen exports what ends a thread, whether its script does that or not.
                        if uses.is_empty() && export.name == THREAD_END {
                            continue;
                        }
                        ensure!(
                            !uses.is_empty(),
                            "the module's bindings: expected wasm.{}, found it nowhere",
                            export.name
                        );
                        let name = names.next().unwrap_or_default();
                        script = with_replaced(&script, &uses, &format!("wasm.{name}"));
                        exports.export(&name, ExportKind::Func, export.index);
                    } else {
                        exports.export(export.name, export.kind.into(), export.index);
                    }
                }
                shortened.section(&exports);
            }
            payload => {
                if let Some((id, range)) = payload.as_section() {
                    shortened.section(&RawSection { id, data: &module[range] });
                }
            }
        }
    }
    replace_once(&mut script, &format!("\"{from}\": import0"), "a: import0")?;
    Ok((shortened.finish(), script))
}

/// `a`, `b` … `z`, `aa`, `ba` …
fn short_name(mut number: usize) -> String {
    let mut name = String::new();
    loop {
        name.push(char::from(b'a' + (number % 26) as u8));
        number /= 26;
        if number == 0 {
            return name;
        }
        number -= 1;
    }
}

fn replace_once(text: &mut String, from: &str, to: &str) -> Result<()> {
    let count = text.matches(from).count();
    ensure!(count == 1, "the module's bindings: expected {from:?} once, found it {count} times");
    *text = text.replacen(from, to, 1);
    Ok(())
}

/// Where `name` stands in `text` as no longer word's beginning.
fn uses(text: &str, name: &str) -> Vec<Range<usize>> {
    text.match_indices(name)
        .map(|(at, _)| at..at + name.len())
        .filter(|place| !text[place.end..].starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_' || c == '$'))
        .collect()
}

/// `text` with `to` at all of `places`.
fn with_replaced(text: &str, places: &[Range<usize>], to: &str) -> String {
    let mut replaced = String::with_capacity(text.len());
    let mut copied = 0;
    for place in places {
        replaced.push_str(&text[copied..place.start]);
        replaced.push_str(to);
        copied = place.end;
    }
    replaced + &text[copied..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use wasm_encoder::{CodeSection, Function, FunctionSection, TypeSection};

    /// A module with one import, one function that calls it, and two exports of it.
    fn module() -> Vec<u8> {
        let (mut types, mut imports, mut functions) =
            (TypeSection::new(), ImportSection::new(), FunctionSection::new());
        types.ty().function([], []);
        imports.import("./crease_bg.js", "__wbg_log_0123456789abcdef", EntityType::Function(0));
        functions.function(0);
        let (mut exports, mut code) = (ExportSection::new(), CodeSection::new());
        exports.export("viewer_draw", ExportKind::Func, 1);
        exports.export("viewer_drawn", ExportKind::Func, 1);
        let mut body = Function::new([]);
        body.instructions().call(0).end();
        code.function(&body);
        let mut module = Module::new();
        module.section(&types).section(&imports).section(&functions).section(&exports).section(&code);
        module.finish()
    }

    const SCRIPT: &str = "draw() { wasm.viewer_draw(1); wasm.viewer_drawn(wasm.viewer_draw); }
    const import0 = {
        __wbg_log_0123456789abcdef: function() {},
    };
    return {
        \"./crease_bg.js\": import0,
    };
";

    #[test]
    fn both_sides_get_the_same_short_names() {
        let (short, script) = shorten(&module(), SCRIPT, "crease").unwrap();
        assert!(script.contains("wasm.b(1); wasm.c(wasm.b);"), "{script}");
        assert!(script.contains("\n        a: function() {}") && script.contains("        a: import0"), "{script}");
        let mut names = Vec::new();
        for payload in Parser::new(0).parse_all(&short) {
            match payload.unwrap() {
                Payload::ImportSection(section) => {
                    names.extend(section.into_imports().map(|import| import.unwrap().name.to_owned()));
                }
                Payload::ExportSection(section) => {
                    names.extend(section.into_iter().map(|export| export.unwrap().name.to_owned()));
                }
                _ => {}
            }
        }
        assert_eq!(names, ["a", "b", "c"]);
        assert!(short.len() < module().len());
    }

    #[test]
    fn a_script_of_another_module_is_refused() {
        let error = shorten(&module(), &SCRIPT.replace("0123456789abcdef", "f"), "crease").unwrap_err().to_string();
        assert!(error.contains("__wbg_log_0123456789abcdef") && error.contains("0 times"), "{error}");
        let error = shorten(&module(), &SCRIPT.replace("viewer_drawn", "other"), "crease").unwrap_err().to_string();
        assert!(error.contains("wasm.viewer_drawn"), "{error}");
    }

    #[test]
    fn no_name_comes_twice() {
        let names: std::collections::BTreeSet<String> = (0..2000).map(short_name).collect();
        assert_eq!(names.len(), 2000);
        assert_eq!([0, 25, 26, 27, 52].map(short_name), ["a", "z", "aa", "ba", "ab"]);
    }
}
