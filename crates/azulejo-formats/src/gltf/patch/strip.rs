//! Removes the lightmap from a file: exactly if nobody has written it since, else what can be found of it.

use super::error::PatchError;
use super::glb::Parts;
use super::json::{Json, MOST_LEVELS};
use super::lights::brighten;
use super::mark::{self, MARK, OF_VERTICES};
use super::meshes::drop_extension;
use super::types::StrippedFile;
use crate::reading::text::shortened;

/// Extensions with a lightmap, by the list of the entries that have them.
const LIGHTMAPS: [(&str, &str); 2] = [("materials", "MOZ_lightmap"), ("nodes", "MX_lightmap")];

/// Removes azulejo's lightmap from a file, or light that was put on its vertices. `name` is used in
/// messages.
///
/// The file is again what it was: the same JSON, with its order and the spelling of its numbers, but for blanks,
/// and the same buffers, byte for byte; in the container in which it was written last. If another program has
/// written it since, or an earlier version of azulejo, extensions and lights are restored in the file as it is
/// now, and the result says so.
///
/// # Errors
/// Files that are not glTF, or have no such lightmap.
pub fn strip(bytes: &[u8], name: &str) -> Result<StrippedFile, PatchError> {
    let parts = Parts::of(bytes, name)?;
    let json = Json::parse(parts.text, 2 * MOST_LEVELS);
    let json = json.map_err(|found| PatchError::of(name, found))?;
    let missing = "it has no lightmap of azulejo's, nor its light on vertices";
    let mark = json
        .find(&MARK)
        .ok_or_else(|| PatchError::of(name, missing))?;
    let is_of_vertices = is_of_vertices(mark);
    if let (Some(old), Some(bin)) = (mark::undone(&json), mark::old_bin(&parts, mark)) {
        let files = mark.entries("files").iter();
        return Ok(StrippedFile {
            bytes: parts.joined(&old, bin, name)?,
            is_of_vertices,
            is_exact: true,
            unused_files: files.filter_map(|n| Some(n.text()?.into_owned())).collect(),
            notes: Vec::new(),
        });
    }
    let writer = match mark.get("undo") {
        Some(_) => "an earlier version of azulejo (bake the original again instead)",
        None => "another program",
    };
    let left = if is_of_vertices {
        "the light on vertices stays"
    } else {
        "coordinates, pictures and copies stay"
    };
    let mut notes = vec![format!("{writer} has written the file: {left}")];
    let convention = mark.get("convention").and_then(Json::text);
    if let Some(convention @ ("emissive" | "unlit")) = convention.as_deref() {
        notes.push(format!("materials that became {convention} stay so"));
    }
    Ok(StrippedFile {
        bytes: parts.joined(&without(&json, mark), parts.bin(), name)?,
        is_of_vertices,
        is_exact: false,
        unused_files: Vec::new(),
        notes,
    })
}

/// What another program has taken from a file that azulejo has baked, as a sentence; `None` if all is there.
///
/// # Errors
/// Files that are not glTF.
pub fn lost(bytes: &[u8], name: &str) -> Result<Option<String>, PatchError> {
    // Only a file with azulejo's mark has anything to lose.
    let parts = Parts::of(bytes, name)?;
    let json = Json::parse(parts.text, 2 * MOST_LEVELS);
    let json = json.map_err(|found| PatchError::of(name, found))?;
    let Some(mark) = json.find(&MARK) else {
        return Ok(None);
    };
    let convention = mark.get("convention").and_then(Json::text);
    // See whether the entries that refer to the light are still somewhere in the file.
    let has =
        |list: &str, steps: &[&str]| json.entries(list).iter().any(|e| e.find(steps).is_some());
    let primitives = || (json.entries("meshes").iter()).flat_map(|m| m.entries("primitives"));
    let mut gone = Vec::new();
    let of_vertices = ["extras", "azulejo", "irradiance"];
    let what = match convention.as_deref().unwrap_or_default() {
        "moz" if !has("materials", &["extensions", "MOZ_lightmap"]) => "MOZ_lightmap of materials",
        "mx" if !has("nodes", &["extensions", "MX_lightmap"]) => "MX_lightmap of nodes",
        "occlusion" if !has("materials", &["occlusionTexture"]) => "occlusionTexture of materials",
        OF_VERTICES
            if !has("meshes", &of_vertices)
                && primitives().all(|p| p.find(&of_vertices).is_none()) =>
        {
            "the scale of the light on vertices"
        }
        _ => "",
    };
    if !what.is_empty() {
        gone.push(what.to_owned());
    }
    let directions = [
        "extensions",
        "MOZ_lightmap",
        "extras",
        "azulejo",
        "directions",
    ];
    if what.is_empty() && mark.get("directions").is_some() && !has("materials", &directions) {
        gone.push("the directions of its light".to_owned());
    }
    // Optimizers drop texture coordinates that no material refers to.
    if let Some(set) = mark.get("texCoord").and_then(Json::index) {
        let set = format!("TEXCOORD_{set}");
        if primitives().all(|p| p.find(&["attributes", &set]).is_none()) {
            gone.push(set);
        }
    }
    if gone.is_empty() {
        return Ok(None);
    }
    // Tell who wrote the file last, and that dimmed lamps do not come back by themselves.
    let writer = json.find(&["asset", "generator"]).and_then(Json::text);
    let mut message = format!(
        "{name}: {} has written the file since it was baked, and lost {}",
        shortened(writer.as_deref().unwrap_or("another program")),
        gone.join(" and ")
    );
    if !mark.entries("baked").is_empty() {
        message += "; the lamps that were baked stay dark";
    }
    Ok(Some(message + ": compress first, then bake"))
}

/// What azulejo's lightmap in a file says that it was computed from ([`LightmapEdit::content`](super::LightmapEdit)).
///
/// # Errors
/// Files that are not glTF.
pub fn content(bytes: &[u8], name: &str) -> Result<Option<String>, PatchError> {
    let parts = Parts::of(bytes, name)?;
    let json = Json::parse(parts.text, 2 * MOST_LEVELS);
    let json = json.map_err(|found| PatchError::of(name, found))?;
    let content = json
        .find(&MARK)
        .and_then(|mark| mark.get("content")?.text());
    Ok(content.map(|text| text.into_owned()))
}

/// Whether a mark is that of light on vertices.
pub fn is_of_vertices(mark: &Json) -> bool {
    let convention = mark.get("convention").and_then(Json::text);
    convention.as_deref() == Some(OF_VERTICES)
}

/// The document without what is known to be of a lightmap.
fn without<'s>(json: &Json<'s>, mark: &Json) -> Json<'s> {
    let mut new = json.clone();
    if !is_of_vertices(mark) {
        for (list, extension) in LIGHTMAPS {
            for i in 0..json.entries(list).len() {
                new.key(list).at(i).prune(&["extensions", extension]);
            }
            drop_extension(&mut new, "extensionsUsed", extension);
        }
        brighten(&mut new, mark);
    }
    new.prune(&MARK);
    new
}
