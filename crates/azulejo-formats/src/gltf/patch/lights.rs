//! Lights that were baked, which must not shine a second time.

use super::additions::Additions;
use super::scan::{elements, find, member};
use super::source::Source;
use super::types::LightsMode;
use serde_json::{Value, json};

/// The extension with the lights.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// The steps to the list of lights.
pub const LIGHT_LIST: [&str; 3] = ["extensions", LIGHTS, "lights"];

/// Dims or removes the lights, and returns what undoes it: for each light that was dimmed its number and
/// the text of its intensity, `null` if it had none.
pub fn change(source: &Source, mode: LightsMode, additions: &mut Additions) -> Vec<Value> {
    match mode {
        LightsMode::Keep => Vec::new(),
        LightsMode::Dim => dim(source, additions),
        LightsMode::Remove => {
            remove(source, additions);
            Vec::new()
        }
    }
}

fn dim(source: &Source, additions: &mut Additions) -> Vec<Value> {
    let text = source.text();
    let list = source
        .find(&LIGHT_LIST)
        .and_then(|list| elements(text, &list));
    let mut baked = Vec::new();
    for (i, light) in list.into_iter().flatten().enumerate() {
        let old = member(text, &light, "intensity").map(|span| &text[span]);
        if old.and_then(|old| old.parse().ok()) == Some(0.0) {
            continue;
        }
        let lights = additions.edit.key("extensions").key(LIGHTS).key("lights");
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
