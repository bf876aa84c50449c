//! What an edit gives to the objects of a file: texture coordinates of their vertices, and pages of their
//! materials.

use super::accessors::NewVertices;
use super::additions::Additions;
use super::assign::{Assignment, Entry, meshes_of_nodes_without};
use super::error::PatchError;
use super::json::Json;
use super::materials::{Lit, MaterialUses};
use super::notes::Notes;
use super::primitives::Primitive;
use super::source::Source;
use super::splits::{MISSING, PrimitiveFaces, SplitPrimitive, Splits, VertexGroup};
use super::types::{LightmapEdit, LightmapUvs};
use std::collections::{HashMap, HashSet};

/// An edit, and what it is about.
pub struct Work<'w> {
    /// The file.
    pub source: &'w Source<'w>,
    /// What is asked for.
    pub edit: &'w LightmapEdit<'w>,
    /// The objects that receive light.
    pub assignments: Vec<Assignment<'w>>,
    /// The primitives of all meshes.
    pub meshes: Vec<Vec<Primitive>>,
}

/// What the primitives of each assignment become.
pub struct Split {
    /// For each assignment, the primitives that receive light.
    pub primitives: Vec<Vec<(usize, SplitPrimitive)>>,
    /// Lists of vertices.
    pub groups: Vec<VertexGroup>,
    /// New accessors of each list; `None` where it could not be split.
    pub vertices: Vec<Option<NewVertices>>,
}

/// Extensions whose own lightmap is replaced.
const LIGHTMAPS: [&str; 2] = ["MOZ_lightmap", "MX_lightmap"];

/// Sets of texture coordinates that a primitive may have: every one below that of the lightmap must be there.
const MOST_SETS: u32 = 8;

impl<'w> Work<'w> {
    /// The number of the set of texture coordinates.
    ///
    /// # Errors
    /// Pictures use all sets.
    pub fn set(&self, notes: &mut Notes) -> Result<u32, PatchError> {
        let wished = match self.edit.uvs {
            LightmapUvs::Added(wished) => wished,
            LightmapUvs::Existing(set) => return self.existing_set(set),
        };
        let mut used = HashSet::new();
        for (_, primitive) in self.parts() {
            let variants = primitive.iter().flat_map(|p| &p.variants);
            for material in variants
                .chain(primitive.iter().map(|p| &p.material))
                .flatten()
            {
                let material = self.source.json.entries("materials").get(*material);
                material
                    .into_iter()
                    .for_each(|json| add_used_sets(json, &mut used));
            }
        }
        let set = (wished..MOST_SETS).find(|set| !used.contains(&(*set as usize)));
        let taken = || format!("no set of texture coordinates is free, from TEXCOORD_{wished} up");
        let set = set.ok_or_else(|| self.source.refused(taken()))?;
        if set != wished {
            notes.add(&format!(
                "TEXCOORD_{wished} is used by a picture: the lightmap uses TEXCOORD_{set}, \
                 which some viewers do not know"
            ));
        }
        Ok(set)
    }

    /// A set that all primitives have.
    fn existing_set(&self, set: u32) -> Result<u32, PatchError> {
        let name = format!("TEXCOORD_{set}");
        let has_it = |p: &Primitive| p.attribute(&name).is_some();
        match self
            .parts()
            .find(|(_, primitive)| !primitive.is_some_and(has_it))
        {
            None => Ok(set),
            Some((node, _)) => {
                let found = format!("a lightmap in {name}, which the mesh of node {node} lacks");
                Err(self.source.refused(found))
            }
        }
    }

    /// The primitives that receive light, each with its node.
    fn parts(&self) -> impl Iterator<Item = (usize, Option<&Primitive>)> {
        self.assignments.iter().flat_map(move |assignment| {
            let mesh = &self.meshes[assignment.mesh];
            let parts = assignment.parts.iter();
            parts.map(move |part| (assignment.node, mesh.get(part.primitive)))
        })
    }

    /// The primitives as they are.
    fn as_they_are(&self) -> Split {
        let of_part = |part: &PrimitiveFaces| {
            let (group, page, corners) = (0, part.page, None);
            (
                part.primitive,
                SplitPrimitive {
                    group,
                    page,
                    corners,
                },
            )
        };
        let of_assignment = |a: &Assignment| a.parts.iter().map(of_part).collect();
        Split {
            primitives: self.assignments.iter().map(of_assignment).collect(),
            groups: vec![VertexGroup::default()],
            vertices: vec![Some(NewVertices::default())],
        }
    }

    /// Gives all primitives their texture coordinates.
    ///
    /// # Errors
    /// Layouts that do not fit.
    pub fn split(
        &self,
        set: u32,
        additions: &mut Additions,
        notes: &mut Notes,
    ) -> Result<Split, PatchError> {
        // Existing coordinates need neither new vertices nor new attributes.
        if let LightmapUvs::Existing(_) = self.edit.uvs {
            return Ok(self.as_they_are());
        }
        let mut splits = Splits::default();
        let mut owners: HashMap<usize, &Primitive> = HashMap::new();
        let mut primitives: Vec<Vec<(usize, SplitPrimitive)>> = Vec::new();
        for assignment in &self.assignments {
            // An object that shares the layout of another one takes its primitives, perhaps on another page.
            if let Entry::Moved(base, _) | Entry::Shared(base, _) = assignment.entry {
                let mut list = primitives[base].clone();
                for ((_, split), part) in list.iter_mut().zip(&assignment.parts) {
                    split.page = part.page;
                }
                primitives.push(list);
                continue;
            }
            // Only meshes that change in place may share their lists of vertices.
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
        // Write the vertices of each list once, with the attributes of the first primitive that uses it.
        let mut vertices_of = |(i, group): (usize, &VertexGroup)| {
            let new = additions.vertices(group, owners.get(&i)?, set);
            let note = |fault: &String| notes.add(&format!("primitive without lightmap: {fault}"));
            new.inspect_err(note).ok()
        };
        Ok(Split {
            primitives,
            vertices: splits
                .groups
                .iter()
                .enumerate()
                .map(&mut vertices_of)
                .collect(),
            groups: splits.groups,
        })
    }

    /// The corners of a primitive that needs new indices.
    pub fn corners(
        &self,
        own: &Primitive,
        split: &SplitPrimitive,
        group: &VertexGroup,
    ) -> Option<Vec<u32>> {
        let (before, after) = (group.count, group.uvs.len());
        // Vertices that there are not yet must not become those of the copies.
        if let Some(corners) = &split.corners {
            let there = |v: &u32| if *v == MISSING { after as u32 } else { *v };
            return Some(corners.iter().map(there).collect());
        }
        if after == before && !own.has_draco {
            return None;
        }
        let corners = own.corners(self.source, before).ok()?;
        let is_copy = |v: &u32| (before..after).contains(&(*v as usize));
        // Without indices all vertices would be drawn, the copies, too.
        let is_needed = own.has_draco || own.indices.is_none() || corners.iter().any(is_copy);
        let kept = corners
            .iter()
            .map(|v| if is_copy(v) { after as u32 } else { *v });
        is_needed.then(|| kept.collect())
    }

    /// The light of the primitives of an assignment.
    pub fn lit(&self, split: &Split, assignment: usize) -> HashMap<usize, Lit> {
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
    pub fn uses(&self, split: &Split) -> MaterialUses {
        let mut uses = MaterialUses::default();
        let nodes: HashSet<usize> = self.assignments.iter().map(|a| a.node).collect();
        let mut others = meshes_of_nodes_without(self.source, &nodes);
        for (a, assignment) in self.assignments.iter().enumerate() {
            match assignment.entry {
                Entry::Shared(..) => continue,
                Entry::Own => _ = others.remove(&assignment.mesh),
                Entry::Copy | Entry::Moved(..) => {}
            }
            let lit = self.lit(split, a);
            for (i, primitive) in self.meshes[assignment.mesh].iter().enumerate() {
                uses.add(primitive, lit.get(&i).copied());
            }
        }
        for primitive in others.into_iter().flat_map(|mesh| &self.meshes[mesh]) {
            uses.add(primitive, None);
        }
        uses
    }
}

/// Adds the sets of texture coordinates that the textures in a value use.
fn add_used_sets(json: &Json, used: &mut HashSet<usize>) {
    // References to textures have an index, and set 0 if they name none.
    let set = json.get("texCoord").and_then(Json::index);
    used.extend(set.or(json.get("index").map(|_| 0)));
    json.list()
        .iter()
        .for_each(|inner| add_used_sets(inner, used));
    for (key, inner) in json.members() {
        if !LIGHTMAPS.contains(&&**key) {
            add_used_sets(inner, used);
        }
    }
}
