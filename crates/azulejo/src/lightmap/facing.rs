//! Faces turned to their light: fronts that receive, in files that are written anew.
//!
//! Old formats do not say which side of a face is its front, so of each chart the side that gets more light is
//! baked. Whoever reads the file takes the order of corners for the front, and so it is made to be.

use super::Baked;
use super::source::{BakeSource, SourceError};
use azulejo_bake::layout::NO_CHART;
use azulejo_scene::{Mesh, Shape};

impl BakeSource {
    /// Reverses faces of a file that was written of a scene, where the lightmap has the light of their backs, in
    /// the scene, the file and the lightmap alike. The user's own file stays as it is. An instance with such
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
        for (receiver, turned) in turned.iter().enumerate() {
            if !turned.contains(&true) {
                continue;
            }
            turn_receiver(baked, receiver, turned);
            let object = &mut scene.objects[baked.objects[receiver] as usize];
            object.shape = match &object.shape {
                Shape::Mesh(mesh) => Shape::Mesh(reversed(mesh, turned)),
                Shape::Instance(instance) => Shape::Mesh(reversed(&instance.to_mesh(), turned)),
                other => other.clone(),
            };
        }
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

/// A mesh of the triangles of another, some of them reversed with their normals.
fn reversed(mesh: &Mesh, turned: &[bool]) -> Mesh {
    let mut mesh = mesh.in_triangles();
    if let Some(normals) = &mut mesh.normals {
        let count = normals.values.len() as u32;
        let corners = normals.corners.as_ref().unwrap_or(&mesh.faces.corners);
        let side = |(corner, &value): (usize, &u32)| value + count * u32::from(turned[corner / 3]);
        normals.corners = Some(corners.iter().enumerate().map(side).collect());
        normals.values.extend_from_within(..);
        let backs = &mut normals.values[count as usize..];
        backs.iter_mut().for_each(|n| *n = -*n);
    }
    for face in (0..turned.len()).filter(|&f| turned[f]) {
        mesh.reverse_face(face);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Attribute;
    use glam::DVec3;

    #[test]
    fn triangles_are_reversed_with_their_normals() {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            normals: Some(Attribute::per_vertex(vec![DVec3::Z; 4])),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 7);
        let reversed = reversed(&mesh, &[false, true]);
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
    }
}
