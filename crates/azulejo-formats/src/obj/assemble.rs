//! Converts the flat lists of a file to a scene: one mesh per object, each with its own vertices.

use super::lists::{NONE, ObjLists};
use super::mtl::Library;
use super::placement::{apply_placement, per_vertex_if_possible};
use crate::reading::warnings::Warnings;
use azulejo_scene::math::area_vector;
use azulejo_scene::{Attribute, Faces, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Builds the scene of a file whose indices have been checked.
pub(super) fn assemble(
    mut raw: ObjLists,
    mut library: Library,
    file: &str,
    warnings: &mut Warnings,
) -> Scene {
    let names = &raw.material_names;
    let mut materials: Vec<MaterialId> = names
        .iter()
        .map(|name| library.find_or_default(name, file, warnings))
        .collect();
    // The last entry is for faces before the first `usemtl`.
    let nameless = |list: &Vec<u32>| list.contains(&NONE);
    let mut surfaces = raw.surfaces.iter().map(|s| &s.mesh.face_materials);
    if nameless(&raw.face_materials) || surfaces.any(nameless) {
        materials.push(library.default_material());
    }
    if raw.faces.is_empty() && raw.surfaces.is_empty() {
        warnings.add_whole(file, "no faces: the scene is empty");
    }
    let mut surfaces = std::mem::take(&mut raw.surfaces).into_iter().peekable();
    let mut builder = ObjMeshBuilder {
        raw: &raw,
        materials: &materials,
        local: Vec::new(),
        warnings,
        file,
    };
    let mut objects = Vec::new();
    for (part, (name, faces)) in parts(&raw).into_iter().enumerate() {
        if !faces.is_empty() {
            let mut mesh = builder.mesh(faces);
            apply_placement(&mut mesh, |material| library.placement(material));
            objects.push(Object::new(name, Shape::Mesh(mesh)));
        }
        while let Some(surface) = surfaces.next_if(|s| s.part == part) {
            let mut mesh = surface.mesh;
            for material in &mut mesh.face_materials {
                *material = builder.material(*material);
            }
            apply_placement(&mut mesh, |material| library.placement(material));
            objects.push(Object::new(name, Shape::Mesh(mesh)));
        }
    }
    Scene {
        objects,
        materials: library.materials,
        textures: library.textures.into_list(),
        ..Scene::default()
    }
}

/// Names and face ranges of the parts: what precedes the first `o` or `g`, and from each to the
/// next.
fn parts(raw: &ObjLists) -> Vec<(&str, Range<usize>)> {
    let starts = raw.parts.iter().map(|p| p.first_face);
    let ends = starts.clone().chain([raw.face_materials.len()]);
    let names = raw.parts.iter().map(|p| p.name.as_str());
    let ranges = [0].into_iter().chain(starts).zip(ends);
    let named = [""].into_iter().chain(names).zip(ranges);
    named
        .map(|(name, (start, end))| (name, start..end))
        .collect()
}

struct ObjMeshBuilder<'a> {
    raw: &'a ObjLists,
    materials: &'a [MaterialId],
    /// New index of each old one while a list is renumbered; all [`NONE`] between uses.
    local: Vec<u32>,
    warnings: &'a mut Warnings,
    file: &'a str,
}

impl ObjMeshBuilder<'_> {
    fn mesh(&mut self, range: Range<usize>) -> Mesh {
        let raw = self.raw;
        let corners = raw.faces.starts[range.start] as usize..raw.faces.starts[range.end] as usize;
        let (used, local) = self.renumber(&raw.faces.corners[corners.clone()]);
        let mut mesh = Mesh {
            positions: used.iter().map(|&v| raw.positions[v as usize]).collect(),
            colors: colors(raw, &used),
            faces: Faces {
                starts: raw.faces.starts[range.start..=range.end]
                    .iter()
                    .map(|s| s - corners.start as u32)
                    .collect(),
                corners: local,
            },
            face_materials: raw.face_materials[range.clone()]
                .iter()
                .map(|&m| self.material(m))
                .collect(),
            smoothing: smoothing(raw, range),
            ..Mesh::default()
        };
        mesh.uvs = self.uvs(&mesh, corners.clone());
        mesh.normals = self.normals(&mesh, corners);
        mesh
    }

    /// Material of a face; all faces without one share the last entry.
    fn material(&self, named: u32) -> MaterialId {
        self.materials[(named as usize).min(self.materials.len() - 1)]
    }

    /// The distinct indices in increasing order, and for each entry its position among them.
    /// [`NONE`] is kept.
    fn renumber(&mut self, indices: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut used = Vec::new();
        for &i in indices.iter().filter(|i| **i != NONE) {
            let at = i as usize;
            if at >= self.local.len() {
                self.local.resize(at + 1, NONE);
            }
            if self.local[at] == NONE {
                self.local[at] = 0;
                used.push(i);
            }
        }
        self.order(&mut used);
        for (new, &old) in used.iter().enumerate() {
            self.local[old as usize] = new as u32;
        }
        let local = |&i: &u32| self.local.get(i as usize).copied().unwrap_or(NONE);
        let renumbered = indices.iter().map(local).collect();
        for &old in &used {
            self.local[old as usize] = NONE;
        }
        (used, renumbered)
    }

    /// Sorts indices that are marked in `local`, by scanning their range where that is faster.
    fn order(&self, used: &mut Vec<u32>) {
        let low = used.iter().min().map_or(0, |i| *i as usize);
        let high = used.iter().max().map_or(0, |i| *i as usize);
        if high - low >= 4 * used.len() {
            return used.sort_unstable();
        }
        used.clear();
        let marked = (low..=high).filter(|&i| self.local.get(i).is_some_and(|l| *l != NONE));
        used.extend(marked.map(|i| i as u32));
    }

    fn uvs(&mut self, mesh: &Mesh, corners: Range<usize>) -> Option<Attribute<DVec2>> {
        let given = self.raw.corner_uvs.get(corners)?;
        let (used, mut local) = self.renumber(given);
        if used.is_empty() {
            return None;
        }
        let mut values: Vec<DVec2> = used.iter().map(|&t| self.raw.uvs[t as usize]).collect();
        if local.contains(&NONE) {
            self.warn("object with texture coordinates at only some corners: (0, 0) at the others");
            let origin = values.len() as u32;
            values.push(DVec2::ZERO);
            local
                .iter_mut()
                .filter(|t| **t == NONE)
                .for_each(|t| *t = origin);
        }
        Some(per_vertex_if_possible(mesh, values, local))
    }

    fn normals(&mut self, mesh: &Mesh, corners: Range<usize>) -> Option<Attribute<DVec3>> {
        let raw = self.raw;
        let usable = |&n: &u32| match raw.normals.get(n as usize) {
            Some(&value) if value != DVec3::ZERO => n,
            _ => NONE,
        };
        let given: Vec<u32> = raw
            .corner_normals
            .get(corners)?
            .iter()
            .map(usable)
            .collect();
        let (used, mut local) = self.renumber(&given);
        if used.is_empty() {
            return None;
        }
        let mut values: Vec<DVec3> = used.iter().map(|&n| raw.normals[n as usize]).collect();
        if local.contains(&NONE) {
            self.warn("object with normals at only some corners: face normals at the others");
            fill_with_face_normals(mesh, &mut values, &mut local);
        }
        Some(per_vertex_if_possible(mesh, values, local))
    }

    fn warn(&mut self, message: &str) {
        self.warnings.add_whole(self.file, message);
    }
}

/// Gives corners without a normal the normal of their face.
fn fill_with_face_normals(mesh: &Mesh, values: &mut Vec<DVec3>, local: &mut [u32]) {
    for face in 0..mesh.faces.len() {
        let corners = &mut local[mesh.faces.corner_range(face)];
        if !corners.contains(&NONE) {
            continue;
        }
        // A face without area is invisible; any unit vector will do.
        let normal = area_vector(&mesh.face_positions(face)).normalize_or(DVec3::Z);
        let own = values.len() as u32;
        values.push(normal);
        corners
            .iter_mut()
            .filter(|n| **n == NONE)
            .for_each(|n| *n = own);
    }
}

fn colors(raw: &ObjLists, used: &[u32]) -> Vec<Rgb> {
    let color = |&v: &u32| raw.colors.get(v as usize).copied().flatten();
    if used.iter().all(|v| color(v).is_none()) {
        return Vec::new();
    }
    used.iter()
        .map(|v| color(v).unwrap_or(Rgb::WHITE))
        .collect()
}

/// Groups of faces, 0 before the first `s`; none if there is no `s` before their end.
fn smoothing(raw: &ObjLists, faces: Range<usize>) -> Vec<u32> {
    let group = |&group: &u32| if group == NONE { 0 } else { group };
    match raw.smoothing.get(faces) {
        Some(groups) if groups.iter().any(|g| *g != NONE) => groups.iter().map(group).collect(),
        _ => Vec::new(),
    }
}
