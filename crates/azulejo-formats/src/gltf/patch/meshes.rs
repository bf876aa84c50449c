//! The changed entries of meshes and nodes.

use super::super::draco::DRACO;
use super::additions::Additions;
use super::assign::{Entry, Placement};
use super::json::Json;
use super::materials::{Replaced, Textures};
use super::notes::Notes;
use super::primitives::{MAPPINGS, Primitive};
use super::types::Convention;
use super::work::{Split, Work};
use gltf_json::mesh::Mode;
use serde_json::json;

impl<'w> Work<'w> {
    /// Changes the mesh entries, and adds copies.
    pub fn meshes(
        &self,
        split: &Split,
        replaced: &Replaced,
        additions: &mut Additions<'w>,
        notes: &mut Notes,
    ) {
        let mut entries: Vec<Option<usize>> = Vec::new();
        for (a, assignment) in self.assignments.iter().enumerate() {
            let entry = match assignment.entry {
                Entry::Shared(base, _) => entries[base],
                _ => {
                    let mesh = self.mesh(a, split, replaced, additions, notes);
                    place_mesh(mesh, assignment.mesh, assignment.entry, additions)
                }
            };
            if let Some(entry) = entry {
                let node = additions.json.key("nodes").at(assignment.node);
                node.key("mesh").set(entry);
            }
            entries.push(entry);
        }
        drop_draco(&self.meshes, &mut additions.json);
    }

    /// The mesh of an assignment, changed.
    fn mesh(
        &self,
        a: usize,
        split: &Split,
        replaced: &Replaced,
        additions: &mut Additions<'w>,
        notes: &mut Notes,
    ) -> Json<'w> {
        let lit = self.lit(split, a);
        let mesh = self.assignments[a].mesh;
        let mut json = self.source.json.entries("meshes")[mesh].clone();
        for (i, part) in &split.primitives[a] {
            let (Some(lit), Some(vertices)) = (lit.get(i), &split.vertices[part.group]) else {
                continue;
            };
            let own = &self.meshes[mesh][*i];
            let primitive = json.key("primitives").at(*i);
            if !vertices.attributes.is_empty() {
                vertices.give(primitive);
                if let Some(corners) = self.corners(own, part, &split.groups[part.group]) {
                    let indices = additions.corners(&corners, own.indices);
                    primitive.key("indices").set(indices);
                }
                uncompress(primitive, own, notes);
            }
            if self.edit.convention == Convention::Unlit && replaced.shows(own.material, *lit) {
                drop_colours(primitive, own);
            }
            if part.corners.is_some() && own.mode != Some(Mode::Triangles) {
                notes.add("strip or fan with a seam: becomes a list of triangles");
                primitive.key("mode").set(json!(4));
            }
            if let Some(new) = replaced.of(own.material, *lit) {
                primitive.key("material").set(new);
            }
            for (k, variant) in own.variants.iter().enumerate() {
                if let Some(new) = replaced.of(*variant, *lit) {
                    let mappings = MAPPINGS
                        .iter()
                        .fold(&mut *primitive, |json, key| json.key(key));
                    mappings.at(k).key("material").set(new);
                }
            }
        }
        json
    }

    /// Gives nodes their lightmap (`MX_lightmap`).
    pub fn nodes(&self, set: u32, pages: &mut Textures, additions: &mut Additions) {
        for assignment in &self.assignments {
            let page = assignment.parts.first().map(|part| part.page);
            let Some((page, textures)) = page.and_then(|page| pages.of(page, additions)) else {
                continue;
            };
            let Placement { offset, scale } = match assignment.entry {
                Entry::Shared(_, placement) => placement,
                _ => Placement {
                    offset: [0.0; 2],
                    scale: [1.0; 2],
                },
            };
            let node = additions.json.key("nodes").at(assignment.node);
            node.key("extensions").key("MX_lightmap").set(json!({
                "lightMapTexture": { "index": textures.light, "texCoord": set },
                "offset": offset,
                "scale": scale,
                "intensity": page.intensity,
            }));
            additions.use_extension("extensionsUsed", "MX_lightmap");
        }
    }
}

/// Puts the changed mesh in its place, or adds it as a copy, whose index is returned.
pub fn place_mesh<'s>(
    mesh: Json<'s>,
    place: usize,
    entry: Entry,
    additions: &mut Additions<'s>,
) -> Option<usize> {
    if entry == Entry::Own {
        additions.json.key("meshes").at(place).set(mesh);
        return None;
    }
    Some(additions.append("meshes", mesh))
}

/// Takes the compressed data from a primitive, which has others now.
pub fn uncompress(primitive: &mut Json, own: &Primitive, notes: &mut Notes) {
    if own.has_draco {
        notes.add("primitive compressed with Draco: is no longer");
        primitive.prune(&["extensions", DRACO]);
    }
}

/// Takes Draco from the lists of extensions if no primitive is compressed any more.
pub fn drop_draco(before: &[Vec<Primitive>], json: &mut Json) {
    let steps = ["extensions", DRACO];
    let mut primitives = json
        .entries("meshes")
        .iter()
        .flat_map(|m| m.entries("primitives"));
    let is_left = primitives.any(|p| p.find(&steps).is_some());
    if is_left || !before.iter().flatten().any(|p| p.has_draco) {
        return;
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        drop_extension(json, list, DRACO);
    }
}

/// Takes a name from a list of extensions, which may not be empty.
pub fn drop_extension(json: &mut Json, list: &str, name: &str) {
    if let Some(Json::List(mut names)) = json.get(list).cloned() {
        names.retain(|known| known.text().as_deref() != Some(name));
        if names.is_empty() {
            json.remove(list);
        } else {
            json.key(list).set(Json::List(names));
        }
    }
}

/// Colours of vertices are in the picture of an unlit surface already.
fn drop_colours(primitive: &mut Json, own: &Primitive) {
    let colours = own
        .attributes
        .iter()
        .filter(|(name, _)| name.starts_with("COLOR_"));
    colours.for_each(|(name, _)| primitive.key("attributes").remove(name));
}
