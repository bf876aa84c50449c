//! The changed entries of meshes and nodes.

use super::accessors::NewVertices;
use super::additions::Additions;
use super::assign::{Entry, Placement};
use super::edits::Edit;
use super::error::PatchError;
use super::materials::{Replaced, Textures};
use super::notes::Notes;
use super::primitives::{PrimitiveJson, VARIANTS};
use super::types::{Convention, LightmapUvs};
use super::uncompress;
use super::work::{Split, Work};
use gltf_json::mesh::Mode;
use serde_json::{Value, json};
use std::collections::HashSet;

impl Work<'_, '_> {
    /// Changes the mesh entries, and adds copies.
    pub fn meshes(
        &self,
        split: &Split,
        replaced: &Replaced,
        set: u32,
        additions: &mut Additions,
        notes: &mut Notes,
    ) {
        let mut entries: Vec<Option<usize>> = Vec::new();
        for (a, assignment) in self.assignments.iter().enumerate() {
            let mesh = assignment.mesh;
            let entry = match assignment.entry {
                Entry::Own => {
                    let own = self.mesh(a, split, replaced, set, notes);
                    *additions.edit.key("meshes").index(mesh) = own;
                    None
                }
                Entry::Shared(base, _) => entries[base],
                Entry::Copy | Entry::Moved(..) => {
                    let own = self.mesh(a, split, replaced, set, notes);
                    let text = own.applied(self.source.text(), &self.spans[mesh]);
                    Some(additions.append("meshes", text))
                }
            };
            if let Some(entry) = entry {
                let node = additions.edit.key("nodes").index(assignment.node);
                node.key("mesh").set(entry.to_string());
            }
            entries.push(entry);
        }
        self.drop_draco(split, additions);
    }

    /// The change of the mesh of an assignment.
    fn mesh(
        &self,
        a: usize,
        split: &Split,
        replaced: &Replaced,
        set: u32,
        notes: &mut Notes,
    ) -> Edit {
        let lit = self.lit(split, a);
        let mesh = &self.meshes[self.assignments[a].mesh];
        let mut edit = Edit::default();
        for (i, primitive) in &split.primitives[a] {
            let (Some(lit), Some(vertices)) = (lit.get(i), &split.vertices[primitive.group]) else {
                continue;
            };
            let json = &mesh[*i];
            let change = edit.key("primitives").index(*i);
            change_vertices(change, json, vertices, set);
            let is_unlit = self.edit.convention == Convention::Unlit;
            if is_unlit && replaced.shows(json.material, *lit) {
                drop_colours(change, json);
            }
            if let Some(indices) = split.indices.get(&(a, *i)) {
                change.key("indices").set(indices.to_string());
            }
            if primitive.corners.is_some() && json.mode != Some(Mode::Triangles) {
                notes.add("strip or fan with a seam: becomes a list of triangles");
                change.key("mode").set("4");
            }
            if json.has_draco() && vertices.uvs.is_some() {
                notes.add("primitive compressed with Draco: is no longer");
                uncompress::primitive(change, json);
            }
            if let Some(new) = replaced.of(json.material, *lit) {
                change.key("material").set(new.to_string());
            }
            for (k, variant) in json.variants.iter().enumerate() {
                if let Some(new) = replaced.of(*variant, *lit) {
                    let variants = change.key("extensions").key(VARIANTS);
                    let mapping = variants.key("mappings").index(k);
                    mapping.key("material").set(new.to_string());
                }
            }
        }
        edit
    }

    /// Takes Draco from the lists of extensions if no primitive is compressed any more.
    fn drop_draco(&self, split: &Split, additions: &mut Additions) {
        if let LightmapUvs::Existing(_) = self.edit.uvs {
            return;
        }
        let mut changed = HashSet::new();
        for (a, assignment) in self.assignments.iter().enumerate() {
            if assignment.entry == Entry::Own {
                let lit = self.lit(split, a);
                changed.extend(lit.keys().map(|primitive| (assignment.mesh, *primitive)));
            }
        }
        uncompress::lists(self.source, &self.meshes, &changed, additions);
    }

    /// Gives nodes their lightmap (`MX_lightmap`).
    pub fn nodes(
        &self,
        set: u32,
        textures: &mut Textures,
        additions: &mut Additions,
    ) -> Result<(), PatchError> {
        for assignment in &self.assignments {
            let Some(part) = assignment.parts.first() else {
                continue;
            };
            let Some((page, texture)) = textures.of(part.page, additions)? else {
                continue;
            };
            let placement = match assignment.entry {
                Entry::Shared(_, placement) => placement,
                _ => Placement {
                    offset: [0.0; 2],
                    scale: [1.0; 2],
                },
            };
            let extension: Value = json!({
                "lightMapTexture": { "index": texture, "texCoord": set },
                "offset": placement.offset,
                "scale": placement.scale,
                "intensity": page.intensity,
            });
            let node = additions.edit.key("nodes").index(assignment.node);
            let node = node.key("extensions").key("MX_lightmap");
            node.set(extension.to_string());
            additions.use_extension("extensionsUsed", "MX_lightmap");
        }
        Ok(())
    }
}

/// Gives a primitive its new accessors.
fn change_vertices(change: &mut Edit, json: &PrimitiveJson, new: &NewVertices, set: u32) {
    for (name, accessor) in &new.attributes {
        change.key("attributes").key(name).set(accessor.to_string());
    }
    let Some(uvs) = new.uvs else {
        return;
    };
    // Names are numbered without gaps (glTF 2.0, 3.7.2.1).
    for lower in 0..set {
        let name = format!("TEXCOORD_{lower}");
        if json.attribute(&name).is_none() {
            change.key("attributes").key(&name).set(uvs.to_string());
        }
    }
    let name = format!("TEXCOORD_{set}");
    change.key("attributes").key(&name).set(uvs.to_string());
    for (target, name, accessor) in &new.targets {
        let target = change.key("targets").index(*target);
        target.key(name).set(accessor.to_string());
    }
}

/// Colours of vertices are in the picture of an unlit surface already.
fn drop_colours(change: &mut Edit, json: &PrimitiveJson) {
    for (name, _) in &json.attributes {
        if name.starts_with("COLOR_") {
            change.key("attributes").key(name).remove();
        }
    }
}
