//! The mark of an edit in the file itself, under `asset.extras.azulejo.lightmap`.
//!
//! Its `before` says how long lists were that have new entries, and what references and values were replaced, in
//! the order of the document: an object has the members that changed, `[]` for those that are new, `[value]` for
//! those that had another value, and `[value, place]` for those that were removed; a list is an object by numbers,
//! with its `length` if that grew. Accessors that are no longer used stay in the file. `hash` is that of the document without it, so it tells
//! whether another program has written the file since; `bin` is the length of the numbers of a GLB.

use super::additions::Additions;
use super::error::PatchError;
use super::glb::Parts;
use super::json::Json;
use super::notes::Notes;
use super::types::PatchedFile;
use serde_json::{Value, json};

/// The steps to the mark.
pub const MARK: [&str; 4] = ["asset", "extras", "azulejo", "lightmap"];

/// The convention of an edit that has put light on vertices.
pub const OF_VERTICES: &str = "vertices";

/// Ends an edit: the file with its mark, which has these `facts`. If the file has a mark already, its facts stay and are
/// added to: what undoes it undoes this edit, too.
///
/// # Errors
/// More bytes than are allowed.
pub fn finished<'s>(
    mut additions: Additions<'s>,
    facts: Json<'s>,
    notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let source = additions.source;
    let bin = additions.finish()?;
    let names = additions
        .files
        .iter()
        .map(|(name, _)| Json::from(name.as_str()));
    let mut json = additions.json;
    let known = source.json.find(&MARK);
    let intact = known.and_then(|_| undone(&source.json));
    if known.is_none() || intact.is_some() {
        let mut mark = known.cloned().unwrap_or_else(|| json!({}).into());
        ["before", "hash"].iter().for_each(|key| mark.remove(key));
        for (key, fact) in facts.members() {
            if mark.get(key).is_none() {
                mark.key(key).set(fact.clone());
            }
        }
        names.for_each(|name| _ = mark.key("files").push(name));
        if let (None, Some(bin)) = (known, source.parts.bin()) {
            mark.key("bin").set(bin.len());
        }
        let asset = json.key("asset");
        extra(asset, "lightmap").set(mark);
        let before = difference(&json, intact.as_ref().unwrap_or(&source.json));
        let mark = extra(json.key("asset"), "lightmap");
        mark.key("before")
            .set(before.unwrap_or_else(|| json!({}).into()));
        let hash = hash(&json.to_string());
        extra(json.key("asset"), "lightmap").key("hash").set(&*hash);
    }
    Ok(PatchedFile {
        bytes: source
            .parts
            .joined(&json, bin.as_deref(), source.file.name)?,
        files: additions.files,
        notes: notes.finish(),
        leaves_dark: false,
    })
}

/// The place of a member of `azulejo` in the extras of an entry, whatever they are: what is not an object is kept as
/// `value`.
pub fn extra<'e, 's>(entry: &'e mut Json<'s>, key: &str) -> &'e mut Json<'s> {
    let mut place = entry;
    for step in ["extras", "azulejo"] {
        place = place.key(step);
        let is_other = !matches!(place, Json::Object(_)) && *place != Json::from(Value::Null);
        if is_other {
            let old = place.clone();
            place.key("value").set(old);
        }
    }
    place.key(key)
}

/// The document as it was before the edit; `None` if another program has written it since.
pub fn undone<'s>(json: &Json<'s>) -> Option<Json<'s>> {
    let mut json = json.clone();
    let mark = extra(json.key("asset"), "lightmap");
    let given = mark.get("hash")?.text()?.into_owned();
    mark.remove("hash");
    let before = mark.get("before")?.clone();
    if hash(&json.to_string()) != given {
        return None;
    }
    restore(&mut json, &before)?;
    Some(json)
}

/// The numbers of a GLB as they were, `None` within if it had none; `None` if some of them are missing.
pub fn old_bin<'a>(parts: &Parts<'a>, mark: &Json) -> Option<Option<&'a [u8]>> {
    match mark.get("bin") {
        Some(length) => Some(Some(parts.bin()?.get(..length.index()?)?)),
        None => Some(None),
    }
}

/// What makes `old` of `new`; `None` if they are the same.
fn difference<'s>(new: &Json<'s>, old: &Json<'s>) -> Option<Json<'s>> {
    if new == old {
        return None;
    }
    let mut changes = Vec::new();
    match (new, old) {
        (Json::Object(new), Json::Object(old)) => {
            let mut new = new.iter().peekable();
            for (i, (key, old)) in old.iter().enumerate() {
                let change = match new.next_if(|(known, _)| known == key) {
                    Some((_, new)) => difference(new, old),
                    None => Some(Json::List(vec![old.clone(), i.into()])),
                };
                changes.extend(change.map(|change| (key.clone(), change)));
            }
            let added = new.map(|(key, _)| (key.clone(), Json::List(Vec::new())));
            changes.extend(added);
        }
        (Json::List(new), Json::List(old)) if new.len() >= old.len() => {
            for (i, (new, old)) in new.iter().zip(old).enumerate() {
                let change = difference(new, old);
                changes.extend(change.map(|change| (i.to_string().into(), change)));
            }
            if new.len() > old.len() {
                changes.push(("length".into(), old.len().into()));
            }
        }
        _ => return Some(Json::List(vec![old.clone()])),
    }
    Some(Json::Object(changes))
}

/// Undoes a difference; `None` if it is none of this value.
fn restore<'s>(value: &mut Json<'s>, before: &Json<'s>) -> Option<()> {
    match (&mut *value, before) {
        (_, Json::List(old)) => value.set(old.first()?.clone()),
        (Json::Object(members), Json::Object(changes)) => {
            for (key, change) in changes {
                // Keys are compared as they are spelled; of several the last is the one that counts.
                let place = members.iter().rposition(|(known, _)| known == key);
                match change {
                    Json::List(none) if none.is_empty() => _ = members.remove(place?),
                    Json::List(removed) if removed.len() == 2 => {
                        let place = removed[1].index()?.min(members.len());
                        members.insert(place, (key.clone(), removed[0].clone()));
                    }
                    change => restore(&mut members[place?].1, change)?,
                }
            }
        }
        (Json::List(list), Json::Object(changes)) => {
            for (key, change) in changes {
                match &**key {
                    "length" => list.truncate(change.index()?),
                    place => restore(list.get_mut(place.parse::<usize>().ok()?)?, change)?,
                }
            }
        }
        _ => return None,
    }
    Some(())
}

/// FNV-1a with 64 bits, Fowler, Noll, Vo; in hexadecimal.
fn hash(text: &str) -> String {
    let mixed = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{mixed:016x}")
}
