//! The two sides of sheets: faces turned over, written twice, and joined again.
//!
//! In memory a face is a single sheet, and may carry the irradiance of both sides
//! ([`Mesh::back`]). Files without room for that have it as two faces: the given one and its
//! reversed copy ([`Scene::split_sides`]), which become one again when they are read
//! ([`Scene::join_sides`]).

use crate::{Attribute, BackIrradiance, Faces, MaterialId, Mesh, Object};
use crate::{Rgb, Scene, Shape, Sidedness};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

/// Marks a vertex that has no copy.
const NO_VERTEX: u32 = u32::MAX;

impl Scene {
    /// The scene with every face whose back has irradiance written twice: the face itself, and
    /// behind all others its reversed copy with the irradiance, the normals and the texture
    /// coordinates of the back. Both get a material that is visible from one side.
    ///
    /// Such faces coincide, so this is for files, not for tracing rays.
    pub fn split_sides(&self) -> Cow<'_, Scene> {
        let is_double = |o: &Object| o.shape.placed_mesh().is_some_and(|m| m.back.is_some());
        if !self.objects.iter().any(is_double) {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        // Faces of a shared mesh cannot be written twice for one of its places.
        scene.unfold_if(is_double);
        let changed = scene.change_meshes(Mesh::split);
        scene.restate(&changed, Sidedness::One);
        Cow::Owned(scene)
    }

    /// Joins each pair of faces with irradiance of which one is the reversed copy of the other, on
    /// vertices of its own: the undoing of [`split_sides`](Scene::split_sides). The materials of
    /// these faces become two-sided.
    pub fn join_sides(&mut self) {
        let changed = self.change_meshes(Mesh::join);
        self.restate(&changed, Sidedness::Two);
    }

    /// Applies a change to all meshes; the faces that it returns, by object.
    fn change_meshes(&mut self, change: impl Fn(&mut Mesh) -> Vec<usize>) -> Vec<Vec<usize>> {
        let change_object = |o: &mut Object| match &mut o.shape {
            Shape::Mesh(mesh) => change(mesh),
            _ => Vec::new(),
        };
        self.objects.iter_mut().map(change_object).collect()
    }

    /// Gives some faces of each object materials of a sidedness: copies, where other faces have
    /// the same material.
    fn restate(&mut self, changed: &[Vec<usize>], sidedness: Sidedness) {
        let shared = self.materials_beside(changed);
        let mut restated: HashMap<MaterialId, MaterialId> = HashMap::new();
        let materials = &mut self.materials;
        for (object, faces) in self.objects.iter_mut().zip(changed) {
            let Shape::Mesh(mesh) = &mut object.shape else {
                continue;
            };
            for &face in faces {
                let id = &mut mesh.face_materials[face];
                *id = *restated.entry(*id).or_insert_with(|| {
                    let old = &mut materials[*id as usize];
                    if old.sidedness == sidedness {
                        return *id;
                    }
                    if !shared[*id as usize] {
                        old.sidedness = sidedness;
                        return *id;
                    }
                    let mut copy = old.clone();
                    copy.sidedness = sidedness;
                    materials.push(copy);
                    materials.len() as MaterialId - 1
                });
            }
        }
    }

    /// Whether each material belongs to more than those faces.
    fn materials_beside(&self, changed: &[Vec<usize>]) -> Vec<bool> {
        let mut is_used = vec![false; self.materials.len()];
        for (object, faces) in self.objects.iter().zip(changed) {
            match &object.shape {
                Shape::Mesh(mesh) => {
                    let mut is_changed = vec![false; mesh.faces.len()];
                    faces.iter().for_each(|&f| is_changed[f] = true);
                    let others = mesh.face_materials.iter().zip(&is_changed);
                    others
                        .filter(|(_, changed)| !**changed)
                        .for_each(|(&m, _)| is_used[m as usize] = true);
                }
                Shape::Instance(instance) => {
                    let materials = instance.mesh.face_materials.iter();
                    materials.for_each(|&m| is_used[m as usize] = true);
                }
                Shape::Primitive(p) => is_used[p.material as usize] = true,
                Shape::Exact(exact) => {
                    let leaves = exact.leaves();
                    leaves
                        .iter()
                        .for_each(|l| is_used[l.material() as usize] = true);
                }
            }
        }
        is_used
    }
}

impl Mesh {
    /// Reverses the faces for which `is_turned` holds, so that their backs become their fronts.
    /// Normals that only these faces use are reversed with them; irradiance stays as it is.
    pub fn turn_faces(&mut self, is_turned: impl Fn(usize) -> bool) {
        let turned: Vec<usize> = (0..self.faces.len()).filter(|&f| is_turned(f)).collect();
        if turned.is_empty() {
            return;
        }
        if let Some(normals) = &mut self.normals {
            turn_normals(normals, &self.faces, &turned);
        }
        turned.into_iter().for_each(|f| self.reverse_face(f));
    }

    /// Reverses the corners of a face: its front becomes its back. Normals stay.
    pub fn reverse_face(&mut self, face: usize) {
        let range = self.faces.corner_range(face);
        for corners in self.corner_indices() {
            // The first corner stays, so that the face is triangulated as before.
            corners[range.start + 1..range.end].reverse();
        }
    }

    /// Whether the irradiance on the back of a face is known.
    pub fn has_back(&self, face: usize) -> bool {
        self.back.as_deref().is_some_and(|back| {
            let mut corners = self.faces.get(face).iter();
            corners.all(|&v| back.irradiance[v as usize].is_some())
        })
    }

    /// Appends a reversed copy of every face whose back has irradiance, with vertices of its own;
    /// returns these faces and their copies.
    fn split(&mut self) -> Vec<usize> {
        let doubled: Vec<usize> = (0..self.faces.len())
            .filter(|&f| self.has_back(f))
            .collect();
        let Some(back) = self.back.take() else {
            return doubled;
        };
        // Copy the vertices of the doubled faces, as both sides have values of their own.
        let first = self.faces.len();
        let corners: Vec<usize> = doubled
            .iter()
            .flat_map(|&f| reversed(self.faces.corner_range(f)))
            .collect();
        let copies = VertexCopies::of(self, &corners);
        let originals = &copies.originals;
        copies.extend(&mut self.positions, |p| p);
        copies.extend(&mut self.colors, |c| c);
        // Give the copies the light of the backs, and normals that point to their side.
        let light = |&v: &usize| back.irradiance[v].unwrap_or(Rgb::BLACK);
        self.irradiance.extend(originals.iter().map(light));
        if !self.irradiance_error.is_empty() {
            let error = |&v: &usize| back.error.get(v).copied().unwrap_or(Rgb::BLACK);
            self.irradiance_error.extend(originals.iter().map(error));
        }
        if let Some(normals) = &mut self.normals {
            copies.extend_attribute(normals, &corners, |n: DVec3| -n);
        }
        for uvs in [&mut self.uvs, &mut self.lightmap_uvs]
            .into_iter()
            .flatten()
        {
            copies.extend_attribute(uvs, &corners, |uv| uv);
        }
        // Append the reversed faces behind all others, whose numbers stay.
        let mut ring = Vec::new();
        for &face in &doubled {
            let order = reversed(self.faces.corner_range(face));
            ring.clear();
            ring.extend(order.map(|c| copies.numbers[self.faces.corners[c] as usize]));
            self.push_face(&ring, self.face_materials[face]);
            if !self.smoothing.is_empty() {
                self.smoothing.push(self.smoothing[face]);
            }
        }
        let added = first..self.faces.len();
        doubled.into_iter().chain(added).collect()
    }

    /// Joins the faces of which one is the reversed copy of the other; returns those that remain of
    /// such pairs.
    fn join(&mut self) -> Vec<usize> {
        if self.irradiance.is_empty() || self.back.is_some() {
            return Vec::new();
        }
        let places = self.places();
        let mut back = BackIrradiance {
            irradiance: vec![None; self.positions.len()],
            error: vec![Rgb::BLACK; self.irradiance_error.len()],
        };
        let mut is_copy = vec![false; self.faces.len()];
        let mut joined = Vec::new();
        for [face, copy] in self.reversed_pairs(&places) {
            if self.join_pair([face, copy], &places, &mut back) {
                is_copy[copy] = true;
                joined.push(face);
            }
        }
        if joined.is_empty() {
            return joined;
        }
        self.back = Some(Box::new(back));
        let mut number = 0;
        let new: Vec<usize> = is_copy
            .iter()
            .map(|&copy| {
                number += usize::from(!copy);
                number - usize::from(!copy)
            })
            .collect();
        self.remove_faces(&is_copy);
        joined.into_iter().map(|f| new[f]).collect()
    }

    /// A number for each vertex, the same for equal positions.
    fn places(&self) -> Vec<u32> {
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        let place = |p: &DVec3| {
            let next = known.len() as u32;
            // Adding zero turns −0 into 0, so that equal positions have equal bits.
            let bits = (*p + DVec3::ZERO).to_array().map(f64::to_bits);
            *known.entry(bits).or_insert(next)
        };
        self.positions.iter().map(place).collect()
    }

    /// Pairs of faces of one material with the same corners in opposite order, the earlier one
    /// first.
    fn reversed_pairs(&self, places: &[u32]) -> Vec<[usize; 2]> {
        let mut pairs = Vec::new();
        let mut known: HashMap<(MaterialId, Vec<u32>), usize> = HashMap::new();
        for (face, corners) in self.faces.iter().enumerate() {
            let material = self.face_materials[face];
            let ring: Vec<u32> = corners.iter().map(|&v| places[v as usize]).collect();
            let opposite = from_least(ring.iter().rev().copied().collect());
            if let Some(first) = known.remove(&(material, opposite)) {
                pairs.push([first, face]);
            } else {
                known.entry((material, from_least(ring))).or_insert(face);
            }
        }
        pairs
    }

    /// Takes the irradiance of `copy` as that of the back of `face`; `false`, without any change, if
    /// they share vertices, or if the vertices have another irradiance on their backs already.
    fn join_pair(
        &self,
        [face, copy]: [usize; 2],
        places: &[u32],
        back: &mut BackIrradiance,
    ) -> bool {
        let at = |v: u32| places[v as usize];
        let twins = self.faces.get(copy);
        let pairs = self.faces.get(face).iter().filter_map(|&v| {
            let twin = twins.iter().find(|&&w| at(w) == at(v))?;
            Some((v as usize, *twin as usize))
        });
        let pairs: Vec<(usize, usize)> = pairs.collect();
        let fits = |&(v, twin): &(usize, usize)| {
            let new = self.irradiance[twin];
            v != twin && back.irradiance[v].is_none_or(|known| known == new)
        };
        if !pairs.iter().all(fits) {
            return false;
        }
        for (v, twin) in pairs {
            back.irradiance[v] = Some(self.irradiance[twin]);
            if let Some(error) = back.error.get_mut(v) {
                *error = self.irradiance_error[twin];
            }
        }
        true
    }

    /// Removes faces, and the vertices that only they used.
    fn remove_faces(&mut self, is_removed: &[bool]) {
        // A vertex goes if removed faces use it and kept ones do not; those that no face used stay.
        let (mut is_kept, mut is_dropped) = (
            vec![false; self.positions.len()],
            vec![false; self.positions.len()],
        );
        for (face, corners) in self.faces.iter().enumerate() {
            let uses = if is_removed[face] {
                &mut is_dropped
            } else {
                &mut is_kept
            };
            corners.iter().for_each(|&v| uses[v as usize] = true);
        }
        let stays = |v: usize| is_kept[v] || !is_dropped[v];
        // Write the kept faces with the new numbers of their vertices.
        let old = std::mem::take(&mut self.faces);
        let mut number = 0;
        let new: Vec<u32> = (0..self.positions.len())
            .map(|v| {
                number += u32::from(stays(v));
                number.saturating_sub(1)
            })
            .collect();
        let mut corner_stays = Vec::with_capacity(old.corners.len());
        for (corners, &removed) in old.iter().zip(is_removed) {
            corner_stays.extend(corners.iter().map(|_| !removed));
            if !removed {
                let ring: Vec<u32> = corners.iter().map(|&v| new[v as usize]).collect();
                self.faces.push(&ring);
            }
        }
        // Remove the values of what has gone, per vertex, corner and face.
        retain(&mut self.positions, stays);
        retain(&mut self.colors, stays);
        retain(&mut self.irradiance, stays);
        retain(&mut self.irradiance_error, stays);
        if let Some(back) = &mut self.back {
            retain(&mut back.irradiance, stays);
            retain(&mut back.error, stays);
        }
        retain_attribute(self.normals.as_mut(), stays, &corner_stays);
        retain_attribute(self.uvs.as_mut(), stays, &corner_stays);
        retain_attribute(self.lightmap_uvs.as_mut(), stays, &corner_stays);
        retain(&mut self.face_materials, |f| !is_removed[f]);
        retain(&mut self.smoothing, |f| !is_removed[f]);
    }
}

/// Copies of the vertices of some corners.
struct VertexCopies {
    /// The vertices, each once.
    originals: Vec<usize>,
    /// For every vertex the index of its copy.
    numbers: Vec<u32>,
}

impl VertexCopies {
    fn of(mesh: &Mesh, corners: &[usize]) -> VertexCopies {
        let count = mesh.positions.len();
        let (mut originals, mut numbers) = (Vec::new(), vec![NO_VERTEX; count]);
        for &corner in corners {
            let vertex = mesh.faces.corners[corner] as usize;
            if numbers[vertex] == NO_VERTEX {
                numbers[vertex] = (count + originals.len()) as u32;
                originals.push(vertex);
            }
        }
        VertexCopies { originals, numbers }
    }

    /// Appends the values of the copies to a list of values per vertex, which may be absent.
    fn extend<T: Copy>(&self, list: &mut Vec<T>, value: impl Fn(T) -> T) {
        if !list.is_empty() {
            let more: Vec<T> = self.originals.iter().map(|&v| value(list[v])).collect();
            list.extend(more);
        }
    }

    /// The same for an attribute, which gains the copied `corners` where it belongs to corners.
    fn extend_attribute<T: Copy>(
        &self,
        attribute: &mut Attribute<T>,
        corners: &[usize],
        value: impl Fn(T) -> T,
    ) {
        let Some(index) = &mut attribute.corners else {
            return self.extend(&mut attribute.values, value);
        };
        let base = attribute.values.len() as u32;
        let more: Vec<T> = attribute.values.iter().map(|&x| value(x)).collect();
        attribute.values.extend(more);
        let copies: Vec<u32> = corners.iter().map(|&c| base + index[c]).collect();
        index.extend(copies);
    }
}

/// The corners of a face in opposite order; the first stays the first, so that both are
/// triangulated alike.
fn reversed(corners: Range<usize>) -> impl Iterator<Item = usize> {
    let first = corners.start;
    std::iter::once(first).chain((first + 1..corners.end).rev())
}

/// A ring that begins with its least number.
fn from_least(mut ring: Vec<u32>) -> Vec<u32> {
    let least = (0..ring.len()).min_by_key(|&k| ring[k]).unwrap_or(0);
    ring.rotate_left(least);
    ring
}

/// Negates the normals that belong to `turned` faces, in ascending order, and to no others.
fn turn_normals(normals: &mut Attribute<DVec3>, faces: &Faces, turned: &[usize]) {
    let count = normals.values.len();
    let (mut has_turned, mut has_others) = (vec![false; count], vec![false; count]);
    let mut next = turned.iter().peekable();
    for face in 0..faces.len() {
        let uses = if next.next_if(|&&f| f == face).is_some() {
            &mut has_turned
        } else {
            &mut has_others
        };
        for corner in faces.corner_range(face) {
            let value = match &normals.corners {
                Some(index) => index[corner],
                None => faces.corners[corner],
            };
            uses[value as usize] = true;
        }
    }
    for (k, n) in normals.values.iter_mut().enumerate() {
        if has_turned[k] && !has_others[k] {
            *n = -*n;
        }
    }
}

/// Keeps the values at the positions where `stays` holds.
fn retain<T>(list: &mut Vec<T>, stays: impl Fn(usize) -> bool) {
    let mut position = 0;
    list.retain(|_| {
        position += 1;
        stays(position - 1)
    });
}

fn retain_attribute<T>(
    attribute: Option<&mut Attribute<T>>,
    stays: impl Fn(usize) -> bool,
    corner_stays: &[bool],
) {
    match attribute {
        Some(Attribute {
            corners: Some(index),
            ..
        }) => retain(index, |c| corner_stays[c]),
        Some(Attribute { values, .. }) => retain(values, stays),
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;
    use glam::{DVec2, dvec2, dvec3};

    /// A folded sheet of a quadrilateral and a triangle with light on both sides, and a triangle
    /// apart with light on its front only, all of one material.
    fn sheets() -> Scene {
        let mut scene = Scene::default();
        let paper = scene.add_material(Material {
            sidedness: Sidedness::Two,
            ..Material::diffuse("paper", Rgb::grey(0.5))
        });
        let mut mesh = Mesh {
            positions: vec![
                dvec3(0.0, 0.0, 0.0),
                dvec3(1.0, 0.0, 0.0),
                dvec3(1.0, 1.0, 0.0),
                dvec3(0.0, 1.0, 0.0),
                dvec3(2.0, 0.5, 1.0),
                dvec3(5.0, 0.0, 0.0),
                dvec3(6.0, 0.0, 0.0),
                dvec3(5.0, 1.0, 0.0),
            ],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], paper);
        mesh.push_face(&[5, 6, 7], paper);
        mesh.push_face(&[1, 4, 2], paper);
        let count = mesh.positions.len();
        let numbers = |from: f64| (0..count).map(move |k| Rgb::grey(from + k as f64));
        mesh.irradiance = numbers(1.0).collect();
        mesh.irradiance_error = numbers(0.1).collect();
        mesh.back = Some(Box::new(BackIrradiance {
            irradiance: numbers(20.0).map(Some).take(5).chain([None; 3]).collect(),
            error: numbers(0.5).take(5).chain([Rgb::BLACK; 3]).collect(),
        }));
        mesh.colors = numbers(0.0).map(|c| c * 0.1).collect();
        mesh.normals = Some(Attribute::per_vertex(vec![DVec3::Z; count]));
        let uv = |k: usize| dvec2(k as f64, 1.0);
        mesh.uvs = Some(Attribute {
            values: (0..10).map(uv).collect(),
            corners: Some((0..10).collect()),
        });
        mesh.smoothing = vec![1, 2, 3];
        scene.objects.push(Object::new("sheets", Shape::Mesh(mesh)));
        scene.validate().unwrap();
        scene
    }

    fn mesh(scene: &Scene) -> &Mesh {
        match &scene.objects[0].shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("the scene has one mesh"),
        }
    }

    #[test]
    fn sheets_are_written_twice() {
        let given = sheets();
        let split = given.split_sides();
        split.validate().unwrap();
        let (old, new) = (mesh(&given), mesh(&split));
        assert_eq!((new.faces.len(), new.positions.len()), (5, 13));
        assert_eq!(new.smoothing, [1, 2, 3, 1, 3]);
        let normals = new.normals.as_ref().unwrap();
        let uvs = new.uvs.as_ref().unwrap();
        for (face, copy) in [(0, 3), (2, 4)] {
            assert_eq!(new.face_area_vector(copy), -old.face_area_vector(face));
            let (range, ring) = (new.faces.corner_range(face), new.faces.get(face));
            for (at, &twin) in new.faces.corner_range(copy).zip(new.faces.get(copy)) {
                let position = new.positions[twin as usize];
                let k = (0..ring.len())
                    .find(|&k| old.positions[ring[k] as usize] == position)
                    .expect("the same corners");
                let v = ring[k] as usize;
                let back = old.back.as_ref().unwrap();
                assert_eq!(Some(new.irradiance[twin as usize]), back.irradiance[v]);
                assert_eq!(new.irradiance_error[twin as usize], back.error[v]);
                assert_eq!(new.colors[twin as usize], old.colors[v]);
                assert_eq!(normals.at(at, twin), -DVec3::Z);
                let uv: DVec2 = uvs.at(range.start + k, ring[k]);
                assert_eq!(uvs.at(at, twin), uv);
            }
        }
        let sidedness = |face: usize| {
            let id = new.face_materials[face];
            split.materials[id as usize].sidedness
        };
        let expected = [1, 2, 1, 1, 1].map(|n| match n {
            1 => Sidedness::One,
            _ => Sidedness::Two,
        });
        assert_eq!([0, 1, 2, 3, 4].map(sidedness), expected);
    }

    #[test]
    fn what_was_split_is_joined() {
        let given = sheets();
        let mut scene = given.split_sides().into_owned();
        scene.join_sides();
        scene.validate().unwrap();
        let (old, new) = (mesh(&given), mesh(&scene));
        let mut uvs = new.uvs.clone().unwrap();
        uvs.values.truncate(10);
        let same = Mesh {
            uvs: Some(uvs),
            face_materials: old.face_materials.clone(),
            ..new.clone()
        };
        assert_eq!(&same, old);
        let is_double = |&m: &u32| scene.materials[m as usize].sidedness == Sidedness::Two;
        assert!(new.face_materials.iter().all(is_double));
    }

    /// A modeller's own second faces share the vertices of the first, or have no light yet.
    #[test]
    fn other_faces_back_to_back_stay() {
        let mut scene = sheets();
        let Shape::Mesh(paper) = &mut scene.objects[0].shape else {
            unreachable!("the scene has one mesh")
        };
        paper.back = None;
        paper.uvs = None;
        paper.push_face(&[7, 6, 5], 0);
        paper.smoothing.push(0);
        let mut joined = scene.clone();
        joined.join_sides();
        assert_eq!(joined, scene);
        let mut dark = sheets().split_sides().into_owned();
        let Shape::Mesh(paper) = &mut dark.objects[0].shape else {
            unreachable!("the scene has one mesh")
        };
        (paper.irradiance, paper.irradiance_error) = (Vec::new(), Vec::new());
        let mut joined = dark.clone();
        joined.join_sides();
        assert_eq!(joined, dark);
    }

    #[test]
    fn faces_are_turned_with_the_normals_that_are_theirs_alone() {
        let Scene { mut objects, .. } = sheets();
        let Shape::Mesh(mesh) = &mut objects[0].shape else {
            unreachable!("the scene has one mesh")
        };
        let before = mesh.clone();
        mesh.turn_faces(|f| f > 0);
        let area = |mesh: &Mesh, f| mesh.face_area_vector(f);
        assert_eq!(area(mesh, 0), area(&before, 0));
        assert_eq!(
            [1, 2].map(|f| area(mesh, f)),
            [1, 2].map(|f| -area(&before, f))
        );
        let z: Vec<f64> = mesh
            .normals
            .as_ref()
            .unwrap()
            .values
            .iter()
            .map(|n| n.z)
            .collect();
        assert_eq!(z, [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0]);
        assert_eq!(
            mesh.uvs.as_ref().unwrap().corners.as_ref().unwrap()[4..],
            [4, 6, 5, 7, 9, 8]
        );
        assert_eq!(mesh.irradiance, before.irradiance);
    }
}
