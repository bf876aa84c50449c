//! Zones as enclosures: which surfaces exchange radiation with each other, and which have no place.

use super::classes::InputClass;
use super::emissivity::InputConstructions;
use super::input::{InputObject, InputText, key};
use super::surfaces::{InputSurfaces, ZoneSurface};
use crate::ReadError;
use crate::reading::warnings::Warnings;
use azulejo_scene::Zone;
use std::collections::HashMap;
use std::sync::Arc;

/// The enclosures by the keys of their zones and spaces. Zones with an air boundary between them are one, by the
/// name of the first.
#[derive(Debug, Default)]
pub(super) struct InputZones {
    by_key: HashMap<String, Arc<Zone>>,
}

impl InputZones {
    /// Collects the enclosures of all surfaces, with the internal masses in them.
    ///
    /// # Errors
    /// Areas that are not numbers.
    pub fn read(
        objects: &[InputObject<'_>],
        surfaces: &InputSurfaces<'_>,
        constructions: &InputConstructions,
        file: InputText<'_>,
        warnings: &mut Warnings,
    ) -> Result<InputZones, ReadError> {
        // Names as the file has them, in order, and which zone each is joined to.
        let (mut keys, mut names) = (HashMap::new(), Vec::new());
        let mut number = |name: &str| {
            *keys.entry(key(name)).or_insert_with(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        let mut open = Vec::new();
        for surface in surfaces.list.iter().filter(|s| !s.is_shading()) {
            let own = number(enclosure_name(surface.object));
            let outside = surface.object.text("outside_boundary_condition_object");
            if constructions.is_open(surface.object.text("construction_name")) {
                let other = surfaces.numbers.get(&key(outside));
                let other = other.map(|&other: &usize| enclosure_name(surfaces.list[other].object));
                open.push((own, number(other.unwrap_or(outside))));
            }
        }
        let mut first: Vec<usize> = (0..names.len()).collect();
        for (a, b) in open {
            let [a, b] = [first[a].min(first[b]), first[a].max(first[b])];
            first.iter_mut().filter(|f| **f == b).for_each(|f| *f = a);
        }
        let mut zones: Vec<Zone> = names.into_iter().map(zone).collect();
        for object in objects
            .iter()
            .filter(|o| o.layout.class == InputClass::Mass)
        {
            let area = object.number_or("surface_area", 0.0, file)?;
            let space = object.key("space_or_spacelist_name");
            let place = [space, object.key("zone_or_zonelist_name")];
            let place = place.iter().find_map(|place| keys.get(place));
            let message = match place {
                Some(&zone) if area > 0.0 => {
                    let masses = &mut zones[first[zone]].masses;
                    masses.push((object.name.to_string(), area));
                    "internal mass, which has no place: only files for EnergyPlus have it"
                }
                _ => "internal mass of no zone with surfaces, or without area: left out",
            };
            file.warn(warnings, object.at, message);
        }
        let zones: Vec<Arc<Zone>> = zones.into_iter().map(Arc::new).collect();
        let by_key = keys
            .into_iter()
            .map(|(key, zone)| (key, zones[first[zone]].clone()));
        Ok(InputZones {
            by_key: by_key.collect(),
        })
    }

    /// The enclosure of a surface; `None` of what only shades.
    pub fn of(&self, surface: &ZoneSurface<'_>) -> Option<Arc<Zone>> {
        self.named(enclosure_name(surface.object))
    }

    /// The enclosure of a zone or space.
    pub fn named(&self, name: &str) -> Option<Arc<Zone>> {
        self.by_key.get(&key(name)).cloned()
    }
}

fn zone(name: String) -> Zone {
    Zone {
        name,
        masses: Vec::new(),
    }
}

/// The space of a surface, or else its zone.
fn enclosure_name<'o>(object: &'o InputObject<'_>) -> &'o str {
    match object.text("space_name") {
        "" => object.text("zone_name"),
        space => space,
    }
}
