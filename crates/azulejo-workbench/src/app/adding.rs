//! New shapes and lights, placed to suit the existing model.

use super::{App, Severity};
use crate::command::PrismBase;
use crate::document::{
    Edit, NewLight, NewLightKind, NewShape, NewShapeKind, PrismOutline, TextLayout,
};
use crate::gpu::{DrawnMesh, display_mesh, pick};
use azulejo::scene::math::Ray;
use azulejo::scene::{Mesh, Shape};
use glam::DVec3;
use std::borrow::Cow;
use std::path::PathBuf;

impl App {
    /// Adds a shape on the ground, or an area light under the ceiling or above the model.
    pub(super) fn add_shape(&mut self, kind: NewShapeKind) {
        let size = self.default_size();
        let at = match kind {
            NewShapeKind::AreaLight => self.lamp_position(size),
            _ => self.ground(),
        };
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
            at: self.lamp_position(self.default_size()),
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
            Ok(lettering) => {
                let new = NewShape {
                    kind: NewShapeKind::Text(lettering),
                    at: self.ground(),
                    size,
                    material: None,
                };
                self.edit(&Edit::AddShape(new), None);
            }
            Err(why) => self.report(Severity::Error, why),
        }
    }

    pub(super) fn add_prism(&mut self, base: &PrismBase, size: f64, height: f64) {
        match self.outline(base, height / size) {
            Ok(outline) => {
                let new = NewShape {
                    kind: NewShapeKind::Prism(outline),
                    at: self.ground(),
                    size,
                    material: None,
                };
                self.edit(&Edit::AddShape(new), None);
            }
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
        let bounds = self.document.bounds(None);
        let up = self.document.units.up.axis();
        bounds.centre() - up * (0.5 * bounds.size().dot(up))
    }

    /// A default size for new objects, in world units.
    pub fn default_size(&self) -> f64 {
        let bounds = self.document.bounds(None);
        if bounds.is_empty() || bounds.diagonal() <= 0.0 {
            1.0
        } else {
            0.25 * bounds.diagonal()
        }
    }

    /// Position of a new light: a little below the ceiling of a room, well above anything else.
    fn lamp_position(&self, size: f64) -> DVec3 {
        let bounds = self.document.bounds(None);
        let up = self.document.units.up.axis();
        if bounds.is_empty() {
            return size * up;
        }
        let half = 0.5 * bounds.size().dot(up);
        let height = if self.is_room() {
            0.96 * half
        } else {
            half + size
        };
        bounds.centre() + height * up
    }

    /// Whether the model is a room: from its centre, rays hit a floor and a ceiling at the ends of
    /// the model, and walls on most sides.
    pub(super) fn is_room(&self) -> bool {
        let bounds = self.document.bounds(None);
        let meshes: Vec<(Cow<Mesh>, glam::DAffine3)> = (self.document.objects.iter())
            .map(|item| {
                let error = 0.02 * bounds.diagonal().max(f64::MIN_POSITIVE);
                let mesh = match &*item.shape {
                    Shape::Mesh(mesh) => Cow::Borrowed(mesh),
                    other => display_mesh(other, error, false),
                };
                (mesh, item.placement)
            })
            .collect();
        let drawn: Vec<DrawnMesh> = (meshes.iter())
            .map(|(mesh, placement)| DrawnMesh {
                world_from_object: *placement,
                ..DrawnMesh::new(0, mesh)
            })
            .collect();
        let up = self.document.units.up.axis();
        let (side, front) = up.any_orthonormal_pair();
        let ends_there = |direction: DVec3| {
            let ray = Ray::new(bounds.centre(), direction);
            let reach = 0.5 * bounds.size().dot(direction.abs());
            pick(&drawn, &ray, false).is_some_and(|hit| hit.distance > 0.9 * reach)
        };
        let walls = [side, -side, front, -front];
        ends_there(up)
            && ends_there(-up)
            && walls.into_iter().filter(|&w| ends_there(w)).count() >= 3
    }
}
