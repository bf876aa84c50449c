//! Fronts that receive, in files that are written anew: faces turned to their light, and backs as faces of their
//! own.
//!
//! Old formats do not say which side of a face is its front, so of each chart the side that gets more light is
//! baked, or both are. Whoever reads the file takes the order of corners for the front, and so it is made to be.

use super::Baked;
use super::source::{BakeSource, SourceError};
use azulejo_bake::layout::NO_CHART;
use azulejo_scene::{MaterialId, Mesh, Object, Scene, Shape, Sidedness};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

impl BakeSource {
    /// Reverses faces of a file that was written of a scene, where the lightmap has the light of their backs, in
    /// the scene, the file and the lightmap alike. Where it has that of both sides, backs become objects of their
    /// own, and neither side is seen from the other. The user's own file stays as it is. An instance with such
    /// faces gets a mesh of its own.
    ///
    /// # Errors
    /// [`SourceError`], as when the file was written first.
    pub fn turn_to_light(&mut self, baked: &mut Baked) -> Result<(), SourceError> {
        if self.is_given {
            return Ok(());
        }
        let turned: Vec<Vec<bool>> = (0..baked.atlas.receivers.len())
            .map(|receiver| turned_triangles(baked, receiver))
            .collect();
        if !turned.iter().flatten().any(|&is_turned| is_turned) {
            return Ok(());
        }
        let mut scene = self.scene.clone();
        let mut one_sided = HashMap::new();
        let mut seen = HashSet::new();
        for (receiver, turned) in turned.iter().enumerate() {
            let object = baked.objects[receiver];
            // An object with light on both sides has two receivers, the second one for its other side.
            let is_second_side = !seen.insert(object);
            if !turned.contains(&true) {
                continue;
            }
            let old = &scene.objects[object as usize];
            let mesh = match &old.shape {
                Shape::Mesh(mesh) => mesh.clone(),
                Shape::Instance(instance) => instance.to_mesh(),
                _ => continue,
            };
            turn_receiver(baked, receiver, turned);
            // Make the backs an object of their own, and let neither side be seen from the other.
            if is_second_side {
                let name = format!("{} (back)", old.name);
                let mut back = reversed(&mesh.in_triangles(|t| turned[t]), |_| true);
                keep_triangles(baked, receiver, turned);
                let mut front = mesh;
                for side in [&mut front, &mut back] {
                    make_one_sided(side, &mut scene, &mut one_sided);
                }
                scene.objects[object as usize].shape = Shape::Mesh(front);
                baked.objects[receiver] = scene.objects.len() as u32;
                scene.objects.push(Object::new(name, Shape::Mesh(back)));
            } else {
                // Turn the faces where they are, as no other receiver needs their fronts.
                let mesh = reversed(&mesh.in_triangles(|_| true), |t| turned[t]);
                scene.objects[object as usize].shape = Shape::Mesh(mesh);
            }
        }
        // All light is on fronts by then, and the file is written again from the scene.
        baked.atlas.turned = Vec::new();
        *self = BakeSource::of_meshes(scene)?;
        Ok(())
    }
}

/// The triangles of a receiver whose backs have the light.
fn turned_triangles(baked: &Baked, receiver: usize) -> Vec<bool> {
    let charts = &baked.atlas.layout.receivers[receiver].charts;
    let is_turned = |&chart: &u32| chart != NO_CHART && baked.atlas.is_turned(chart);
    charts.iter().map(is_turned).collect()
}

/// Reverses triangles of a receiver, with their places on the pages.
fn turn_receiver(baked: &mut Baked, receiver: usize, turned: &[bool]) {
    let layout = &mut baked.atlas.layout.receivers[receiver];
    let surface = &mut baked.atlas.receivers[receiver];
    for t in (0..turned.len()).filter(|&t| turned[t]) {
        surface.triangles[t].swap(1, 2);
        layout.uvs[t].swap(1, 2);
        if let Some(normals) = surface.normals.get_mut(t) {
            normals.swap(1, 2);
            normals.iter_mut().for_each(|n| *n = -*n);
        }
    }
}

/// Leaves a receiver only some of its triangles.
fn keep_triangles(baked: &mut Baked, receiver: usize, kept: &[bool]) {
    let layout = &mut baked.atlas.layout.receivers[receiver];
    retain(&mut layout.uvs, kept);
    retain(&mut layout.pages, kept);
    retain(&mut layout.charts, kept);
    let surface = &mut baked.atlas.receivers[receiver];
    retain(&mut surface.triangles, kept);
    retain(&mut surface.parts, kept);
    surface.omitted.clear();
    if !surface.normals.is_empty() {
        retain(&mut surface.normals, kept);
    }
}

fn retain<T>(values: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    values.retain(|_| kept.next().copied().unwrap_or(false));
}

/// Gives faces materials that are seen from their fronts alone.
fn make_one_sided(
    mesh: &mut Mesh,
    scene: &mut Scene,
    copies: &mut HashMap<MaterialId, MaterialId>,
) {
    for material in &mut mesh.face_materials {
        *material = *copies.entry(*material).or_insert_with(|| {
            let mut copy = scene.materials[*material as usize].clone();
            if copy.sidedness == Sidedness::One {
                return *material;
            }
            copy.sidedness = Sidedness::One;
            scene.add_material(copy)
        });
    }
}

/// A mesh of triangles, some of them reversed. Shading normals point to the side of the fronts, which they did not
/// all do before where a file has normals to one side and corners in the order of the other.
fn reversed(triangles: &Mesh, is_turned: impl Fn(usize) -> bool) -> Mesh {
    let mut mesh = triangles.clone();
    for face in (0..mesh.faces.len()).filter(|&f| is_turned(f)) {
        mesh.reverse_face(face);
    }
    let Some(mut normals) = mesh.normals.take() else {
        return mesh;
    };
    let count = normals.values.len() as u32;
    let corners = normals.corners.as_ref().unwrap_or(&mesh.faces.corners);
    let mut corners = corners.clone();
    for face in 0..mesh.faces.len() {
        let of_face = &mut corners[mesh.faces.corner_range(face)];
        let sum: DVec3 = of_face.iter().map(|&c| normals.values[c as usize]).sum();
        if sum.dot(mesh.face_area_vector(face)) < 0.0 {
            of_face.iter_mut().for_each(|c| *c += count);
        }
    }
    normals.corners = Some(corners);
    normals.values.extend_from_within(..);
    let backs = &mut normals.values[count as usize..];
    backs.iter_mut().for_each(|n| *n = -*n);
    mesh.normals = Some(normals);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Attribute;

    /// A square whose front looks up, with such normals.
    fn square(normal: DVec3) -> Mesh {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            normals: Some(Attribute::per_vertex(vec![normal; 4])),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 7);
        mesh
    }

    #[test]
    fn normals_look_to_the_side_that_is_turned_to_light() {
        let mesh = square(-DVec3::Z);
        let reversed = reversed(&mesh.in_triangles(|_| true), |_| true);
        let normals = reversed.normals.as_ref().unwrap();
        for (corner, &vertex) in reversed.faces.corners.iter().enumerate() {
            assert_eq!(normals.at(corner, vertex), -DVec3::Z);
        }
        assert!(reversed.face_area_vector(0).z < 0.0);
    }

    #[test]
    fn triangles_are_reversed_with_their_normals() {
        let mesh = square(DVec3::Z);
        let reversed = reversed(&mesh.in_triangles(|_| true), |t| t == 1);
        assert_eq!(reversed.faces.len(), 2);
        assert_eq!(reversed.face_materials, [7, 7]);
        assert_eq!(reversed.faces.get(0), [0, 1, 2]);
        assert_eq!(reversed.faces.get(1), [0, 3, 2]);
        let normals = reversed.normals.as_ref().unwrap();
        for (corner, &vertex) in reversed.faces.corners.iter().enumerate() {
            let side = if corner < 3 { 1.0 } else { -1.0 };
            assert_eq!(normals.at(corner, vertex), side * DVec3::Z);
        }
        assert!(reversed.face_area_vector(1).z < 0.0);
        assert_eq!(mesh.in_triangles(|t| t == 1).faces.get(0), [0, 2, 3]);
    }
}
