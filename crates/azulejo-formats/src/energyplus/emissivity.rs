//! Constructions, of which the emissivities of the layers at both ends matter.

use super::classes::InputClass;
use super::input::{InputObject, InputText, key};
use crate::ReadError;
use azulejo_scene::{Material, MaterialId, Rgb, Scene};
use std::collections::{HashMap, HashSet};

/// What EnergyPlus assumes of opaque layers, and of glass.
const OPAQUE: f64 = 0.9;
const GLASS: f64 = 0.84;

/// A side of a construction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum ConstructionSide {
    /// That of the zone of its surface.
    Inner,
    /// That of the zone behind.
    Outer,
}

/// The constructions of a file.
#[derive(Debug, Default)]
pub(super) struct InputConstructions {
    /// Of the inner side and of the outer one.
    emissivities: HashMap<String, [Option<f64>; 2]>,
    open: HashSet<String>,
    materials: HashMap<(String, ConstructionSide), MaterialId>,
}

impl InputConstructions {
    /// Collects them from all objects.
    ///
    /// # Errors
    /// Malformed numbers.
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
        let mut constructions = InputConstructions::default();
        for object in objects {
            match object.layout.class {
                InputClass::Construction => {
                    let layers = [object.fields.last(), object.fields.first()].map(|layer| {
                        let (_, layer) = layer?;
                        layers.get(&key(&layer.text)).copied()
                    });
                    constructions.emissivities.insert(key(&object.name), layers);
                }
                InputClass::AirBoundary => {
                    constructions.open.insert(key(&object.name));
                }
                _ => {}
            }
        }
        Ok(constructions)
    }

    /// Whether zones see each other through surfaces of a construction.
    pub fn is_open(&self, construction: &str) -> bool {
        self.open.contains(&key(construction))
    }

    /// The material of a side of a construction: grey, it reflects what it does not absorb, and absorbs
    /// as much as it emits (Kirchhoff).
    pub fn material(
        &mut self,
        scene: &mut Scene,
        construction: &str,
        side: ConstructionSide,
        is_glass: bool,
    ) -> MaterialId {
        let key = (key(construction), side);
        if let Some(&known) = self.materials.get(&key) {
            return known;
        }
        let sides = self.emissivities.get(&key.0).copied().unwrap_or_default();
        let (known, name) = match side {
            ConstructionSide::Inner => (sides[0], construction.to_owned()),
            ConstructionSide::Outer => (sides[1], format!("{construction} (reversed)")),
        };
        let emissivity = known.unwrap_or(if is_glass { GLASS } else { OPAQUE });
        let reflectance = Rgb::grey(1.0 - emissivity);
        let id = scene.add_material(Material::diffuse(name, reflectance));
        self.materials.insert(key, id);
        id
    }
}

/// The emissivity of a layer, of glass that of its inner side.
fn emissivity(layer: &InputObject<'_>, file: InputText<'_>) -> Result<f64, ReadError> {
    let opaque = layer.number_or("thermal_absorptance", OPAQUE, file)?;
    let glass_field = "back_side_infrared_hemispherical_emissivity";
    let emissivity = match layer.layout.field(glass_field) {
        Some(field) => layer.number_or(field, GLASS, file)?,
        None => opaque,
    };
    Ok(emissivity.clamp(0.0, 1.0))
}
