//! Adding and deleting materials. Surfaces refer to materials by index, so later indices shift.

use super::duplicate::UniqueNames;
use super::{EditError, Edited};
use crate::document::{SceneDocument, SceneObject, ShapeFacts, map_materials};
use azulejo::scene::{MaterialId, Shape};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Number of object names listed in a message.
const NAMED: usize = 3;

/// A shape with remapped material indices.
struct RenumberedShape {
    /// Kept alive while it is looked up by address, which could be reused otherwise.
    _old: Arc<Shape>,
    shape: Arc<Shape>,
    facts: Arc<ShapeFacts>,
}

impl RenumberedShape {
    fn new(old: &Arc<Shape>, numbers: &[MaterialId]) -> RenumberedShape {
        let mut shape = Shape::clone(old);
        map_materials(&mut shape, &mut |m| numbers[m as usize]);
        RenumberedShape {
            _old: Arc::clone(old),
            facts: Arc::new(ShapeFacts::of(&shape)),
            shape: Arc::new(shape),
        }
    }
}

impl SceneDocument {
    /// `name` with the first number that makes it unique among materials.
    pub fn fresh_material_name(&self, name: &str) -> String {
        UniqueNames::among(self.materials.iter().map(|m| &m.name)).fresh(name)
    }

    /// Materials used by at least one surface.
    pub fn used_materials(&self) -> HashSet<MaterialId> {
        let items = self.objects.iter();
        items.flat_map(|i| i.materials().iter().copied()).collect()
    }

    pub(super) fn delete_material(&mut self, id: MaterialId) -> Edited {
        let Some(material) = self.materials.get(id as usize) else {
            return Err(EditError("the material no longer exists".into()));
        };
        let items = self.objects.iter().map(|item| &**item);
        let users: Vec<&SceneObject> = items.filter(|i| i.materials().contains(&id)).collect();
        if !users.is_empty() {
            let why = format!("{} is used by {}", quoted(&material.name), listed(&users));
            return Err(EditError(why));
        }
        self.keep_materials(|m| m != id);
        Ok(Vec::new())
    }

    pub(super) fn delete_unused_materials(&mut self) -> Edited {
        let used = self.used_materials();
        if used.len() == self.materials.len() {
            return Err(EditError("every material is used".into()));
        }
        self.keep_materials(|m| used.contains(&m));
        Ok(Vec::new())
    }

    /// Deletes the materials for which `keep` returns false; they must be unused.
    fn keep_materials(&mut self, keep: impl Fn(MaterialId) -> bool) {
        let mut numbers: Vec<MaterialId> = Vec::new();
        let mut kept = Vec::new();
        for (k, material) in self.materials.drain(..).enumerate() {
            numbers.push(kept.len() as MaterialId);
            if keep(k as MaterialId) {
                kept.push(material);
            }
        }
        self.materials = kept;
        self.renumber(&numbers);
        self.rtrace = None;
    }

    /// Remaps the material indices of all surfaces. Objects that share a shape continue to share
    /// it.
    fn renumber(&mut self, numbers: &[MaterialId]) {
        let mut done: HashMap<*const Shape, RenumberedShape> = HashMap::new();
        let moved = |m: &MaterialId| numbers[*m as usize] != *m;
        for item in &mut self.objects {
            if !item.materials().iter().any(moved) {
                continue;
            }
            let new = done
                .entry(Arc::as_ptr(&item.shape))
                .or_insert_with(|| RenumberedShape::new(&item.shape, numbers));
            let item = Arc::make_mut(item);
            (item.shape, item.facts) = (Arc::clone(&new.shape), Arc::clone(&new.facts));
        }
    }
}

fn quoted(name: &str) -> String {
    match name {
        "" => "the material without name".to_owned(),
        name => format!("the material \"{name}\""),
    }
}

/// The first few names, and the number of the others.
fn listed(users: &[&SceneObject]) -> String {
    let names = users.iter().take(NAMED).map(|i| format!("\"{}\"", i.name));
    let names = names.collect::<Vec<_>>().join(", ");
    match users.len().saturating_sub(NAMED) {
        0 => names,
        more => format!("{names} and {more} more"),
    }
}
