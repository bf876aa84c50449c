//! Constructions, of which the emissivity of the innermost layer matters.

use super::classes::InputClass;
use super::input::{InputObject, InputText, key};
use crate::ReadError;
use azulejo_scene::{Material, MaterialId, Rgb, Scene};
use std::collections::{HashMap, HashSet};

/// What EnergyPlus assumes of opaque layers, and of glass.
const OPAQUE: f64 = 0.9;
const GLASS: f64 = 0.84;

/// The constructions of a file.
#[derive(Debug, Default)]
pub(super) struct InputConstructions {
    emissivities: HashMap<String, f64>,
    open: HashSet<String>,
    materials: HashMap<String, MaterialId>,
}

impl InputConstructions {
    /// Collects them from all objects.
    ///
    /// # Errors
    /// Numbers that are none.
    pub fn read(
        objects: &[InputObject<'_>],
        file: InputText<'_>,
    ) -> Result<InputConstructions, ReadError> {
        let mut layers = HashMap::new();
        for object in objects {
            if object.layout.class == InputClass::Material {
                layers.insert(key(&object.name), emissivity(object, file)?);
            }
        }
        let mut found = InputConstructions::default();
        for object in objects {
            match object.layout.class {
                InputClass::Construction => {
                    let inner = object.fields.last().map(|(_, layer)| key(&layer.text));
                    if let Some(known) = inner.and_then(|inner| layers.get(&inner)) {
                        found.emissivities.insert(key(&object.name), *known);
                    }
                }
                InputClass::AirBoundary => {
                    found.open.insert(key(&object.name));
                }
                _ => {}
            }
        }
        Ok(found)
    }

    /// Whether zones see each other through surfaces of a construction.
    pub fn is_open(&self, construction: &str) -> bool {
        self.open.contains(&key(construction))
    }

    /// The material of a construction: grey, it reflects what it does not absorb, and absorbs as much
    /// as it emits (Kirchhoff).
    pub fn material(&mut self, scene: &mut Scene, construction: &str, is_glass: bool) -> MaterialId {
        let key = key(construction);
        if let Some(&known) = self.materials.get(&key) {
            return known;
        }
        let default = if is_glass { GLASS } else { OPAQUE };
        let emissivity = self.emissivities.get(&key).copied().unwrap_or(default);
        let reflectance = Rgb::grey(1.0 - emissivity);
        let id = scene.add_material(Material::diffuse(construction, reflectance));
        self.materials.insert(key, id);
        id
    }
}

/// The emissivity of a layer's inner side.
fn emissivity(layer: &InputObject<'_>, file: InputText<'_>) -> Result<f64, ReadError> {
    let opaque = layer.number_or("thermal_absorptance", OPAQUE, file)?;
    let of_glass = "back_side_infrared_hemispherical_emissivity";
    let found = match layer.layout.field(of_glass) {
        Some(field) => layer.number_or(field, GLASS, file)?,
        None => opaque,
    };
    Ok(found.clamp(0.0, 1.0))
}
