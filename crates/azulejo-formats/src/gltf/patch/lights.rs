//! Lights that were baked, which must not shine a second time.

use super::additions::Additions;
use super::scan::{elements, find, member};
use super::source::Source;
use super::types::LightsMode;
use serde_json::{Value, json};

/// The extension with the lights.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// The steps to the list of lights.
const LIGHT_LIST: [&str; 3] = ["extensions", LIGHTS, "lights"];

/// The steps to the list of pictures of the surroundings as lights.
const SURROUNDINGS_LIST: [&str; 3] = ["extensions", "EXT_lights_image_based", "lights"];

/// Lights, and the member of the note with what undoes their change.
pub const DIMMED: [(&str, [&str; 3]); 2] = [
    ("baked", LIGHT_LIST),
    ("baked_surroundings", SURROUNDINGS_LIST),
];

/// Dims or removes the lights, and returns what undoes it, by the members of the note: for each light that was
/// dimmed its number and the text of its intensity, `null` if it had none. Surroundings are dimmed in either case.
pub fn change(
    source: &Source,
    mode: LightsMode,
    additions: &mut Additions,
) -> Vec<(&'static str, Vec<Value>)> {
    let mut dimmed = |(member, steps)| (member, dim(source, &steps, additions));
    match mode {
        LightsMode::Keep => Vec::new(),
        LightsMode::Dim => DIMMED.map(dimmed).into(),
        LightsMode::Remove => {
            let surroundings = dimmed(DIMMED[1]);
            remove(source, additions);
            vec![surroundings]
        }
    }
}

fn dim(source: &Source, steps: &[&'static str; 3], additions: &mut Additions) -> Vec<Value> {
    let text = source.text();
    let list = source.find(steps).and_then(|list| elements(text, &list));
    let mut baked = Vec::new();
    for (i, light) in list.into_iter().flatten().enumerate() {
        let old = member(text, &light, "intensity").map(|span| &text[span]);
        if old.and_then(|old| old.parse().ok()) == Some(0.0) {
            continue;
        }
        let [extensions, name, list] = *steps;
        let lights = additions.edit.key(extensions).key(name).key(list);
        lights.index(i).key("intensity").set("0");
        baked.push(json!([i, old]));
    }
    baked
}

fn remove(source: &Source, additions: &mut Additions) {
    for (i, node) in source.list("nodes").iter().enumerate() {
        let steps = ["extensions", LIGHTS];
        if find(source.text(), node, &steps).is_some() {
            let node = additions.edit.key("nodes").index(i);
            node.key("extensions").key(LIGHTS).remove();
        }
    }
}
