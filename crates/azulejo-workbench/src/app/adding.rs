//! New shapes and lights, placed to suit the existing model.

use super::{App, Severity};
use crate::command::PrismBase;
use crate::document::{
    Edit, NewLight, NewLightKind, NewShape, NewShapeKind, PrismOutline, TextLayout,
};
use azulejo::surroundings::Room;
use azulejo::trace::Tracer;
use glam::DVec3;
use std::path::PathBuf;

impl App {
    /// Adds a shape on the ground, or an area light under the ceiling or above the model.
    pub(super) fn add_shape(&mut self, kind: NewShapeKind) {
        let (at, size) = match kind {
            NewShapeKind::AreaLight => self.lamp_place(),
            _ => (self.ground(), self.default_size()),
        };
        self.add_new_shape(kind, at, size);
    }

    fn add_new_shape(&mut self, kind: NewShapeKind, at: DVec3, size: f64) {
        let new = NewShape {
            kind,
            at,
            size,
            material: None,
        };
        self.edit(&Edit::AddShape(new), None);
    }

    pub(super) fn add_light(&mut self, kind: NewLightKind) {
        let new = NewLight {
            kind,
            at: self.lamp_place().0,
            toward: self.ground(),
        };
        self.edit(&Edit::AddLight(new), None);
    }

    pub(super) fn add_text(&mut self, text: &str, size: f64, depth: f64, font: Option<PathBuf>) {
        let bytes = font.as_deref().map(azulejo::models::read_bytes).transpose();
        let lettering = bytes.map_err(|e| e.to_string()).and_then(|bytes| {
            let name = font.as_deref().map(|p| p.to_string_lossy().into_owned());
            let named = bytes.as_deref().zip(name.as_deref());
            TextLayout::set(text, depth, named).map_err(|e| e.to_string())
        });
        match lettering {
            Ok(lettering) => self.add_new_shape(NewShapeKind::Text(lettering), self.ground(), size),
            Err(why) => self.report(Severity::Error, why),
        }
    }

    pub(super) fn add_prism(&mut self, base: &PrismBase, size: f64, height: f64) {
        match self.outline(base, height / size) {
            Ok(outline) => self.add_new_shape(NewShapeKind::Prism(outline), self.ground(), size),
            Err(why) => self.report(Severity::Error, why),
        }
    }

    /// The outline to extrude; `height` is relative to its larger side.
    fn outline(&mut self, base: &PrismBase, height: f64) -> Result<PrismOutline, String> {
        let path = match base {
            PrismBase::Regular(sides) => {
                return PrismOutline::regular(*sides, height).map_err(|e| e.to_string());
            }
            PrismBase::Drawing(path) => path,
        };
        let bytes = azulejo::models::read_bytes(path).map_err(|e| e.to_string())?;
        let drawing = PrismOutline::drawing(&bytes, &path.to_string_lossy(), height);
        let (outline, warnings) = drawing.map_err(|e| e.to_string())?;
        for warning in warnings {
            self.report(Severity::Warning, warning.to_string());
        }
        Ok(outline)
    }

    /// The middle of the model's ground, where new objects are placed.
    pub fn ground(&self) -> DVec3 {
        let bounds = self.document.model_bounds();
        let up = self.document.units.up.axis();
        bounds.centre() - up * (0.5 * bounds.size().dot(up))
    }

    /// A default size for new objects, in world units.
    pub fn default_size(&self) -> f64 {
        let bounds = self.document.model_bounds();
        if bounds.is_empty() || bounds.diagonal() <= 0.0 {
            1.0
        } else {
            0.25 * bounds.diagonal()
        }
    }

    /// Centre and edge of a new lamp: under the ceiling of a room, well above anything else.
    fn lamp_place(&self) -> (DVec3, f64) {
        let size = self.default_size();
        let bounds = self.document.model_bounds();
        let up = self.document.units.up.axis();
        if bounds.is_empty() {
            return (size * up, size);
        }
        let scene = self.document.scene();
        if let Some(room) = Room::find(&scene, &Tracer::new(&scene)) {
            return room.lamp;
        }
        let half = 0.5 * bounds.size().dot(up);
        (bounds.centre() + (half + size) * up, size)
    }
}
