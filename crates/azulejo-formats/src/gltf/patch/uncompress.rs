//! Primitives that were compressed with Draco and are no longer.

use super::super::draco::DRACO;
use super::additions::Additions;
use super::edits::Edit;
use super::primitives::PrimitiveJson;
use super::scan::{self, Span};
use super::source::Source;
use std::collections::HashSet;

/// Takes the compressed data from a primitive, which has others now.
pub fn primitive(change: &mut Edit, json: &PrimitiveJson) {
    match json.extensions.len() {
        1 => change.key("extensions").remove(),
        _ => change.key("extensions").key(DRACO).remove(),
    }
}

/// Takes Draco from the lists of extensions if no primitive is compressed any more: those of `changed`, each
/// the index of its mesh and its own, are not.
pub fn lists(
    source: &Source,
    meshes: &[Vec<PrimitiveJson>],
    changed: &HashSet<(usize, usize)>,
    additions: &mut Additions,
) {
    let all = meshes.iter().enumerate();
    let all = all.flat_map(|(m, list)| list.iter().enumerate().map(move |(p, json)| (m, p, json)));
    let compressed = all.filter(|(_, _, json)| json.has_draco());
    let compressed: Vec<(usize, usize)> = compressed.map(|(m, p, _)| (m, p)).collect();
    if compressed.is_empty() || !compressed.iter().all(|place| changed.contains(place)) {
        return;
    }
    let is_draco = |span: &Span| scan::string(source.text(), span).as_deref() == Some(DRACO);
    for list in ["extensionsUsed", "extensionsRequired"] {
        let names = source.list(list);
        if list == "extensionsRequired" && !names.is_empty() && names.iter().all(is_draco) {
            additions.edit.key(list).remove();
            continue;
        }
        for (i, _) in names.iter().enumerate().filter(|(_, span)| is_draco(span)) {
            additions.edit.key(list).index(i).remove();
        }
    }
}
