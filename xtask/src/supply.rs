//! `supply`: what crease is made of. Licences and sources against deny.toml, no runtime dependency in the npm package, a bill of materials.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::{command, workspace};

/// Where the bill goes.
const BILL: &str = "target/crease.cdx.json";

/// A crate as `cargo metadata` tells it.
#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    version: String,
    license: Option<String>,
    license_file: Option<String>,
    source: Option<String>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
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

/// All crates of Cargo.lock, ours too.
fn packages() -> Result<Vec<Package>> {
    let mut cargo = command::cargo("metadata");
    let text = command::output(cargo.args(["--format-version", "1", "--locked", "--all-features"]))?;
    let metadata: Metadata = serde_json::from_str(&text).context("cargo metadata")?;
    Ok(metadata.packages)
}

fn policy() -> Result<Policy> {
    let text = fs::read_to_string(workspace::root().join("deny.toml")).context("cannot read deny.toml")?;
    toml::from_str(&text).context("deny.toml")
}

/// What the policy does not accept, one line each.
fn complaints(packages: &[Package], policy: &Policy) -> Result<Vec<String>> {
    let mut complaints = Vec::new();
    for Package { name, version, license, license_file, source } in packages {
        let licence = license.as_deref().unwrap_or_default();
        if licence.is_empty() {
            complaints.push(format!("{name} {version}: expected a licence, found {license_file:?}"));
        } else if !is_allowed(licence, &policy.licenses.allow)? {
            complaints.push(format!("{name} {version}: expected an accepted licence, found {licence}"));
        }
        if let Some(source) = source
            && !policy.sources.allow_registry.iter().any(|registry| source.strip_prefix("registry+") == Some(registry))
        {
            complaints.push(format!("{name} {version}: expected an accepted source, found {source}"));
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
            "licenses": [{ "expression": package.license.as_deref().unwrap_or("NOASSERTION").replace('/', " OR ") }],
        })
    };
    let (own, others): (Vec<_>, Vec<_>) = packages.iter().partition(|package| package.source.is_none());
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

    fn package(name: &str, licence: Option<&str>, source: Option<&str>) -> Package {
        Package {
            name: name.into(),
            version: "1.0.0".into(),
            license: licence.map(Into::into),
            license_file: None,
            source: source.map(Into::into),
        }
    }

    const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

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
        assert_eq!(of(package("good", Some("MIT/Apache-2.0"), Some(REGISTRY))), "");
        assert_eq!(of(package("choice", Some("GPL-3.0-only OR MIT"), Some(REGISTRY))), "");
        assert!(of(package("copyleft", Some("MIT AND GPL-3.0-only"), Some(REGISTRY))).contains("GPL"));
        assert!(of(package("silent", None, Some(REGISTRY))).contains("expected a licence"));
        assert!(of(package("elsewhere", Some("MIT"), Some("git+https://example.org/a"))).contains("example.org"));
        assert!(of(package("bincode", Some("MIT"), Some(REGISTRY))).contains("unmaintained"));
        assert!(no_runtime_dependencies(r#"{"dependencies": {"left-pad": "1"}}"#).is_err());
    }

    #[test]
    fn the_bill_names_every_foreign_crate() {
        let bill = bill(&[package("crease", Some("MIT"), None), package("glam", Some("MIT/Zlib"), Some(REGISTRY))]);
        assert_eq!(bill["metadata"]["component"]["name"], "crease");
        assert_eq!(bill["components"][0]["purl"], "pkg:cargo/glam@1.0.0");
        assert_eq!(bill["components"][0]["licenses"][0]["expression"], "MIT OR Zlib");
        assert_eq!(bill["components"].as_array().unwrap().len(), 1);
    }
}
