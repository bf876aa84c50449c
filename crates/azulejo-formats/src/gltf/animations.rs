//! Animations, which are not used.

use super::messages::GltfMessages;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::HashMap;

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

#[cfg(test)]
mod tests {
    use super::*;

    fn check(json: &str, expected: &str) {
        let mut messages = GltfMessages::default();
        let found = blanked(json.as_bytes(), &mut messages);
        assert_eq!(std::str::from_utf8(&found).unwrap(), expected);
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
