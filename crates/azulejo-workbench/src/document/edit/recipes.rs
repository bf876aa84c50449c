//! Recipes applied to a document.

use super::{Edited, refuse};
use crate::document::{ItemId, SceneCamera, SceneDocument, SceneLight, SharedShape, map_materials};
use azulejo::formats::Format;
use azulejo::recipe::Recipe;
use azulejo::scene::{Material, MaterialId, Object, Scene, Shape};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Shapes with other materials, by the address of the old shape and the materials. The old shapes are
/// kept, so that no other gets the address of one.
type ReassignedShapes = HashMap<(*const Shape, Vec<MaterialId>), (Arc<Shape>, SharedShape)>;

impl SceneDocument {
    /// Applies a recipe to everything, and keeps in mind that it belongs to the model; `notes`
    /// receives what is worth saying.
    pub(super) fn apply_recipe(&mut self, recipe: &Recipe, notes: &mut Vec<String>) -> Edited {
        let mut scene = self.scene();
        let outcome = recipe.apply(&mut scene).or_else(refuse)?;
        notes.extend(outcome.limited);
        notes.extend(outcome.unmatched);
        notes.extend(self.remember_recipe(recipe.path()));
        Ok(self.adopt(scene))
    }

    /// Notes that a recipe belongs to the model, if there is one and it is imported: what is saved
    /// as GRF holds what its recipes make. Returns why not, if that is worth saying.
    fn remember_recipe(&mut self, path: &Path) -> Option<String> {
        let [model] = &mut self.source_files[..] else {
            let is_of_several = self.source_files.len() > 1;
            return is_of_several.then(|| {
                format!(
                    "{}: applied to several models, and noted for none of them",
                    path.display()
                )
            });
        };
        let is_import = model.format != Some(Format::Grf) && model.path != Path::new("-");
        if is_import && !model.recipes.iter().any(|r| r == path) {
            model.recipes.push(path.to_owned());
        }
        None
    }

    /// Forgets which recipes belong to the models; what they have made stays.
    pub(super) fn forget_recipes(&mut self) -> Edited {
        (self.source_files.iter_mut()).for_each(|model| model.recipes.clear());
        Ok(Vec::new())
    }

    /// Whether recipes will be applied when a model is imported anew.
    pub fn has_recipes(&self) -> bool {
        self.source_files.iter().any(|f| !f.recipes.is_empty())
    }

    /// Takes over what a recipe has made of the document's own scene: materials, which objects have
    /// them, and what was added. Returns the ids of new lights and cameras.
    fn adopt(&mut self, scene: Scene) -> Vec<ItemId> {
        self.adopt_materials(scene.materials);
        self.adopt_assignments(&scene.objects);
        let mut ids = Vec::new();
        for light in scene.lights.into_iter().skip(self.lights.len()) {
            let id = self.new_id();
            ids.push(id);
            self.lights.push(SceneLight {
                id,
                source_file: None,
                hidden: false,
                light,
            });
        }
        for camera in scene.cameras.into_iter().skip(self.cameras.len()) {
            let id = self.new_id();
            ids.push(id);
            self.cameras.push(SceneCamera {
                id,
                source_file: None,
                hidden: false,
                camera,
            });
        }
        (self.background, self.fog) = (scene.background, scene.fog);
        self.rtrace = scene.rtrace.map(|numbers| Arc::new(*numbers));
        ids
    }

    /// Materials that are as they were stay shared with the undo history.
    fn adopt_materials(&mut self, materials: Vec<Material>) {
        for (id, material) in materials.into_iter().enumerate() {
            match self.materials.get_mut(id) {
                Some(old) if **old == material => {}
                Some(old) => *old = Arc::new(material),
                None => self.materials.push(Arc::new(material)),
            }
        }
    }

    /// Gives the objects the materials of those of a scene, in the same order. Objects that shared a
    /// shape and get the same materials share the new one.
    fn adopt_assignments(&mut self, objects: &[Object]) {
        let mut made = ReassignedShapes::new();
        for (item, object) in self.objects.iter_mut().zip(objects) {
            let materials = materials_in_order(&object.shape);
            if materials == materials_in_order(&item.shape) {
                continue;
            }
            let old = Arc::clone(&item.shape);
            let entry = made.entry((Arc::as_ptr(&old), materials));
            let materials = entry.key().1.clone();
            let (_, new) = entry.or_insert_with(|| {
                let mut shape = Shape::clone(&old);
                let mut next = materials.into_iter();
                map_materials(&mut shape, &mut |m| next.next().unwrap_or(m));
                (old, SharedShape::new(shape))
            });
            let item = Arc::make_mut(item);
            item.shape = Arc::clone(&new.shape);
            item.facts = Arc::clone(&new.facts);
        }
    }
}

/// The materials of a shape in the order of [`map_materials`].
fn materials_in_order(shape: &Shape) -> Vec<MaterialId> {
    match shape {
        Shape::Mesh(mesh) => mesh.face_materials.clone(),
        Shape::Instance(instance) => instance.mesh.face_materials.clone(),
        Shape::Primitive(p) => vec![p.material],
        Shape::Exact(exact) => exact.leaves().iter().map(|l| l.material()).collect(),
    }
}
