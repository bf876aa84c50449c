//! What an edit gives to the objects of a file: texture coordinates of their vertices, and pages of their
//! materials.

use super::accessors::{NewAccessors, NewVertices};
use super::additions::Additions;
use super::assign::{Assignment, Entry};
use super::error::PatchError;
use super::free_set;
use super::materials::{Lit, MaterialUses};
use super::notes::Notes;
use super::primitives::PrimitiveJson;
use super::scan::Span;
use super::source::Source;
use super::splits::{MISSING, PrimitiveFaces, SplitPrimitive, Splits, VertexGroup};
use super::types::{LightmapEdit, LightmapUvs};
use std::collections::{HashMap, HashSet};

/// An edit, and what it is about.
pub struct Work<'w, 's> {
    /// The file.
    pub source: &'w Source<'s>,
    /// What is asked for.
    pub edit: &'w LightmapEdit<'w>,
    /// The objects that receive light.
    pub assignments: Vec<Assignment<'w>>,
    /// All meshes of the file.
    pub spans: Vec<Span>,
    /// The primitives of all meshes.
    pub meshes: Vec<Vec<PrimitiveJson<'s>>>,
}

/// What the primitives of each assignment become.
pub struct Split {
    /// For each assignment, the primitives that receive light.
    pub primitives: Vec<Vec<(usize, SplitPrimitive)>>,
    /// New accessors of each list of vertices; `None` where it could not be split.
    pub vertices: Vec<Option<NewVertices>>,
    /// Numbers of vertices of each list before and after.
    counts: Vec<[usize; 2]>,
    /// New indices of primitives, by assignment and primitive.
    pub indices: HashMap<(usize, usize), usize>,
}

impl<'w, 's> Work<'w, 's> {
    /// An edit of a file.
    pub fn new(
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
    ///
    /// # Errors
    /// Pictures use all sets.
    pub fn set(&self, notes: &mut Notes) -> Result<u32, PatchError> {
        let wished = match self.edit.uvs {
            LightmapUvs::Added(wished) => wished,
            LightmapUvs::Existing(set) => return self.existing_set(set),
        };
        let mut materials = HashSet::new();
        for assignment in &self.assignments {
            for part in &assignment.parts {
                let primitive = &self.meshes[assignment.mesh].get(part.primitive);
                let variants = primitive.iter().flat_map(|p| &p.variants);
                materials.extend(variants.flatten());
                materials.extend(primitive.and_then(|p| p.material));
            }
        }
        let set = free_set::of(self.source, &materials, wished);
        let taken = || format!("no set of texture coordinates from TEXCOORD_{wished} on is free");
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
        for assignment in &self.assignments {
            let mesh = &self.meshes[assignment.mesh];
            let has_it = |p: &PrimitiveJson| p.attribute(&name).is_some();
            let mut parts = assignment.parts.iter();
            if !parts.all(|part| mesh.get(part.primitive).is_some_and(has_it)) {
                let node = assignment.node;
                let found = format!("a lightmap in {name}, which the mesh of node {node} lacks");
                return Err(self.source.refused(found));
            }
        }
        Ok(set)
    }

    /// The primitives as they are.
    fn as_they_are(&self) -> Split {
        let of_part = |part: &PrimitiveFaces| {
            let split = SplitPrimitive {
                group: 0,
                page: part.page,
                corners: None,
            };
            (part.primitive, split)
        };
        let of_assignment = |a: &Assignment| a.parts.iter().map(of_part).collect();
        Split {
            primitives: self.assignments.iter().map(of_assignment).collect(),
            vertices: vec![Some(NewVertices::default())],
            counts: vec![[0; 2]],
            indices: HashMap::new(),
        }
    }

    /// Gives all primitives their texture coordinates.
    pub fn split(
        &self,
        set: u32,
        additions: &mut Additions,
        notes: &mut Notes,
    ) -> Result<Split, PatchError> {
        if let LightmapUvs::Existing(_) = self.edit.uvs {
            return Ok(self.as_they_are());
        }
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
        let mut vertices: Vec<Option<NewVertices>> = Vec::new();
        // Instances with the same seams share what they must copy.
        let mut known: HashMap<((&str, &str), &[u32]), usize> = HashMap::new();
        for (i, group) in splits.groups.iter().enumerate() {
            let Some(owner) = owners.get(&i) else {
                vertices.push(None);
                continue;
            };
            let same = *known.entry((owner.key, &group.sources)).or_insert(i);
            let new = match vertices.get(same) {
                Some(Some(same)) => accessors.same_vertices(group, same, additions).map(Ok)?,
                _ => accessors.vertices(group, owner, &name, additions)?,
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
}
