//! What undoes an edit, in the file itself: under `asset.extras.azulejo.lightmap`.
//!
//! `undo` lists the changes of the JSON text in its order: how many bytes of both texts are equal, how many
//! follow that were added, and the text that stood in their place. All of it is about the text without the
//! note, of which `hash` tells whether another program has written the file since.

use super::additions::Additions;
use super::edits::{Edit, Splice, spliced};
use super::error::PatchError;
use super::glb::{Frame, Glb, Parts};
use super::notes::Notes;
use super::scan::{self, Span};
use super::source::Source;
use super::types::PatchedFile;
use serde_json::{Map, Value, json};

/// The steps to the note.
pub const NOTE: [&str; 4] = ["asset", "extras", "azulejo", "lightmap"];

/// The convention of an edit that has put light on vertices.
pub const OF_VERTICES: &str = "vertices";

/// Stands in the place of the note while the text is made. JSON has no such character.
const MARK: &str = "\u{1}";

/// Ends an edit: the file with a note of what undoes it, and of these `facts`.
///
/// # Errors
/// More than 4 GiB.
pub fn sealed(
    source: &Source,
    mut additions: Additions,
    mut facts: Map<String, Value>,
    notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let bin = additions.finish_bytes();
    let names: Vec<&str> = additions
        .files
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    if !names.is_empty() {
        facts.insert("files".into(), json!(names));
    }
    if let Frame::Glb(glb) = &source.parts.frame {
        facts.insert("glb".into(), frame_note(glb));
    }
    let text = with_note(source, &mut additions.edit, facts);
    let file = assembled(&source.parts.frame, &text, bin.as_deref());
    Ok(PatchedFile {
        bytes: file.ok_or_else(|| source.refused("a GLB of more than 4 GiB"))?,
        files: additions.files,
        notes: notes.finish(),
        leaves_dark: false,
    })
}

/// Ends an edit that is not undone.
///
/// # Errors
/// More than 4 GiB.
pub fn unsealed(
    source: &Source,
    mut additions: Additions,
    notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let bin = additions.finish_bytes();
    let splices = additions.edit.splices(source.text(), &source.root);
    let text = spliced(source.text(), &splices);
    let file = assembled(&source.parts.frame, &text, bin.as_deref());
    Ok(PatchedFile {
        bytes: file.ok_or_else(|| source.refused("a GLB of more than 4 GiB"))?,
        files: additions.files,
        notes: notes.finish(),
        leaves_dark: false,
    })
}

/// The file of these contents in such a frame.
pub fn assembled(frame: &Frame, text: &str, bin: Option<&[u8]>) -> Option<Vec<u8>> {
    match frame {
        Frame::Text(mark) => Some([mark, text.as_bytes()].concat()),
        Frame::Glb(glb) => {
            let usual = Glb {
                odd_length: None,
                odd_padding: None,
                ..glb.clone()
            };
            usual.joined(text, bin)
        }
    }
}

/// What the frame of a GLB was.
fn frame_note(glb: &Glb) -> Value {
    let mut note = Map::new();
    if let Some(length) = glb.odd_length {
        note.insert("length".into(), json!(length));
    }
    if let Some(padding) = glb.odd_padding {
        let padding: String = padding.iter().map(|b| char::from(*b)).collect();
        note.insert("padding".into(), json!(padding));
    }
    if let Some(bin) = glb.bin() {
        note.insert("bin".into(), json!(bin.len()));
    }
    note.into()
}

/// The edited text, with the note.
fn with_note(source: &Source, edit: &mut Edit, mut facts: Map<String, Value>) -> String {
    let text = source.text();
    add_mark(source, edit);
    let mut splices = edit.splices(text, &source.root);
    let marked = spliced(text, &splices);
    let at = marked.find(MARK).unwrap_or(marked.len());
    for splice in &mut splices {
        splice.text = splice.text.replace(MARK, "");
    }
    let plain = marked.replace(MARK, "");
    facts.insert("undo".into(), undo(text, &splices));
    facts.insert("hash".into(), json!(hash(&plain)));
    let note = Value::Object(facts).to_string();
    [&plain[..at], &note, &plain[at..]].concat()
}

/// Puts the mark into the extras of the asset, whatever they are.
fn add_mark(source: &Source, edit: &mut Edit) {
    let text = source.text();
    let place = edit.key("asset").key("extras");
    add_extra(text, source.find(&NOTE[..2]), "lightmap", MARK, place);
}

/// Sets a member of `azulejo` in extras, whatever they are: what is no object is kept as `value`.
pub fn add_extra(text: &str, extras: Option<Span>, key: &str, value: &str, edit: &mut Edit) {
    let is_other =
        |span: &Span| !text[span.clone()].starts_with('{') && &text[span.clone()] != "null";
    let azulejo = extras
        .as_ref()
        .and_then(|e| scan::member(text, e, "azulejo"));
    if let Some(old) = extras.filter(is_other) {
        let old = &text[old];
        edit.set(format!(
            "{{\"value\":{old},\"azulejo\":{{\"{key}\":{value}}}}}"
        ));
    } else if let Some(old) = azulejo.filter(is_other) {
        let old = &text[old];
        let place = edit.key("azulejo");
        place.set(format!("{{\"value\":{old},\"{key}\":{value}}}"));
    } else {
        edit.key("azulejo").key(key).set(value);
    }
}

fn undo(text: &str, splices: &[Splice]) -> Value {
    let mut list = Vec::with_capacity(3 * splices.len());
    let mut at = 0;
    for splice in splices {
        list.push(json!(splice.range.start - at));
        list.push(json!(splice.text.len()));
        list.push(json!(&text[splice.range.clone()]));
        at = splice.range.end;
    }
    list.into()
}

/// A note that was found in a file.
pub struct LightmapNote {
    /// Its bytes in the text.
    pub span: Span,
    /// What it says.
    pub note: Map<String, Value>,
}

/// The note in a file, if there is one.
pub fn found(parts: &Parts) -> Option<LightmapNote> {
    let span = scan::find(parts.text, &scan::whole(parts.text), &NOTE)?;
    let note = serde_json::from_str(&parts.text[span.clone()]).ok()?;
    Some(LightmapNote { span, note })
}

impl LightmapNote {
    /// Whether it is about light on vertices, not about a lightmap.
    pub fn is_of_vertices(&self) -> bool {
        self.note.get("convention").and_then(Value::as_str) == Some(OF_VERTICES)
    }

    /// The file as it was, if it is known.
    pub fn undone(&self, parts: &Parts) -> Option<Vec<u8>> {
        let Span { start, end } = self.span;
        let plain = [&parts.text[..start], &parts.text[end..]].concat();
        if self.note.get("hash")?.as_str()? != hash(&plain) {
            return None;
        }
        let text = self.old_text(&plain)?;
        match &parts.frame {
            Frame::Text(mark) => Some([mark, text.as_bytes()].concat()),
            Frame::Glb(glb) => self.old_glb(glb, &text),
        }
    }

    fn old_text(&self, plain: &str) -> Option<String> {
        let mut text = String::new();
        let mut at = 0usize;
        for three in self.note.get("undo")?.as_array()?.chunks(3) {
            let [equal, added, removed] = three else {
                return None;
            };
            let number = |v: &Value| usize::try_from(v.as_u64()?).ok();
            let end = at.checked_add(number(equal)?)?;
            text += plain.get(at..end)?;
            text += removed.as_str()?;
            at = end.checked_add(number(added)?)?;
        }
        text += plain.get(at..)?;
        Some(text)
    }

    fn old_glb(&self, glb: &Glb, text: &str) -> Option<Vec<u8>> {
        let note = self.note.get("glb")?;
        let length = note.get("length").and_then(Value::as_u64);
        let padding = note.get("padding").and_then(Value::as_str);
        let old = Glb {
            odd_length: length.and_then(|l| u32::try_from(l).ok()),
            odd_padding: padding.map(str::as_bytes),
            ..glb.clone()
        };
        let bin = match note.get("bin") {
            Some(length) => Some(glb.bin()?.get(..usize::try_from(length.as_u64()?).ok()?)?),
            None => None,
        };
        old.joined(text, bin)
    }

    /// A list of the note.
    pub fn list(&self, key: &str) -> &[Value] {
        let list = self.note.get(key).and_then(Value::as_array);
        list.map_or(&[], Vec::as_slice)
    }
}

/// FNV-1a with 64 bits, Fowler, Noll, Vo; in hexadecimal.
fn hash(text: &str) -> String {
    let mixed = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{mixed:016x}")
}
