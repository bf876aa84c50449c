//! The file `boundary`: which faces belong to which patch.

use super::cursor::FoamCursor;
use crate::ReadError;
use crate::reading::text::text;

/// A patch of the boundary.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct FoamPatch {
    pub name: String,
    /// `wall`, `patch`, `empty`…
    pub kind: String,
    pub first: u64,
    pub count: u64,
    /// Offset of its name in the file.
    pub at: usize,
}

impl FoamPatch {
    /// Whether its faces bound no volume: those of flat cases, of wedges, and between processors.
    pub fn is_skipped(&self) -> bool {
        matches!(&*self.kind, "empty" | "wedge") || self.kind.starts_with("processor")
    }

    /// Whether its faces stand for more of the same space.
    pub fn is_repetition(&self) -> bool {
        self.kind.starts_with("cyclic") || self.kind.starts_with("symmetry")
    }

    /// The number behind its last face.
    pub fn end(&self) -> u64 {
        self.first.saturating_add(self.count)
    }
}

/// Reads the patches, whose faces must follow each other.
pub(super) fn patches(cursor: &mut FoamCursor) -> Result<Vec<FoamPatch>, ReadError> {
    let count = cursor.label()?;
    let mut patches: Vec<FoamPatch> = Vec::new();
    cursor.expect(b'(')?;
    for _ in 0..count {
        let patch = patch(cursor)?;
        let behind = patches.last().map_or(0, FoamPatch::end);
        if patch.first < behind {
            let found = format!("patch \"{}\" starting at face {}", patch.name, patch.first);
            let expected =
                format!("one starting at face {behind}, right after the patch before it");
            return Err(cursor.error(patch.at, found, expected));
        }
        patches.push(patch);
    }
    cursor.expect(b')')?;
    Ok(patches)
}

fn patch(cursor: &mut FoamCursor) -> Result<FoamPatch, ReadError> {
    cursor.skip_blanks();
    let at = cursor.text.offset();
    let name = (cursor.text).take_while(|b| !b.is_ascii_whitespace() && !matches!(b, b'{' | b')'));
    if name.is_empty() {
        return Err(cursor.odd("the name of a patch"));
    }
    let mut patch = FoamPatch {
        name: text(name).trim_matches('"').to_owned(),
        at,
        ..FoamPatch::default()
    };
    cursor.expect(b'{')?;
    let [mut has_first, mut has_count] = [false; 2];
    while !cursor.pass(b'}') {
        match cursor.word() {
            Some(b"type") => {
                let kind = cursor.word().unwrap_or_default();
                patch.kind = text(kind).into_owned();
            }
            Some(b"nFaces") => (patch.count, has_count) = (cursor.label()?, true),
            Some(b"startFace") => (patch.first, has_first) = (cursor.label()?, true),
            Some(_) => {}
            None => return Err(cursor.odd("\"}\"")),
        }
        cursor.skip_entry()?;
    }
    if !has_first || !has_count {
        let found = format!("patch \"{}\" without its faces", patch.name);
        return Err(cursor.error(at, found, "nFaces and startFace"));
    }
    Ok(patch)
}
