//! Removes the lightmap from a file: exactly if nobody has written it since, else what can be found of it.

use super::edits::{Edit, spliced};
use super::error::PatchError;
use super::glb::Parts;
use super::lights::DIMMED;
use super::scan::{self, Span};
use super::types::StrippedFile;
use super::undo::{self, LightmapNote};
use serde_json::Value;

/// Extensions with a lightmap, by the list of the entries that have them.
const LIGHTMAPS: [(&str, &str); 2] = [("materials", "MOZ_lightmap"), ("nodes", "MX_lightmap")];

/// The file without its lightmap.
pub fn stripped(bytes: &[u8], name: &str) -> Result<StrippedFile, PatchError> {
    let parts = Parts::of(bytes, name)?;
    let found = undo::found(&parts);
    let found = found.ok_or_else(|| {
        PatchError::of(
            name,
            "it has no lightmap of azulejo's, nor its light on vertices",
        )
    })?;
    if let Some(bytes) = found.undone(&parts) {
        let names = found.list("files").iter();
        return Ok(StrippedFile {
            bytes,
            is_of_vertices: found.is_of_vertices(),
            is_exact: true,
            unused_files: names.filter_map(|n| Some(n.as_str()?.to_owned())).collect(),
            notes: Vec::new(),
        });
    }
    let mut notes = vec![
        "another program has written the file: coordinates, pictures and copies stay".to_owned(),
    ];
    if found.is_of_vertices() {
        notes =
            vec!["another program has written the file: the light on vertices stays".to_owned()];
    }
    let convention = found.note.get("convention").and_then(Value::as_str);
    if let Some(convention @ ("emissive" | "unlit")) = convention {
        notes.push(format!("materials that became {convention} stay so"));
    }
    let edit = removal(&parts, &found);
    let root = scan::whole(parts.text);
    let text = spliced(parts.text, &edit.splices(parts.text, &root));
    let bytes = undo::assembled(&parts.frame, &text, parts.bin());
    Ok(StrippedFile {
        bytes: bytes.ok_or_else(|| PatchError::of(name, "a GLB of more than 4 GiB"))?,
        is_of_vertices: found.is_of_vertices(),
        is_exact: false,
        unused_files: Vec::new(),
        notes,
    })
}

/// Removes what is known to be of a lightmap.
fn removal(parts: &Parts, found: &LightmapNote) -> Edit {
    let (text, root) = (parts.text, scan::whole(parts.text));
    let mut edit = Edit::default();
    if found.is_of_vertices() {
        remove(text, &root, &undo::NOTE, &mut edit);
        return edit;
    }
    for (list, extension) in LIGHTMAPS {
        for (i, entry) in entries(text, &root, &[list]).iter().enumerate() {
            if scan::find(text, entry, &["extensions", extension]).is_some() {
                let change = edit.key(list).index(i);
                remove(text, entry, &["extensions", extension], change);
            }
        }
        let used = entries(text, &root, &["extensionsUsed"]);
        let is_it = |span: &&Span| scan::string(text, span).as_deref() == Some(extension);
        if used.iter().filter(is_it).count() == used.len() {
            edit.key("extensionsUsed").remove();
        } else if let Some(i) = used.iter().position(|span| is_it(&span)) {
            edit.key("extensionsUsed").index(i).remove();
        }
    }
    brighten(text, &root, found, &mut edit);
    remove(text, &root, &undo::NOTE, &mut edit);
    edit
}

fn entries(text: &str, root: &Span, keys: &[&str]) -> Vec<Span> {
    let list = scan::find(text, root, keys);
    let list = list.and_then(|list| scan::elements(text, &list));
    list.unwrap_or_default()
}

/// Removes a member, and the objects around it that have nothing else.
fn remove(text: &str, object: &Span, keys: &[&str], edit: &mut Edit) {
    let Some((key, below)) = keys.split_first() else {
        return;
    };
    let own = scan::member(text, object, key);
    let is_alone = |keys: &[&str]| {
        let mut span = own.clone();
        keys.iter().all(|key| {
            let list = span.as_ref().and_then(|span| scan::members(text, span));
            span = span.as_ref().and_then(|span| scan::member(text, span, key));
            list.is_some_and(|list| list.len() == 1)
        })
    };
    if is_alone(below) {
        edit.key(key).remove();
    } else if let Some(own) = &own {
        remove(text, own, below, edit.key(key));
    }
}

/// Gives lights that are still dark their old intensity.
fn brighten(text: &str, root: &Span, found: &LightmapNote, edit: &mut Edit) {
    let dimmed = DIMMED
        .iter()
        .flat_map(|(member, steps)| found.list(member).iter().map(move |b| (steps, b)));
    for (steps, baked) in dimmed {
        let lights = entries(text, root, steps);
        let number = baked.get(0).and_then(Value::as_u64);
        let number = number.and_then(|n| usize::try_from(n).ok());
        let Some((i, light)) = number.and_then(|n| Some((n, lights.get(n)?))) else {
            continue;
        };
        let now = scan::member(text, light, "intensity").map(|span| &text[span]);
        if now.and_then(|now| now.parse().ok()) != Some(0.0) {
            continue;
        }
        let [extensions, name, list] = *steps;
        let change = edit.key(extensions).key(name).key(list).index(i);
        let change = change.key("intensity");
        match baked.get(1).and_then(Value::as_str) {
            // A note that somebody has changed may say anything.
            Some(old) if serde_json::from_str::<f64>(old).is_ok() => change.set(old),
            _ => change.remove(),
        }
    }
}
