//! A set of texture coordinates that no picture uses.

use super::source::Source;
use serde_json::Value;
use std::collections::HashSet;

/// Extensions whose own lightmap is replaced.
const LIGHTMAPS: [&str; 2] = ["MOZ_lightmap", "MX_lightmap"];

/// Sets of texture coordinates that a primitive may have: every one below that of the lightmap must be there.
const MOST_SETS: u32 = 8;

/// The first set from `wished` on that none of the materials uses, if there is one.
pub fn of(source: &Source, materials: &HashSet<usize>, wished: u32) -> Option<u32> {
    let entries = source.list("materials");
    let mut used = HashSet::new();
    for material in materials {
        let text = entries
            .get(*material)
            .map(|span| &source.text()[span.clone()]);
        let json = text.and_then(|text| serde_json::from_str::<Value>(text).ok());
        json.iter().for_each(|json| add_used(json, &mut used));
    }
    (wished..MOST_SETS).find(|set| !used.contains(&u64::from(*set)))
}

/// Adds the sets that the textures in a value use.
fn add_used(value: &Value, used: &mut HashSet<u64>) {
    match value {
        Value::Object(members) => {
            let set = members.get("texCoord").and_then(Value::as_u64);
            // References to textures have an index, and set 0 if they name none.
            let first = members.get("index").map(|_| 0);
            used.extend(set.or(first));
            for (_, inner) in members
                .iter()
                .filter(|(key, _)| !LIGHTMAPS.contains(&key.as_str()))
            {
                add_used(inner, used);
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| add_used(inner, used)),
        _ => {}
    }
}
