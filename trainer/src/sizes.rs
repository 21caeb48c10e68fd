//! How many bytes of an avatar's file each of its parts takes.

use anyhow::{Context, ensure};
use serde_json::Value;
use std::collections::BTreeMap;

/// (part, bytes) of a GLB, largest first. Parts are the extension's fields; what belongs to glTF itself is "skinned mesh" and "texture";
/// "JSON" is the description of all.
pub fn section_sizes(glb: &[u8]) -> anyhow::Result<Vec<(String, usize)>> {
    let length = glb.get(12..16).context("GLB: expected a JSON chunk, found the end of the file")?;
    let length = u32::from_le_bytes(length.try_into().expect("four bytes")) as usize;
    let json =
        glb.get(20..).and_then(|rest| rest.get(..length)).context("GLB: expected a whole JSON chunk, found less")?;
    let document: Value = serde_json::from_slice(json).context("GLB: JSON chunk")?;
    let views = document["bufferViews"].as_array().context("GLB: bufferViews: expected an array, found none")?;
    let sizes: Vec<usize> = views.iter().map(|view| view["byteLength"].as_u64().unwrap_or(0) as usize).collect();

    let mut owners = vec![None; sizes.len()];
    for extension in document["extensions"].as_object().into_iter().flat_map(|map| map.values()) {
        for (field, value) in extension.as_object().into_iter().flatten() {
            claim(value, field, &mut owners);
        }
    }
    claim(&document["images"], "texture", &mut owners);
    claim(&document["accessors"], "skinned mesh", &mut owners);

    let mut sections = BTreeMap::from([("JSON".to_owned(), length)]);
    for (owner, size) in owners.into_iter().zip(&sizes) {
        *sections.entry(owner.unwrap_or_else(|| "unclaimed".to_owned())).or_default() += size;
    }
    let mut sections: Vec<(String, usize)> = sections.into_iter().collect();
    sections.sort_by_key(|section| std::cmp::Reverse(section.1));
    ensure!(sections.iter().map(|section| section.1).sum::<usize>() <= glb.len(), "GLB: parts larger than the file");
    Ok(sections)
}

/// Gives `owner` every buffer view that `value` names and that nobody has yet.
fn claim(value: &Value, owner: &str, owners: &mut [Option<String>]) {
    match value {
        Value::Array(values) => values.iter().for_each(|value| claim(value, owner, owners)),
        Value::Object(map) => {
            let view = map.get("bufferView").and_then(Value::as_u64);
            if let Some(place) = view.and_then(|view| owners.get_mut(view as usize)) {
                place.get_or_insert_with(|| owner.to_owned());
            }
            map.values().for_each(|value| claim(value, owner, owners));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{compact_avatar, plain_avatar};

    #[test]
    fn parts_cover_the_file() {
        for avatar in [compact_avatar(), plain_avatar()] {
            let bytes = avatar.write();
            let sections = section_sizes(&bytes).unwrap();
            let total: usize = sections.iter().map(|section| section.1).sum();
            assert!(total > bytes.len() * 9 / 10, "{total} of {}: {sections:?}", bytes.len());
            let has = |name: &str| sections.iter().any(|section| section.0 == name && section.1 > 0);
            assert!(has("deformation") && has("laplacian") && has("factor") && has("skinned mesh"), "{sections:?}");
            assert!(!has("unclaimed"));
        }
    }

    #[test]
    fn a_cut_file_is_an_error() {
        let bytes = compact_avatar().write();
        assert!(section_sizes(&bytes[..40]).is_err());
        assert!(section_sizes(&[]).is_err());
    }
}
