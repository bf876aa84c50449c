//! Applies transforms to faces, cameras and lights.

use super::document::{SourcePosition, TransformStep};
use azulejo_scene::{Camera, Faces, Light, Mesh};
use glam::{DAffine3, DMat3, DVec3};

/// The product of the enclosing transforms; `None` if there is none, so that numbers stay as
/// written.
pub(super) type OuterTransform = Option<DAffine3>;

/// Where a block stands: in its file, and inside which transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockPlace {
    pub source: SourcePosition,
    pub outer: OuterTransform,
}

/// Whether a transform reverses orientation.
pub(super) fn is_mirror(outer: OuterTransform) -> bool {
    outer.is_some_and(|map| map.matrix3.determinant() < 0.0)
}

/// Reverses each face, keeping its first corner: the outside of a body is the outside of its mirror
/// image.
pub(super) fn reverse_faces(faces: &mut Faces) {
    for face in 0..faces.len() {
        let corners = faces.corner_range(face);
        faces.corners[corners][1..].reverse();
    }
}

/// The sum of the area vectors of the faces around each vertex.
pub(super) fn face_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for face in mesh.faces.iter() {
        let area = area_vector(&mesh.positions, face);
        for &v in face {
            sums[v as usize] += area;
        }
    }
    sums
}

/// Newell's sum from the first corner, as in [`azulejo_scene::math::area_vector`], without a list
/// of positions.
fn area_vector(positions: &[DVec3], face: &[u32]) -> DVec3 {
    let first = positions[face[0] as usize];
    let edge = |v: u32| positions[v as usize] - first;
    face[1..]
        .windows(2)
        .map(|w| edge(w[0]).cross(edge(w[1])))
        .sum()
}

pub(super) fn degenerate_faces(mesh: &Mesh) -> usize {
    let faces: &Faces = &mesh.faces;
    faces
        .iter()
        .filter(|face| area_vector(&mesh.positions, face) == DVec3::ZERO)
        .count()
}

/// The product of elementary transformations; the first one is applied first.
pub(super) fn affine(steps: &[TransformStep]) -> DAffine3 {
    steps.iter().fold(DAffine3::IDENTITY, |done, step| {
        let next = match *step {
            TransformStep::Scale(s) => DAffine3::from_scale(s),
            TransformStep::Translation(t) => DAffine3::from_translation(t),
            TransformStep::Rotation(degrees) => DAffine3::from_mat3(
                DMat3::from_rotation_z(degrees.z.to_radians())
                    * DMat3::from_rotation_y(degrees.y.to_radians())
                    * DMat3::from_rotation_x(degrees.x.to_radians()),
            ),
        };
        next * done
    })
}

pub(super) fn moved_camera(camera: &Camera, outer: OuterTransform) -> Camera {
    let mut camera = camera.clone();
    if let Some(map) = outer {
        camera.eye = map.transform_point3(camera.eye);
        camera.target = map.transform_point3(camera.target);
        camera.up = map.matrix3 * camera.up;
    }
    camera
}

/// A transformed light; `None` if it loses its direction. Its intensity does not change.
pub(super) fn moved_light(light: &Light, outer: OuterTransform) -> Option<Light> {
    let mut light = light.clone();
    let is_anywhere = outer.is_none_or(|map| light.move_by(&map));
    is_anywhere.then_some(light)
}
