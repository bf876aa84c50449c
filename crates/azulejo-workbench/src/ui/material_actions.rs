//! Duplicating and deleting materials.

use super::panel_context::PanelContext;
use crate::document::{Edit, SceneDocument};
use azulejo::scene::MaterialId;
use egui::Ui;

/// Adds a copy of a material with a free name; `None` if it does not exist.
pub fn duplicate(document: &SceneDocument, id: MaterialId) -> Option<Edit> {
    let material = document.materials.get(id as usize)?;
    let mut copy = (**material).clone();
    copy.name = document.fresh_material_name(&copy.name);
    Some(Edit::AddMaterial(copy))
}

/// Buttons that duplicate and delete a material.
pub fn buttons(ui: &mut Ui, cx: &mut PanelContext, id: MaterialId) {
    if ui.button(cx.tr("Duplicate")).clicked()
        && let Some(edit) = duplicate(&cx.app.document, id)
    {
        cx.edit(edit);
    }
    let about = cx.tr("Only if it is unused.");
    let delete = ui.button(cx.tr("Delete")).on_hover_text(about);
    if delete.clicked() {
        cx.edit(Edit::DeleteMaterial(id));
    }
}
