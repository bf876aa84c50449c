//! Keeps track of the material being edited while materials are added and removed.

use super::App;
use azulejo::scene::{Material, MaterialId};
use std::sync::Arc;

impl App {
    /// The material being edited.
    pub(super) fn chosen_material(&self) -> Option<Arc<Material>> {
        let id = self.selection.material?;
        self.document.materials.get(id as usize).cloned()
    }

    /// Selects the material that was edited before, whatever its index is now; returns whether it
    /// still exists.
    pub(super) fn follow_material(&mut self, before: Option<Arc<Material>>) -> bool {
        let (Some(before), Some(at)) = (before, self.selection.material) else {
            return false;
        };
        let materials = &self.document.materials;
        let is_it = |m: &Arc<Material>| Arc::ptr_eq(m, &before);
        if materials.get(at as usize).is_some_and(is_it) {
            return true;
        }
        let position = materials.iter().position(is_it);
        if let Some(position) = position {
            self.selection.material = Some(position as MaterialId);
        }
        position.is_some()
    }
}
