//! Photometric files as lights: `ies`.

use super::reader::{EntityError, MgfReader, MgfSource, skip};
use super::transform::MgfTransform;
use crate::photometry::{PhotometricFile, ies};
use crate::reading::files::beside;
use crate::reading::text::quoted;
use azulejo_scene::Rgb;
use glam::DVec3;
use std::rc::Rc;

/// What a point of a luminaire counts as, in the elements of limits: 2 × 100 bytes and its name.
const LIGHT: u64 = 4;

impl MgfReader<'_> {
    /// Adds a luminaire for each instance of a transform.
    pub(super) fn place_luminaires(
        &mut self,
        source: &mut MgfSource,
        name: &str,
        multiplier: f64,
        transform: &MgfTransform,
    ) -> Result<(), EntityError> {
        let luminaire = self.luminaire_of(name)?;
        if let Some(body) = &luminaire.body {
            let body = beside(name, body);
            match self.text_of(&body) {
                Ok(bytes) => {
                    let outside = self.emission;
                    self.emission *= luminaire.factor * multiplier;
                    self.open.push(name.to_owned());
                    let read = self.instances_of(&body, &bytes, transform);
                    self.open.pop();
                    self.emission = outside;
                    return read;
                }
                Err(EntityError::Skipped(message)) => self.warn(source, message),
                Err(stop) => return Err(stop),
            }
        }
        let group = name.rsplit('/').next().unwrap_or(name);
        self.for_instances(group, transform, |reader| {
            reader.shine(&luminaire, multiplier)
        })
    }

    fn luminaire_of(&mut self, name: &str) -> Result<Rc<PhotometricFile>, EntityError> {
        let shown = quoted(name.as_bytes());
        if self.open.iter().any(|open| open == name) {
            return skip(format!(
                "the geometry of {shown} includes it again: skipped"
            ));
        }
        if let Some(known) = self.luminaires.get(name) {
            let known = known.clone();
            return known.map_or_else(|| skip(format!("{shown} skipped, as before")), Ok);
        }
        let bytes = self.text_of(name)?;
        let parsed = ies::parse(&bytes).map(Rc::new);
        self.luminaires.insert(name.to_owned(), parsed.clone().ok());
        parsed.or_else(|wrong| {
            skip(format!(
                "{shown} is not a valid photometric file: found {}, expected {}",
                wrong.found, wrong.expected
            ))
        })
    }

    /// Adds the lights of a luminaire at the current place.
    fn shine(&mut self, luminaire: &PhotometricFile, multiplier: f64) -> Result<(), EntityError> {
        // Intensities scale with the square of lengths, like the flux of surfaces.
        let scale = Rgb::grey(multiplier * self.placement.scale * self.placement.scale);
        for kind in luminaire.lights(&self.placement.map, scale) {
            self.budget.spend(LIGHT)?;
            let is_finite =
                kind.position().is_none_or(DVec3::is_finite) && kind.strength().is_finite();
            if !is_finite {
                return skip("luminaire whose size overflows: skipped");
            }
            self.builder.light(kind);
        }
        Ok(())
    }
}
