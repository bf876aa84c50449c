//! Materials: the colours of the file, and a grey one for each type of surface.

use crate::reading::json::Json;
use azulejo_scene::{Material, MaterialId, Rgb, Scene};
use std::collections::HashMap;

/// Reflectance of surfaces without a colour.
const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// A material of the file, of which the diffuse colour is used.
pub(super) struct CityColor {
    name: String,
    /// Red, green and blue, 0..=1.
    color: Option<[f64; 3]>,
}

impl CityColor {
    /// Reads a material.
    pub fn read(material: Json<'_>) -> CityColor {
        let name = material.member("name").and_then(Json::string);
        let color = material.member("diffuseColor").and_then(Json::triple);
        CityColor {
            name: name.unwrap_or_default().into_owned(),
            color: color.map(|color| color.map(|x| x.clamp(0.0, 1.0))),
        }
    }
}

/// The materials that the scene already has.
#[derive(Default)]
pub(super) struct CityMaterials {
    by_type: HashMap<String, MaterialId>,
    /// By the bytes of their names and colours.
    by_color: HashMap<(String, [u64; 3]), MaterialId>,
}

impl CityMaterials {
    /// The grey material of a type of surface, named after it.
    pub fn grey(&mut self, scene: &mut Scene, kind: &str) -> MaterialId {
        if let Some(&known) = self.by_type.get(kind) {
            return known;
        }
        let id = scene.add_material(Material::diffuse(kind, DEFAULT_REFLECTANCE));
        self.by_type.insert(kind.to_owned(), id);
        id
    }

    /// The material of the file, if it has a colour.
    pub fn colored(&mut self, scene: &mut Scene, material: &CityColor) -> Option<MaterialId> {
        let color = material.color?;
        let key = (material.name.clone(), color.map(f64::to_bits));
        let new = || {
            let name = material.name.clone();
            scene.add_material(Material::diffuse(name, Rgb::from(color)))
        };
        Some(*self.by_color.entry(key).or_insert_with(new))
    }
}
