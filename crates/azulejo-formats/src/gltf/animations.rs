//! Animations, which are not used.

use super::messages::GltfMessages;
use serde_json::Value;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// The JSON with an empty list in place of its animations, and a warning about them.
///
/// `gltf-json` demands a node for every target, which `KHR_animation_pointer` leaves out: nothing in
/// an animation shall be a reason to refuse a file whose rest pose is read. The length and the lines stay
/// as they are, for the positions of other errors. JSON that cannot be parsed is returned unchanged.
pub(super) fn blanked<'a>(json: &'a [u8], messages: &mut GltfMessages) -> Cow<'a, [u8]> {
    let Some((start, length)) = animations(json) else {
        return Cow::Borrowed(json);
    };
    messages.whole("animations: not used, nodes are in their rest pose");
    let mut blanked = json.to_vec();
    for byte in &mut blanked[start + 1..start + length - 1] {
        if *byte != b'\n' {
            *byte = b' ';
        }
    }
    Cow::Owned(blanked)
}

/// First byte and length of the list of animations, if there is one and it is not empty.
fn animations(json: &[u8]) -> Option<(usize, usize)> {
    const KEY: &[u8] = b"\"animations\"";
    if !json.windows(KEY.len()).any(|w| w == KEY) {
        return None;
    }
    let text = std::str::from_utf8(json).ok()?;
    let members: HashMap<String, &RawValue> = serde_json::from_str(text).ok()?;
    let list = members.get("animations")?.get();
    let is_list = list.starts_with('[') && list.contains('{');
    is_list.then(|| (list.as_ptr() as usize - text.as_ptr() as usize, list.len()))
}

/// What the animations of a file change about the geometry of a scene.
#[derive(Debug, Default)]
pub(super) struct Targets {
    /// Nodes that are moved, turned, scaled or hidden.
    pub moved_nodes: Vec<usize>,
    /// Nodes whose morph targets get other weights.
    pub morphed_nodes: HashSet<usize>,
    /// Meshes whose morph targets get other weights (`KHR_animation_pointer`).
    pub morphed_meshes: HashSet<usize>,
}

impl Targets {
    /// The targets of all animations in the JSON of a file; damaged ones are left out.
    pub fn of(json: &[u8]) -> Targets {
        let mut targets = Targets::default();
        let list = animations(json).and_then(|(start, length)| {
            serde_json::from_slice::<Vec<&RawValue>>(json.get(start..start + length)?).ok()
        });
        for animation in list.into_iter().flatten() {
            let members = serde_json::from_str::<HashMap<String, &RawValue>>(animation.get());
            let channels = members.ok().and_then(|members| {
                serde_json::from_str::<Vec<Value>>(members.get("channels")?.get()).ok()
            });
            for target in channels.iter().flatten().filter_map(|c| c.get("target")) {
                targets.add(target);
            }
        }
        targets
    }

    fn add(&mut self, target: &Value) {
        let pointer = (|| {
            let extension = target.get("extensions")?.get("KHR_animation_pointer")?;
            extension.get("pointer")?.as_str()
        })();
        if let Some(pointer) = pointer {
            let mut parts = pointer.split('/').skip(1);
            let (list, index, property) = (parts.next(), parts.next(), parts.next());
            let index = index.and_then(|i| i.parse().ok());
            return match (list, index, property) {
                (Some("nodes"), Some(node), property) => self.add_node(node, property),
                (Some("meshes"), Some(mesh), Some("weights")) => {
                    self.morphed_meshes.insert(mesh);
                }
                _ => {}
            };
        }
        let node = target.get("node").and_then(Value::as_u64);
        if let Some(node) = node.and_then(|n| usize::try_from(n).ok()) {
            self.add_node(node, target.get("path").and_then(Value::as_str));
        }
    }

    fn add_node(&mut self, node: usize, property: Option<&str>) {
        match property {
            Some("weights") => {
                self.morphed_nodes.insert(node);
            }
            _ => self.moved_nodes.push(node),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_of_channels_and_pointers() {
        let pointer = |p: &str| {
            format!(
                "{{\"target\":{{\"path\":\"pointer\",\"extensions\":\
                 {{\"KHR_animation_pointer\":{{\"pointer\":\"{p}\"}}}}}}}}"
            )
        };
        let json = format!(
            "{{\"animations\":[{{\"channels\":[\
             {{\"target\":{{\"node\":1,\"path\":\"rotation\"}}}},\
             {{\"target\":{{\"node\":2,\"path\":\"weights\"}}}}]}},7,{{\"channels\":[{},{},{},{}]}}]}}",
            pointer("/nodes/3/extensions/KHR_node_visibility/visible"),
            pointer("/nodes/4/weights"),
            pointer("/meshes/5/weights/0"),
            pointer("/materials/6/emissiveFactor"),
        );
        let targets = Targets::of(json.as_bytes());
        assert_eq!(targets.moved_nodes, [1, 3]);
        assert_eq!(targets.morphed_nodes, HashSet::from([2, 4]));
        assert_eq!(targets.morphed_meshes, HashSet::from([5]));
        assert!(Targets::of(b"{\"animations\":[{").moved_nodes.is_empty());
    }

    fn check(json: &str, expected: &str) {
        let mut messages = GltfMessages::default();
        let bytes = blanked(json.as_bytes(), &mut messages);
        assert_eq!(std::str::from_utf8(&bytes).unwrap(), expected);
        let warned = messages.first_of("animations").is_some();
        assert_eq!(warned, json != expected);
    }

    #[test]
    fn only_the_list_of_animations_is_blanked() {
        check(
            "{\"animations\":[{}] ,\"a\":1}",
            "{\"animations\":[  ] ,\"a\":1}",
        );
        check(
            "{\"a\":{\"animations\":[{}]},\"animations\" : [\n{\n \"x\":1}]}",
            "{\"a\":{\"animations\":[{}]},\"animations\" : [\n \n       ]}",
        );
        for same in [
            "{\"animations\":[]}",
            "{\"animations\":7}",
            "{\"animations\":[{}",
            "[\"animations\"]",
            "{\"name\":\"animations\"}",
        ] {
            check(same, same);
        }
    }
}
