//! `supply`: what crease is made of. Licences and sources against deny.toml, no runtime dependency in the npm package, a bill of materials.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::{command, workspace};

/// Where the bill goes.
const BILL: &str = "target/crease.cdx.json";

/// A crate that is built, for whatever target and feature.
#[derive(Debug)]
struct Package {
    name: String,
    version: String,
    /// SPDX; empty where none is stated.
    licence: String,
    /// Where it comes from, if not from the registry.
    source: Option<String>,
}

/// The part of deny.toml that is looked at here.
#[derive(Deserialize)]
struct Policy {
    licenses: Licences,
    sources: Sources,
    bans: Bans,
}

#[derive(Deserialize)]
struct Licences {
    allow: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Sources {
    allow_registry: Vec<String>,
}

#[derive(Deserialize)]
struct Bans {
    deny: Vec<Banned>,
}

#[derive(Deserialize)]
struct Banned {
    name: String,
    reason: String,
}

/// Checks, writes the bill and prints a summary.
pub fn run() -> Result<()> {
    let packages = packages()?;
    let policy = policy()?;
    let complaints = complaints(&packages, &policy)?;
    ensure!(complaints.is_empty(), "deny.toml:\n  {}", complaints.join("\n  "));
    no_runtime_dependencies(&fs::read_to_string(workspace::web().join("package.json"))?)?;
    let bill = serde_json::to_string_pretty(&bill(&packages))? + "\n";
    fs::write(workspace::root().join(BILL), bill).with_context(|| format!("cannot write {BILL}"))?;
    let twice = twice(&packages);
    println!("{} crates, every licence and source accepted; {BILL}", packages.len());
    println!("{} in more than one version: {}", twice.len(), twice.join(", "));
    Ok(())
}

/// All crates that are built, ours too.
fn packages() -> Result<Vec<Package>> {
    let mut cargo = command::cargo("tree");
    cargo.args(["--workspace", "--all-features", "--target", "all", "--edges", "normal,build,dev", "--locked"]);
    let text = command::output(cargo.args(["--prefix", "none", "--format", "{p}|{l}"]))?;
    let packages: BTreeMap<(String, String), Package> = text
        .lines()
        .filter_map(parse)
        .map(|package| ((package.name.clone(), package.version.clone()), package))
        .collect();
    ensure!(!packages.is_empty(), "cargo tree lists no crates");
    Ok(packages.into_values().collect())
}

/// `name vVERSION|LICENCE`; a crate from elsewhere has `(its address)` before the bar, a procedural macro says so.
fn parse(line: &str) -> Option<Package> {
    let (crate_, licence) = line.trim_end_matches(" (*)").split_once('|')?;
    let mut words = crate_.split(' ');
    let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
    let source = words.find(|word| *word != "(proc-macro)" && *word != "(*)");
    let source = source.map(|word| word.trim_matches(['(', ')']).to_owned());
    Some(Package { name: name.into(), version: version.into(), licence: licence.into(), source })
}

fn policy() -> Result<Policy> {
    let text = fs::read_to_string(workspace::root().join("deny.toml")).context("cannot read deny.toml")?;
    toml::from_str(&text).context("deny.toml")
}

/// What the policy does not accept, one line each.
fn complaints(packages: &[Package], policy: &Policy) -> Result<Vec<String>> {
    let mut complaints = Vec::new();
    for Package { name, version, licence, source } in packages {
        if licence.is_empty() {
            complaints.push(format!("{name} {version}: expected a licence, found none"));
        } else if !is_allowed(licence, &policy.licenses.allow)? {
            complaints.push(format!("{name} {version}: expected an accepted licence, found {licence}"));
        }
        // Nothing but the registry that is named, and this repository.
        if let Some(source) = source.as_ref().filter(|source| !Path::new(source).starts_with(workspace::root())) {
            let allowed = policy.sources.allow_registry.join(", ");
            complaints.push(format!("{name} {version}: expected a source of {allowed}, found {source}"));
        }
        if let Some(ban) = policy.bans.deny.iter().find(|ban| ban.name == *name) {
            complaints.push(format!("{name} {version}: banned: {}", ban.reason));
        }
    }
    Ok(complaints)
}

/// Whether an SPDX expression can be met with accepted licences alone; crates of old write `/` for OR.
fn is_allowed(expression: &str, allowed: &[String]) -> Result<bool> {
    let parsed = spdx::Expression::parse_mode(expression, spdx::ParseMode::LAX)
        .with_context(|| format!("{expression:?} is no licence expression"))?;
    Ok(parsed.evaluate(|requirement| allowed.iter().any(|name| *name == requirement.to_string())))
}

/// Crates in several versions, which cost room and time.
fn twice(packages: &[Package]) -> Vec<&str> {
    let mut counts = BTreeMap::new();
    for package in packages {
        *counts.entry(package.name.as_str()).or_insert(0) += 1;
    }
    counts.into_iter().filter(|(_, count)| *count > 1).map(|(name, _)| name).collect()
}

/// The npm package brings nothing else into a page.
fn no_runtime_dependencies(package: &str) -> Result<()> {
    let package: Value = serde_json::from_str(package).context("web/package.json")?;
    for field in ["dependencies", "peerDependencies", "optionalDependencies", "bundleDependencies"] {
        if let Some(found) = package.get(field) {
            bail!("web/package.json: {field}: expected none, found {found}");
        }
    }
    Ok(())
}

/// CycloneDX 1.5.
fn bill(packages: &[Package]) -> Value {
    let component = |package: &Package| {
        let reference = format!("pkg:cargo/{}@{}", package.name, package.version);
        json!({
            "type": "library",
            "bom-ref": reference,
            "name": package.name,
            "version": package.version,
            "purl": reference,
            "licenses": [{ "expression": package.licence.replace('/', " OR ") }],
        })
    };
    let (own, others): (Vec<_>, Vec<_>) = packages.iter().partition(|package| package.source.is_some());
    let mut components: Vec<Value> = others.into_iter().map(component).collect();
    components.sort_by_key(|component| component["bom-ref"].to_string());
    let crease = own.into_iter().find(|package| package.name == "crease").map(component);
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": crease },
        "components": components,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, licence: &str, source: Option<&str>) -> Package {
        Package { name: name.into(), version: "1.0.0".into(), licence: licence.into(), source: source.map(Into::into) }
    }

    fn own() -> String {
        workspace::root().display().to_string()
    }

    #[test]
    fn lines_of_the_tree_are_understood() {
        let line = |text: &str| {
            let Package { name, version, licence, source } = parse(text)?;
            Some((name, version, licence, source))
        };
        let expected = |source: Option<&str>| Some(("a".into(), "1.2.3".into(), "MIT".into(), source.map(Into::into)));
        assert_eq!(line("a v1.2.3|MIT"), expected(None));
        assert_eq!(line("a v1.2.3 (proc-macro)|MIT (*)"), expected(None));
        assert_eq!(line("a v1.2.3 (/home/a)|MIT"), expected(Some("/home/a")));
        assert_eq!(line("a v1.2.3 (https://example.org/a#1)|MIT"), expected(Some("https://example.org/a#1")));
        assert_eq!(line("[dev-dependencies]"), None);
    }

    #[test]
    fn everything_in_the_lock_file_is_accepted() {
        let complaints = complaints(&packages().unwrap(), &policy().unwrap()).unwrap();
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));
        let package = fs::read_to_string(workspace::web().join("package.json")).unwrap();
        no_runtime_dependencies(&package).unwrap();
    }

    #[test]
    fn what_is_not_accepted_is_named() {
        let policy = policy().unwrap();
        let of = |package: Package| complaints(&[package], &policy).unwrap().join("\n");
        assert_eq!(of(package("good", "MIT/Apache-2.0", None)), "");
        assert_eq!(of(package("choice", "GPL-3.0-only OR MIT", None)), "");
        assert_eq!(of(package("own", "MIT", Some(&own()))), "");
        assert!(of(package("copyleft", "MIT AND GPL-3.0-only", None)).contains("GPL"));
        assert!(of(package("silent", "", None)).contains("expected a licence"));
        assert!(of(package("elsewhere", "MIT", Some("https://example.org/a#1"))).contains("example.org"));
        assert!(of(package("bincode", "MIT", None)).contains("unmaintained"));
        assert!(no_runtime_dependencies(r#"{"dependencies": {"left-pad": "1"}}"#).is_err());
    }

    #[test]
    fn the_bill_names_every_foreign_crate() {
        let bill = bill(&[package("crease", "MIT", Some(&own())), package("glam", "MIT/Zlib", None)]);
        assert_eq!(bill["metadata"]["component"]["name"], "crease");
        assert_eq!(bill["components"][0]["purl"], "pkg:cargo/glam@1.0.0");
        assert_eq!(bill["components"][0]["licenses"][0]["expression"], "MIT OR Zlib");
        assert_eq!(bill["components"].as_array().unwrap().len(), 1);
    }
}
