//! What writers leave out or change, as text: "2 cameras".

use super::single::CoarseCoordinates;
use super::tessellate::exact_counts;
use azulejo_scene::{Material, PlacedMesh, Scene, Shape};

/// The losses of formats that keep little more than polygons, in the order in which they are named.
pub(crate) struct LossList<'a> {
    scene: &'a Scene,
    losses: Vec<String>,
}

impl<'a> LossList<'a> {
    /// An empty list, for formats that keep lights and cameras.
    pub fn empty(scene: &'a Scene) -> LossList<'a> {
        let losses = Vec::new();
        LossList { scene, losses }
    }

    /// A list that begins with the lights and the cameras of a scene, all of which are lost.
    pub fn new(scene: &'a Scene) -> LossList<'a> {
        let list = LossList::empty(scene);
        list.count(scene.lights.len(), "lights without area")
            .count(scene.cameras.len(), "cameras")
    }

    /// Adds a loss that occurs `count` times, which may be 0.
    pub fn count(mut self, count: usize, what: &str) -> Self {
        self.losses
            .extend((count > 0).then(|| format!("{count} {what}")));
        self
    }

    /// Adds a loss that is not counted.
    pub fn once(mut self, is_lost: bool, what: &str) -> Self {
        self.losses.extend(is_lost.then(|| what.to_owned()));
        self
    }

    /// Adds the materials that lose something.
    pub fn materials(self, lost: impl Fn(&Material) -> bool, what: &str) -> Self {
        let count = self.scene.materials.iter().filter(|m| lost(m)).count();
        self.count(count, what)
    }

    /// Adds the meshes that lose something, shared ones at each of their places.
    pub fn meshes(self, lost: impl Fn(&PlacedMesh) -> bool, what: &str) -> Self {
        let shapes = self.scene.objects.iter().map(|o| &o.shape);
        let placed = shapes.filter_map(Shape::placed_mesh);
        let count = placed.filter(|placed| lost(placed)).count();
        self.count(count, what)
    }

    /// Adds the shapes of which only polygons remain.
    pub fn exact_shapes(self) -> Self {
        let [primitives, solids] = exact_counts(self.scene);
        self.count(primitives + solids, "exact shapes that become polygons")
    }

    /// Adds the meshes with faces of more than `most` corners.
    pub fn polygons(self, most: usize) -> Self {
        self.meshes(
            |m| m.mesh.faces.iter().any(|f| f.len() > most),
            "meshes whose polygons become triangles",
        )
    }

    /// Adds the meshes with anything but positions at their corners.
    pub fn corner_attributes(self) -> Self {
        self.meshes(
            |PlacedMesh { mesh, .. }| {
                mesh.normals.is_some() || mesh.uvs.is_some() || !mesh.colors.is_empty()
            },
            "meshes whose normals, texture coordinates or colours are omitted",
        )
    }

    /// Adds the meshes with light.
    pub fn irradiance(self) -> Self {
        self.meshes(
            |m| !m.irradiance.is_empty(),
            "meshes whose irradiance is omitted",
        )
    }

    /// Adds what coordinates lose that are in single precision, in the file or in `those_who_read` it.
    pub fn single_precision(mut self, those_who_read: &str) -> Self {
        let coarse = CoarseCoordinates::to_be_written(self.scene);
        if let Some(words) = coarse.words(&self.scene.units) {
            let count = coarse.count;
            let advice = coarse.advice(self.scene);
            self.losses.push(format!(
                "details of {count} objects ({words}{those_who_read}{advice})"
            ));
        }
        self
    }

    /// The list.
    pub fn finish(self) -> Vec<String> {
        self.losses
    }
}

/// Whether a material is more than a diffuse colour.
pub(crate) fn is_more_than_colour(m: &Material) -> bool {
    m.is_emitter() || m.is_specular() || m.brdf.is_some() || !m.textures.is_empty()
}

#[cfg(test)]
mod tests {
    use super::LossList;
    use azulejo_scene::{Mesh, MeshInstance, Object, Rgb, Scene, Shape, VertexLight};
    use glam::{DAffine3, DVec3};
    use std::sync::Arc;

    /// A square of its own beside a shared one in two places, of which one is lit.
    fn squares() -> Scene {
        let mut square = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            ..Mesh::default()
        };
        square.push_face(&[0, 1, 2, 3], 0);
        let shared = Arc::new(square.clone());
        let place = |z| DAffine3::from_translation(DVec3::Z * z);
        let dark = MeshInstance::new(shared.clone(), place(1.0)).unwrap();
        let mut lit = MeshInstance::new(shared, place(2.0)).unwrap();
        lit.light = Some(Box::new(VertexLight {
            irradiance: vec![Rgb::WHITE; 4],
            ..VertexLight::default()
        }));
        let shapes = [
            Shape::Mesh(square),
            Shape::Instance(dark),
            Shape::Instance(lit),
        ];
        Scene {
            objects: shapes.map(|shape| Object::new("", shape)).into(),
            ..Scene::default()
        }
    }

    #[test]
    fn shared_meshes_count_at_each_place() {
        let losses = LossList::new(&squares()).polygons(3).irradiance().finish();
        let expected = [
            "3 meshes whose polygons become triangles",
            "1 meshes whose irradiance is omitted",
        ];
        assert_eq!(losses, expected);
    }
}
