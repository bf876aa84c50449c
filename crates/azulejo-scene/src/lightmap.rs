//! Lightmaps: irradiance in pictures, as other programs bake it into models.
//!
//! A material names the picture and its scale, as it names the pictures of its colour; a mesh has texture
//! coordinates of their own for it. The second pass reads it where a mesh has no irradiance on its vertices; the
//! first pass knows nothing of it.

use crate::{
    Image, IrradiancePicture, Material, MaterialId, Mesh, Object, Scene, Shape, TextureId,
};
use glam::DVec2;
use std::collections::HashSet;

impl Mesh {
    /// Coordinates of the lightmap at a corner, counted over all corners, if the mesh has them.
    pub fn lightmap_uv(&self, corner: usize) -> Option<DVec2> {
        let uvs = self.lightmap_uvs.as_ref()?;
        Some(uvs.at(corner, self.faces.corners[corner]))
    }
}

impl Scene {
    /// The lightmap of a material, and its pixels; `None` without, or if they could not be loaded.
    pub fn lightmap(&self, material: MaterialId) -> Option<(IrradiancePicture, &Image)> {
        let lightmap = self.materials.get(material as usize)?.lightmap?;
        let image = self.textures.get(lightmap.texture as usize)?.image.as_ref();
        Some((lightmap, image?))
    }

    /// Whether any surface shows the light of a lightmap.
    pub fn has_lightmap(&self) -> bool {
        self.objects.iter().any(|o| self.is_lightmapped(&o.shape))
    }

    /// Whether a shape has a face with a lightmap, and no irradiance on its vertices that comes before it.
    pub fn is_lightmapped(&self, shape: &Shape) -> bool {
        shape.placed_mesh().is_some_and(|placed| {
            let mut materials = placed.mesh.face_materials.iter();
            placed.mesh.lightmap_uvs.is_some()
                && placed.irradiance.is_empty()
                && materials.any(|&m| self.lightmap(m).is_some())
        })
    }

    /// Forgets all lightmaps, with the pictures that nothing else shows; whether a surface had one.
    pub fn drop_lightmaps(&mut self) -> bool {
        let had_any = self.has_lightmap();
        let lightmaps = self.materials.iter_mut();
        let dropped: HashSet<TextureId> = lightmaps
            .filter_map(|m| Some(m.lightmap.take()?.texture))
            .collect();
        self.drop_unused(dropped);
        for object in &mut self.objects {
            if let Shape::Mesh(mesh) = &mut object.shape {
                mesh.lightmap_uvs = None;
            }
        }
        let has_coordinates = |o: &Object| o.shape.mesh().is_some_and(|m| m.lightmap_uvs.is_some());
        if self.objects.iter().any(has_coordinates) {
            self.change_shared_meshes(|mesh| mesh.lightmap_uvs = None);
        }
        had_any
    }

    /// Removes those of some pictures that nothing shows.
    fn drop_unused(&mut self, mut unused: HashSet<TextureId>) {
        let shown = self.materials.iter().flat_map(Material::pictures);
        for id in shown.chain(self.surrounding_pictures()) {
            unused.remove(&id);
        }
        if unused.is_empty() {
            return;
        }
        let mut next = 0;
        let numbers: Vec<TextureId> = (0..self.textures.len() as TextureId)
            .map(|id| {
                next += TextureId::from(!unused.contains(&id));
                next.saturating_sub(1)
            })
            .collect();
        let number = |id: TextureId| numbers.get(id as usize).copied().unwrap_or(id);
        let mut id = 0;
        self.textures.retain(|_| {
            id += 1;
            !unused.contains(&(id - 1))
        });
        (self.materials.iter_mut()).for_each(|m| m.number_pictures(number));
        let lights = std::mem::take(&mut self.lights).into_iter();
        self.lights = lights.map(|l| l.with_texture(number)).collect();
        self.background = self.background.map(|b| b.with_texture(number));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::cube_room;
    use crate::{Attribute, SharedMesh, Texture};
    use glam::{DAffine3, DVec3};

    fn lit_room() -> Scene {
        let mut scene = cube_room();
        scene.textures.push(Texture {
            image: Some(Image::opaque(2, 1, vec![[0.0; 3], [1.0, 0.5, 0.0]])),
            ..Texture::default()
        });
        let lightmap = IrradiancePicture {
            texture: 0,
            scale: 4.0,
        };
        for material in &mut scene.materials {
            material.lightmap = Some(lightmap);
        }
        if let Shape::Mesh(mesh) = &mut scene.objects[0].shape {
            let uvs = vec![DVec2::splat(0.5); mesh.positions.len()];
            mesh.lightmap_uvs = Some(Attribute::per_vertex(uvs));
        }
        scene
    }

    #[test]
    fn texels_are_interpolated_and_clamped() {
        let scene = lit_room();
        let (lightmap, image) = scene.lightmap(0).unwrap();
        let at = |u: f64| lightmap.at(image, DVec2::new(u, 0.5)).to_array();
        assert_eq!(at(0.5), [2.0, 1.0, 0.0]);
        assert_eq!([at(0.75), at(1.0), at(9.0)], [[4.0, 2.0, 0.0]; 3]);
        assert_eq!([at(0.0), at(-3.0)], [[0.0; 3]; 2]);
    }

    #[test]
    fn a_lightmap_is_seen_and_forgotten() {
        let mut scene = lit_room();
        scene.validate().unwrap();
        assert!(scene.has_lightmap() && scene.is_solved());
        // Shared meshes have it, too.
        let Shape::Mesh(mesh) = scene.objects[0].shape.clone() else {
            unreachable!("a room of polygons")
        };
        let mut shared = SharedMesh::new(mesh);
        for object in 0..2 {
            let map = DAffine3::from_translation(DVec3::splat(f64::from(object)));
            let instance = Shape::Instance(shared.placed(map).unwrap());
            scene.objects.push(Object::new("", instance));
        }
        scene.validate().unwrap();
        assert!(scene.objects.iter().all(|o| scene.is_lightmapped(&o.shape)));
        assert!(scene.drop_lightmaps());
        assert!(!scene.has_lightmap() && !scene.is_solved());
        assert!(scene.textures.is_empty());
        let mut meshes = scene.objects.iter().filter_map(|o| o.shape.mesh());
        assert!(meshes.all(|m| m.lightmap_uvs.is_none()));
        assert!(!scene.drop_lightmaps());
    }

    /// Of the pictures of a scene only those of lightmaps go, and the others are numbered anew.
    #[test]
    fn other_pictures_stay() {
        let mut scene = lit_room();
        let named = |path: &str| Texture {
            path: path.to_owned(),
            ..Texture::default()
        };
        scene.textures.extend([named("wood"), named("sky")]);
        scene.materials[0].textures = vec![1];
        scene.materials[0].emission_picture = Some(2);
        assert!(scene.drop_lightmaps());
        let names: Vec<&str> = scene.textures.iter().map(|t| t.path.as_str()).collect();
        assert_eq!(names, ["wood", "sky"]);
        assert_eq!(scene.materials[0].textures, [0]);
        assert_eq!(scene.materials[0].emission_picture, Some(1));
        scene.validate().unwrap();
    }

    /// Pictures that are missing, and meshes without coordinates, show nothing.
    #[test]
    fn what_is_incomplete_is_no_lightmap() {
        let mut scene = lit_room();
        scene.textures[0].image = None;
        assert!(!scene.has_lightmap());
        let mut scene = lit_room();
        if let Shape::Mesh(mesh) = &mut scene.objects[0].shape {
            mesh.lightmap_uvs = None;
        }
        assert!(!scene.has_lightmap());
    }
}
