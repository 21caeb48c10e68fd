//! The documentation is whole: every name of the element's interface is on its page, every error code has its words.

use std::collections::BTreeSet;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::{files, workspace};

/// The class that the manifest describes.
const CLASS: &str = "CreaseAvatarElement";

/// Every name of the custom-elements manifest is in docs/element.md; `npm run manifest` must have been run.
pub fn check_element() -> Result<()> {
    let manifest = files::read(&workspace::web().join("custom-elements.json"))?;
    let manifest: Value = serde_json::from_str(&manifest).context("web/custom-elements.json: expected JSON")?;
    let page = files::read(&workspace::root().join("docs/element.md"))?;
    require_all(&names(&manifest)?, &page).context("docs/element.md")
}

/// Every code of protocol.ts has a heading in docs/errors.md, and every heading is a code.
pub fn check_errors() -> Result<()> {
    let protocol = files::read(&workspace::web().join("src/internal/protocol.ts"))?;
    let page = files::read(&workspace::root().join("docs/errors.md"))?;
    let documented: BTreeSet<&str> = page.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let codes = error_codes(&protocol)?;
    ensure!(documented == codes, "docs/errors.md: expected the headings {codes:?}, found {documented:?}");
    Ok(())
}

/// The strings of the type `ErrorCode`.
fn error_codes(protocol: &str) -> Result<BTreeSet<&str>> {
    let (_, rest) = protocol.split_once("type ErrorCode =").context("protocol.ts: expected the type ErrorCode")?;
    let (union, _) = rest.split_once(';').context("protocol.ts: expected an end of the type ErrorCode")?;
    Ok(union.split('"').skip(1).step_by(2).collect())
}

/// Attributes, fields that are no attributes, methods, events, slots, parts and custom properties of the element.
fn names(manifest: &Value) -> Result<BTreeSet<String>> {
    let modules = manifest["modules"].as_array().context("the manifest has no modules")?;
    let declarations = modules.iter().filter_map(|module| module["declarations"].as_array()).flatten();
    let class = declarations
        .into_iter()
        .find(|declaration| declaration["name"] == CLASS)
        .with_context(|| format!("the manifest does not have the class {CLASS}"))?;
    let list = |member: &str| class[member].as_array().map_or(&[][..], Vec::as_slice);
    let named = |member: &str| list(member).iter().filter_map(|item| item["name"].as_str()).map(str::to_owned);
    let attributes: BTreeSet<String> = named("attributes").collect();
    ensure!(attributes.contains("src"), "the manifest of {CLASS} does not have the attribute src");
    let members = list("members")
        .iter()
        .filter(|member| member["static"] != true && member["privacy"] != "protected")
        .filter_map(|member| member["name"].as_str())
        .filter(|name| !attributes.contains(&kebab_case(name)));
    let mut all: BTreeSet<String> = members.map(str::to_owned).collect();
    for member in ["events", "slots", "cssParts", "cssProperties"] {
        all.extend(named(member));
    }
    all.extend(attributes);
    Ok(all)
}

/// Each name stands in a heading or between backticks.
fn require_all(names: &BTreeSet<String>, page: &str) -> Result<()> {
    let is_part_of_name = |character: char| character.is_alphanumeric() || "-_".contains(character);
    let headings = page.lines().filter(|line| line.starts_with('#'));
    let code = page.split('`').skip(1).step_by(2).filter(|text| !text.contains('\n'));
    let words: BTreeSet<&str> =
        headings.chain(code).flat_map(|text| text.split(|character: char| !is_part_of_name(character))).collect();
    let missing: Vec<&String> = names.iter().filter(|name| !words.contains(name.as_str())).collect();
    ensure!(missing.is_empty(), "not documented: {missing:?}");
    Ok(())
}

fn kebab_case(camel_case: &str) -> String {
    let spell = |character: char| {
        let hyphen = character.is_uppercase().then_some('-');
        hyphen.into_iter().chain(character.to_lowercase())
    };
    camel_case.chars().flat_map(spell).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_error_code_has_its_words() {
        check_errors().unwrap();
        assert_eq!(error_codes("type ErrorCode =\n  | \"a\"\n  | \"b-c\";\n").unwrap(), BTreeSet::from(["a", "b-c"]));
        assert!(error_codes("type Other = 1;").is_err());
    }

    #[test]
    fn a_name_that_is_not_on_the_page_is_told() {
        let class = json!({
            "name": CLASS,
            "attributes": [{ "name": "src" }, { "name": "playback-rate" }],
            "members": [
                { "name": "playbackRate" }, { "name": "play" }, { "name": "reflect", "privacy": "protected" },
                { "name": "observedAttributes", "static": true },
            ],
            "events": [{ "name": "seeked" }],
            "cssProperties": [{ "name": "--focus-ring" }],
        });
        let names = names(&json!({ "modules": [{ "declarations": [class] }] })).unwrap();
        let page = "# A\n### src\n### play(), pause()\n`playback-rate` and `seeked`\n`--focus-ring`";
        require_all(&names, page).unwrap();
        let error = require_all(&names, &page.replace("seeked", "sought")).unwrap_err().to_string();
        assert_eq!(error, "not documented: [\"seeked\"]");
    }
}
