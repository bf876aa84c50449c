//! What a mesh adds to its material at one place: vertex colour and texture coordinates.

use super::SceneDocument;
use azulejo::scene::{MaterialId, Mesh, Rgb};
use glam::DVec2;
use std::f64::consts::PI;

/// One place of a surface: what it is made of, and what its mesh says about the colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingPoint {
    /// What it is made of.
    pub material: MaterialId,
    /// Which side is meant.
    pub is_front: bool,
    /// Vertex colour; white where there are none.
    color: Rgb,
    /// Texture coordinates, if there are any.
    uv: Option<DVec2>,
}

impl ShadingPoint {
    /// The paint at a place of a face: in the triangle of three of its vertices, with weights that
    /// add up to 1. `None` if there is no such face.
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
    /// Radiance that leaves a place evenly to all sides under an irradiance, its own included;
    /// `None` if its material is gone.
    pub fn radiance(&self, paint: &ShadingPoint, irradiance: Rgb) -> Option<Rgb> {
        let material = self.materials.get(paint.material as usize)?;
        let image = |id: u32| self.textures.get(id as usize)?.image.as_ref();
        let reflectance = material.painted(paint.color, paint.uv, image);
        Some(material.emission_from(paint.is_front) + reflectance * irradiance / PI)
    }
}
