//! Puts a lightmap into a file.

use super::super::draco::DRACO;
use super::super::origin::ObjectOrigin;
use super::accessors::{NewAccessors, NewVertices};
use super::additions::Additions;
use super::assign::{Assignment, Entry, Placement, assignments};
use super::edits::Edit;
use super::error::PatchError;
use super::free_set;
use super::glb::Parts;
use super::lights;
use super::materials::{Lit, MaterialUses, Replaced, Textures};
use super::notes::Notes;
use super::primitives::{PrimitiveJson, VARIANTS};
use super::scan::Span;
use super::source::{Source, parsed};
use super::splits::{MISSING, SplitPrimitive, Splits, VertexGroup};
use super::types::{Convention, GltfFile, InstanceMode, LightmapEdit, LightsMode, PatchedFile};
use super::undo;
use serde_json::{Map, Value, json};
use std::collections::{HashMap, HashSet};

/// Puts a lightmap into a file that has none of azulejo's.
pub fn edited(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    edit: &LightmapEdit,
    mut notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let root = parsed(&parts, file)?;
    let source = Source::new(parts, &root, file);
    check_edit(&source, edit)?;
    let assignments = assignments(&source, origins, edit, &mut notes)?;
    let work = Work::new(&source, edit, assignments);
    let set = work.set(&mut notes);
    let mut additions = Additions::new(&source, edit.output.stem, file.options.most_unpacked);
    let split = work.split(set, &mut additions, &mut notes)?;
    let mut textures = Textures::new(edit);
    let uses = work.uses(&split);
    let replaced = match edit.convention {
        Convention::Mx | Convention::Plain => Replaced::default(),
        _ => uses.light(
            &source,
            edit,
            set,
            &mut textures,
            &mut additions,
            &mut notes,
        )?,
    };
    work.meshes(&split, &replaced, set, &mut additions, &mut notes);
    if edit.convention == Convention::Mx {
        work.nodes(set, &mut textures, &mut additions)?;
    }
    let mode = match edit.convention {
        Convention::Plain => LightsMode::Keep,
        _ => edit.lights,
    };
    let mut facts = Map::new();
    facts.insert("convention".into(), json!(name_of(edit.convention)));
    facts.insert("texCoord".into(), json!(set));
    let baked = lights::change(&source, mode, &mut additions);
    if !baked.is_empty() {
        facts.insert("baked".into(), json!(baked));
    }
    let (bytes, files) = undo::sealed(&source, additions, facts)?;
    Ok(PatchedFile {
        bytes,
        files,
        notes: notes.finish(),
    })
}

fn name_of(convention: Convention) -> &'static str {
    match convention {
        Convention::Moz => "moz",
        Convention::Mx => "mx",
        Convention::Emissive => "emissive",
        Convention::Unlit => "unlit",
        Convention::Plain => "plain",
    }
}

fn check_edit(source: &Source, edit: &LightmapEdit) -> Result<(), PatchError> {
    let is_number = |i: f64| i.is_finite() && i >= 0.0;
    if !edit.pages.iter().all(|page| is_number(page.intensity)) {
        return Err(source.refused("a lightmap whose intensity is no number, or negative"));
    }
    if edit.instances == InstanceMode::Node && edit.convention != Convention::Mx {
        return Err(source.refused("offsets at nodes, which only MX_lightmap has"));
    }
    Ok(())
}

/// An edit, and what it is about.
struct Work<'w, 's> {
    source: &'w Source<'s>,
    edit: &'w LightmapEdit<'w>,
    assignments: Vec<Assignment<'w>>,
    /// All meshes of the file.
    spans: Vec<Span>,
    /// The primitives of all meshes.
    meshes: Vec<Vec<PrimitiveJson<'s>>>,
}

/// What the primitives of each assignment become.
struct Split {
    /// For each assignment, the primitives that receive light.
    primitives: Vec<Vec<(usize, SplitPrimitive)>>,
    /// New accessors of each list of vertices; `None` where it could not be split.
    vertices: Vec<Option<NewVertices>>,
    /// Numbers of vertices of each list before and after.
    counts: Vec<[usize; 2]>,
    /// New indices of primitives, by assignment and primitive.
    indices: HashMap<(usize, usize), usize>,
}

impl<'w, 's> Work<'w, 's> {
    fn new(
        source: &'w Source<'s>,
        edit: &'w LightmapEdit<'w>,
        assignments: Vec<Assignment<'w>>,
    ) -> Work<'w, 's> {
        let spans = source.list("meshes");
        let meshes = spans
            .iter()
            .map(|span| PrimitiveJson::of_mesh(source.text(), span));
        Work {
            source,
            edit,
            assignments,
            meshes: meshes.collect(),
            spans,
        }
    }

    /// The number of the set of texture coordinates.
    fn set(&self, notes: &mut Notes) -> u32 {
        let mut materials = HashSet::new();
        for assignment in &self.assignments {
            for part in &assignment.parts {
                let primitive = &self.meshes[assignment.mesh].get(part.primitive);
                let variants = primitive.iter().flat_map(|p| &p.variants);
                materials.extend(variants.flatten());
                materials.extend(primitive.and_then(|p| p.material));
            }
        }
        let wished = self.edit.uv_set.unwrap_or(1);
        let set = free_set::of(self.source, &materials, wished);
        if set != wished {
            notes.add(&format!(
                "TEXCOORD_{wished} is used by a picture: the lightmap uses TEXCOORD_{set}, \
                 which some viewers do not know"
            ));
        }
        set
    }

    /// Gives all primitives their texture coordinates.
    fn split(
        &self,
        set: u32,
        additions: &mut Additions,
        notes: &mut Notes,
    ) -> Result<Split, PatchError> {
        let mut splits = Splits::default();
        let mut owners = HashMap::new();
        let mut primitives = Vec::new();
        for assignment in &self.assignments {
            if let Entry::Moved(base, _) | Entry::Shared(base, _) = assignment.entry {
                let same: Vec<(usize, SplitPrimitive)> = Clone::clone(&primitives[base]);
                let pages = same.into_iter().zip(&assignment.parts);
                primitives.push(
                    pages
                        .map(|((i, split), part)| {
                            (
                                i,
                                SplitPrimitive {
                                    page: part.page,
                                    ..split
                                },
                            )
                        })
                        .collect(),
                );
                continue;
            }
            let mesh = &self.meshes[assignment.mesh];
            let is_shared = assignment.entry == Entry::Own;
            let list = splits.add(self.source, mesh, &assignment.parts, is_shared);
            let list = list.map_err(|fault| {
                let node = assignment.node;
                self.source
                    .refused(format!("a layout that does not fit node {node}: {fault}"))
            })?;
            for (primitive, split) in &list {
                owners.entry(split.group).or_insert(&mesh[*primitive]);
            }
            primitives.push(list);
        }
        let accessors = NewAccessors::new(self.source);
        let name = format!("TEXCOORD_{set}");
        let mut vertices = Vec::new();
        for (i, group) in splits.groups.iter().enumerate() {
            let new = match owners.get(&i) {
                Some(owner) => accessors.vertices(group, owner, &name, additions)?,
                None => Err("no primitive".to_owned()),
            };
            if let Err(fault) = &new {
                notes.add(&format!("primitive without lightmap: {fault}"));
            }
            vertices.push(new.ok());
        }
        let mut split = Split {
            primitives,
            vertices,
            counts: splits.groups.iter().map(VertexGroup::counts).collect(),
            indices: HashMap::new(),
        };
        self.indices(&mut split, &accessors, additions)?;
        Ok(split)
    }

    /// Adds the indices that changed or were compressed.
    fn indices(
        &self,
        split: &mut Split,
        accessors: &NewAccessors,
        additions: &mut Additions,
    ) -> Result<(), PatchError> {
        for (a, assignment) in self.assignments.iter().enumerate() {
            for (i, primitive) in &split.primitives[a] {
                if split.vertices[primitive.group].is_none() {
                    continue;
                }
                let json = &self.meshes[assignment.mesh][*i];
                let counts = split.counts[primitive.group];
                if let Some(corners) = self.corners(json, primitive, counts) {
                    let new = accessors.corners(&corners, json.indices, additions)?;
                    split.indices.insert((a, *i), new);
                }
            }
        }
        Ok(())
    }

    /// The corners of a primitive that needs new indices.
    fn corners(
        &self,
        json: &PrimitiveJson,
        primitive: &SplitPrimitive,
        [before, after]: [usize; 2],
    ) -> Option<Vec<u32>> {
        // Vertices that there are not yet must not become those of the copies.
        let missing = |v: u32| if v == MISSING { after as u32 } else { v };
        if let Some(corners) = &primitive.corners {
            return Some(corners.iter().map(|v| missing(*v)).collect());
        }
        if after == before && !json.has_draco() {
            return None;
        }
        let corners = json.corners(self.source, before).ok()?;
        let is_copy = |v: u32| (before..after).contains(&(v as usize));
        // Without indices all vertices would be drawn, the copies, too.
        let is_needed =
            json.has_draco() || json.indices.is_none() || corners.iter().any(|v| is_copy(*v));
        let kept = corners
            .into_iter()
            .map(|v| if is_copy(v) { after as u32 } else { v });
        is_needed.then(|| kept.collect())
    }

    /// The light of the primitives of an assignment.
    fn lit(&self, split: &Split, assignment: usize) -> HashMap<usize, Lit> {
        let placement = match self.assignments[assignment].entry {
            Entry::Moved(_, placement) => Some(placement),
            _ => None,
        };
        let list = split.primitives[assignment].iter();
        let list = list.filter(|(_, p)| split.vertices[p.group].is_some());
        list.map(|(i, p)| (*i, Lit::new(p.page, placement)))
            .collect()
    }

    /// Who uses the materials once all meshes have changed.
    fn uses(&self, split: &Split) -> MaterialUses {
        let mut uses = MaterialUses::default();
        let mut changed = HashSet::new();
        let mut receiving = HashSet::new();
        for (a, assignment) in self.assignments.iter().enumerate() {
            receiving.insert(assignment.node);
            let lit = match assignment.entry {
                Entry::Shared(..) => continue,
                _ => self.lit(split, a),
            };
            if assignment.entry == Entry::Own {
                changed.insert(assignment.mesh);
            }
            for (i, primitive) in self.meshes[assignment.mesh].iter().enumerate() {
                uses.add(primitive, lit.get(&i).copied());
            }
        }
        let nodes = self.source.data.root.nodes.iter().enumerate();
        let others = nodes.filter(|(node, _)| !receiving.contains(node));
        let others: HashSet<usize> = others
            .filter_map(|(_, node)| node.mesh.map(|mesh| mesh.value()))
            .filter(|mesh| !changed.contains(mesh))
            .collect();
        for mesh in others {
            for primitive in &self.meshes[mesh] {
                uses.add(primitive, None);
            }
        }
        uses
    }

    /// Changes the mesh entries, and adds copies.
    fn meshes(
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
            if self.edit.convention == Convention::Unlit {
                drop_colours(change, json);
            }
            if let Some(indices) = split.indices.get(&(a, *i)) {
                change.key("indices").set(indices.to_string());
            }
            if primitive.corners.is_some() && json.mode != Some(gltf_json::mesh::Mode::Triangles) {
                notes.add("strip or fan with a seam: becomes a list of triangles");
                change.key("mode").set("4");
            }
            if json.has_draco() {
                notes.add("primitive compressed with Draco: is no longer");
                match json.extensions.len() {
                    1 => change.key("extensions").remove(),
                    _ => change.key("extensions").key(DRACO).remove(),
                }
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
        let mut changed = HashSet::new();
        for (a, assignment) in self.assignments.iter().enumerate() {
            if assignment.entry == Entry::Own {
                let lit = self.lit(split, a);
                changed.extend(lit.keys().map(|primitive| (assignment.mesh, *primitive)));
            }
        }
        let all = self.meshes.iter().enumerate();
        let mut all =
            all.flat_map(|(m, list)| list.iter().enumerate().map(move |(p, json)| ((m, p), json)));
        let compressed: Vec<(usize, usize)> = all
            .by_ref()
            .filter(|(_, json)| json.has_draco())
            .map(|(place, _)| place)
            .collect();
        if compressed.is_empty() || !compressed.iter().all(|place| changed.contains(place)) {
            return;
        }
        let text = self.source.text();
        for list in ["extensionsUsed", "extensionsRequired"] {
            let names = self.source.list(list);
            let is_draco = |span: &Span| super::scan::string(text, span).as_deref() == Some(DRACO);
            let found = names.iter().filter(|span| is_draco(span)).count();
            if found > 0 && found == names.len() && list == "extensionsRequired" {
                additions.edit.key(list).remove();
                continue;
            }
            for (i, _) in names.iter().enumerate().filter(|(_, span)| is_draco(span)) {
                additions.edit.key(list).index(i).remove();
            }
        }
    }

    /// Gives nodes their lightmap (`MX_lightmap`).
    fn nodes(
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
    // Names are numbered without gaps (glTF 2.0, 3.7.2.1).
    for lower in 0..set {
        let name = format!("TEXCOORD_{lower}");
        if json.attribute(&name).is_none() {
            change.key("attributes").key(&name).set(new.uvs.to_string());
        }
    }
    let name = format!("TEXCOORD_{set}");
    change.key("attributes").key(&name).set(new.uvs.to_string());
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
