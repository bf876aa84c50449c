//! Diffuse reflectance at points that no ray has found.

use crate::surface_maps::SurfaceMaps;
use azulejo_scene::{MaterialId, Rgb, Scene};
use glam::DVec2;

/// The diffuse reflectance of the materials of a scene, as pictures show it.
pub struct DiffuseReflectance<'a> {
    scene: &'a Scene,
    maps: SurfaceMaps,
}

impl<'a> DiffuseReflectance<'a> {
    /// Prepares the pictures of the scene.
    pub fn new(scene: &'a Scene) -> DiffuseReflectance<'a> {
        DiffuseReflectance {
            scene,
            maps: SurfaceMaps::new(scene),
        }
    }

    /// At a point of this vertex colour (white without one) and these texture coordinates: with all textures,
    /// and for uniform light.
    pub fn at(&self, material: MaterialId, color: Rgb, uv: Option<DVec2>) -> Rgb {
        let material = &self.scene.materials[material as usize];
        let pattern = material.pattern(color, uv, |id| self.scene.textures.get(id as usize));
        match self.maps.finish(material, uv, pattern) {
            Some((finish, _)) => self.maps.diffuse(&finish),
            None => material.diffuse * pattern,
        }
    }

    /// Whether texture coordinates change that of a material.
    pub fn is_textured(&self, material: MaterialId) -> bool {
        let material = &self.scene.materials[material as usize];
        let of_finish = material.finish.as_ref().map(|maps| maps.pictures().count());
        !material.textures.is_empty() || of_finish.is_some_and(|count| count > 0)
    }
}
