//! Material, vertex colour and texture coordinates at a surface point.

use super::SceneDocument;
use azulejo::scene::{MaterialId, Mesh, Rgb};
use glam::DVec2;
use std::f64::consts::PI;

/// A surface point with the data that determine its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingPoint {
    /// Index of its material in the document.
    pub material: MaterialId,
    /// Which side of the surface is meant.
    pub is_front: bool,
    /// Vertex colour; white if the mesh has none.
    color: Rgb,
    /// Texture coordinates, if the mesh has any.
    uv: Option<DVec2>,
}

impl ShadingPoint {
    /// The shading data at a point of a face, given by three of its vertices and barycentric
    /// coordinates. `None` if the face does not exist.
    pub fn at(
        mesh: &Mesh,
        face: usize,
        vertices: [u32; 3],
        weights: [f64; 3],
        is_front: bool,
    ) -> Option<ShadingPoint> {
        let material = *mesh.face_materials.get(face)?;
        let mut color = Rgb::WHITE;
        if mesh.colors.len() == mesh.positions.len() {
            let colors = vertices.map(|v| mesh.colors[v as usize]);
            color = (colors.iter().zip(weights)).fold(Rgb::BLACK, |sum, (&c, w)| sum + c * w);
        }
        let uv = mesh.uvs.as_ref().map(|uvs| {
            let corners = mesh.faces.corner_range(face);
            let uv = |vertex: u32| {
                let corner = corners.clone().find(|&c| mesh.faces.corners[c] == vertex);
                corner.map_or(DVec2::ZERO, |c| uvs.at(c, vertex))
            };
            vertices.iter().zip(weights).map(|(&v, w)| w * uv(v)).sum()
        });
        Some(ShadingPoint {
            material,
            is_front,
            color,
            uv,
        })
    }
}

impl SceneDocument {
    /// Diffuse radiance leaving a point under an irradiance, emission included; `None` if its
    /// material no longer exists.
    pub fn radiance(&self, paint: &ShadingPoint, irradiance: Rgb) -> Option<Rgb> {
        let material = self.materials.get(paint.material as usize)?;
        let texture = |id: u32| self.textures.get(id as usize).map(|texture| &**texture);
        let reflectance = material.painted(paint.color, paint.uv, texture);
        let picture = material.emission_picture.and_then(texture);
        let shown = match (material.emission_picture, picture) {
            (None, _) => Rgb::WHITE,
            (_, Some(picture)) => match paint.uv.and_then(|uv| picture.sample(uv)) {
                Some(color) => Rgb::from(color.map(f64::from)),
                None => picture.mean(),
            },
            (Some(_), None) => Rgb::BLACK,
        };
        let emitted = material.emission_from(paint.is_front) * shown;
        Some(emitted + reflectance * irradiance / PI)
    }
}
