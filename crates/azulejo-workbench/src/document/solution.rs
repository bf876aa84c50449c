//! The light of a document, and of which document it is.

use super::{Document, Id, Item};
use azulejo::radiosity::Report;
use azulejo::scene::{Irradiance, Material, Scene, Shape};
use glam::DAffine3;
use std::sync::Arc;

/// Irradiance on the surfaces of a document as it was when the solver began.
///
/// Light stays beside the model and not in it: objects keep the faces that they came with, an
/// edit makes the light old without losing it, and undoing the edit makes it true again.
#[derive(Clone, Debug)]
pub struct Solution {
    of: Document,
    /// One placed, lit shape for each object of the document.
    shapes: Vec<(Id, Arc<Shape>)>,
    /// How it was found; `None` where it settles yet, or came with the file.
    pub report: Option<Report>,
}

impl Solution {
    /// What the first pass found for `scene`, which was made from `document`; with its report once
    /// it is done.
    pub fn new(
        document: Document,
        mut scene: Scene,
        irradiance: Irradiance,
        report: Option<Report>,
    ) -> Solution {
        scene.set_irradiance(irradiance);
        let ids = document.items.iter().map(|i| i.id);
        let shapes = scene.objects.into_iter().map(|o| Arc::new(o.shape));
        Solution {
            shapes: ids.zip(shapes).collect(),
            of: document,
            report,
        }
    }

    /// The light that a file brought, if every surface has some.
    pub fn of_file(document: &Document) -> Option<Solution> {
        let stands = |item: &Item| item.placement == DAffine3::IDENTITY;
        let all = !document.items.is_empty()
            && document
                .items
                .iter()
                .all(|item| is_lit(item) && stands(item));
        all.then(|| Solution {
            shapes: (document.items.iter())
                .map(|i| (i.id, Arc::clone(&i.shape)))
                .collect(),
            of: document.clone(),
            report: None,
        })
    }

    /// The placed, lit shape of an object, if the solver knew it.
    pub fn shape(&self, id: Id) -> Option<&Arc<Shape>> {
        super::in_order(&self.shapes, id, |(i, _)| *i).map(|(_, shape)| shape)
    }

    /// The shape to show for an object: its lit one, as long as it stands where it was lit.
    pub fn shown(&self, item: &Item) -> Option<&Arc<Shape>> {
        let then = self.of.item(item.id)?;
        let same = same_geometry(then, item);
        same.then(|| self.shape(item.id)).flatten()
    }

    /// Whether the light of `document` is this: whether it has the same surfaces, materials and
    /// lights. Names, viewpoints and what hides do not matter.
    pub fn is_of(&self, document: &Document) -> bool {
        same_light(&self.of, document)
    }
}

/// Whether an object came with light on all of it.
fn is_lit(item: &Item) -> bool {
    match &*item.shape {
        Shape::Mesh(mesh) => mesh.faces.is_empty() || mesh.irradiance.len() == mesh.positions.len(),
        Shape::Primitive(p) => p.light.is_some(),
        Shape::Exact(exact) => exact.proxy.is_some(),
    }
}

impl Document {
    /// Whether some of its surfaces came with light, which [`Solution::of_file`] takes only where
    /// all did.
    pub fn brings_light(&self) -> bool {
        let has_faces = |item: &Item| match &*item.shape {
            Shape::Mesh(mesh) => !mesh.faces.is_empty(),
            Shape::Primitive(_) | Shape::Exact(_) => true,
        };
        self.items.iter().any(|i| has_faces(i) && is_lit(i))
    }
}

/// Whether light that was found in one document is that of a later one: whether both have the
/// same surfaces, materials and lights.
pub fn same_light(then: &Document, now: &Document) -> bool {
    let items = then.items.len() == now.items.len()
        && (then.items.iter().zip(&now.items)).all(|(a, b)| a.id == b.id && same_geometry(a, b));
    let lights = then.lights.len() == now.lights.len()
        && (then.lights.iter().zip(&now.lights)).all(|(a, b)| a.light.kind == b.light.kind);
    items && lights && same_materials(then, now)
}

/// Materials that were added later are on no surface that was lit.
fn same_materials(then: &Document, now: &Document) -> bool {
    let pairs = then.materials.iter().zip(&now.materials);
    then.materials.len() <= now.materials.len()
        && pairs.into_iter().all(|(a, b)| same_material(a, b))
}

fn same_geometry(a: &Item, b: &Item) -> bool {
    Arc::ptr_eq(&a.shape, &b.shape) && a.placement == b.placement
}

fn same_material(a: &Arc<Material>, b: &Arc<Material>) -> bool {
    if Arc::ptr_eq(a, b) {
        return true;
    }
    let unnamed = |m: &Material| Material {
        name: String::new(),
        ..m.clone()
    };
    unnamed(a) == unnamed(b)
}

/// Takes the light off a shape.
pub(super) fn strip(shape: &mut Shape) {
    match shape {
        Shape::Mesh(mesh) => {
            mesh.irradiance = Vec::new();
            mesh.irradiance_error = Vec::new();
        }
        Shape::Primitive(p) => p.light = None,
        Shape::Exact(exact) => exact.proxy = None,
    }
}
