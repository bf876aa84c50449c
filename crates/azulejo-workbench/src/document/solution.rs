//! The solved light of a document, and the document state it belongs to.

use super::{ItemId, SceneDocument, SceneObject};
use azulejo::radiosity::Report;
use azulejo::scene::{Irradiance, Material, Scene, Shape};
use glam::DAffine3;
use std::sync::Arc;

/// Irradiance on the surfaces of a document at the time the solver was started.
///
/// The solution is stored beside the model: objects keep their original faces, an edit makes the
/// solution outdated without losing it, and undoing the edit makes it current again.
#[derive(Clone, Debug)]
pub struct Solution {
    of: SceneDocument,
    /// A placed shape with irradiance for each object of the document.
    shapes: Vec<(ItemId, Arc<Shape>)>,
    /// The solver's report; `None` while it is running or if the light came with the file.
    pub report: Option<Report>,
}

impl Solution {
    /// Result of the first pass for `scene`, which was created from `document`; with a report once
    /// it is done.
    pub fn new(
        document: SceneDocument,
        mut scene: Scene,
        irradiance: Irradiance,
        report: Option<Report>,
    ) -> Solution {
        scene.set_irradiance(irradiance);
        let ids = document.objects.iter().map(|i| i.id);
        let shapes = scene.objects.into_iter().map(|o| Arc::new(o.shape));
        Solution {
            shapes: ids.zip(shapes).collect(),
            of: document,
            report,
        }
    }

    /// The placed shapes with irradiance, in the order of the objects.
    pub fn shapes(&self) -> impl ExactSizeIterator<Item = &Shape> {
        self.shapes.iter().map(|(_, shape)| &**shape)
    }

    /// The solution of a document with these [shapes](Self::shapes).
    pub fn of_shapes(
        document: SceneDocument,
        shapes: Vec<Shape>,
        report: Option<Report>,
    ) -> Solution {
        let ids = document.objects.iter().map(|i| i.id);
        Solution {
            shapes: ids.zip(shapes.into_iter().map(Arc::new)).collect(),
            of: document,
            report,
        }
    }

    /// The light stored in a file, if every surface has some.
    pub fn of_file(document: &SceneDocument) -> Option<Solution> {
        let stands = |item: &SceneObject| item.placement == DAffine3::IDENTITY;
        let is_complete = !document.objects.is_empty()
            && document
                .objects
                .iter()
                .all(|item| is_lit(item) && stands(item));
        is_complete.then(|| Solution {
            shapes: (document.objects.iter())
                .map(|i| (i.id, Arc::clone(&i.shape)))
                .collect(),
            of: document.clone(),
            report: None,
        })
    }

    /// The placed shape of an object with its irradiance, if the solver knew the object.
    pub fn shape(&self, id: ItemId) -> Option<&Arc<Shape>> {
        super::find_by_id(&self.shapes, id, |(i, _)| *i).map(|(_, shape)| shape)
    }

    /// The shape to display for an object: the lit one, as long as the object has not been moved
    /// since.
    pub fn shown(&self, item: &SceneObject) -> Option<&Arc<Shape>> {
        let then = self.of.object(item.id)?;
        let same = same_geometry(then, item);
        same.then(|| self.shape(item.id)).flatten()
    }

    /// Whether the solution is valid for `document`: the same surfaces, materials and lights.
    /// Names, cameras and visibility do not matter.
    pub fn is_of(&self, document: &SceneDocument) -> bool {
        same_light(&self.of, document)
    }
}

/// Whether all surfaces of an object came with light.
fn is_lit(item: &SceneObject) -> bool {
    match &*item.shape {
        Shape::Mesh(mesh) => mesh.faces.is_empty() || mesh.irradiance.len() == mesh.positions.len(),
        Shape::Instance(i) => i.mesh.faces.is_empty() || i.light.is_some(),
        Shape::Primitive(p) => p.light.is_some(),
        Shape::Exact(exact) => exact.proxy.is_some(),
    }
}

impl SceneDocument {
    /// Whether some surfaces came with light, which [`Solution::of_file`] accepts only if all did.
    pub fn brings_light(&self) -> bool {
        let has_faces = |item: &SceneObject| match &*item.shape {
            Shape::Mesh(mesh) => !mesh.faces.is_empty(),
            Shape::Instance(instance) => !instance.mesh.faces.is_empty(),
            Shape::Primitive(_) | Shape::Exact(_) => true,
        };
        self.objects.iter().any(|i| has_faces(i) && is_lit(i))
    }
}

/// Whether the light solved for one document is valid for a later one: whether both have the same
/// surfaces, materials and lights.
pub fn same_light(then: &SceneDocument, now: &SceneDocument) -> bool {
    let items = then.objects.len() == now.objects.len()
        && (then.objects.iter().zip(&now.objects))
            .all(|(a, b)| a.id == b.id && same_geometry(a, b));
    let lights = then.lights.len() == now.lights.len()
        && (then.lights.iter().zip(&now.lights)).all(|(a, b)| a.light.kind == b.light.kind);
    items && lights && same_materials(then, now)
}

/// Materials added later are not on any surface that was solved.
fn same_materials(then: &SceneDocument, now: &SceneDocument) -> bool {
    let pairs = then.materials.iter().zip(&now.materials);
    then.materials.len() <= now.materials.len()
        && pairs.into_iter().all(|(a, b)| same_material(a, b))
}

pub(crate) fn same_geometry(a: &SceneObject, b: &SceneObject) -> bool {
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

/// Removes the irradiance from a shape.
pub(super) fn remove_irradiance(shape: &mut Shape) {
    match shape {
        Shape::Mesh(mesh) => {
            mesh.irradiance = Vec::new();
            mesh.irradiance_error = Vec::new();
            mesh.back = None;
        }
        Shape::Instance(instance) => instance.light = None,
        Shape::Primitive(p) => p.light = None,
        Shape::Exact(exact) => exact.proxy = None,
    }
}
