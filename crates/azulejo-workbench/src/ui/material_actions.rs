//! Materials as wholes: copied, and taken away.

use super::panel_context::PanelContext;
use crate::document::{Edit, SceneDocument};
use azulejo::scene::MaterialId;
use egui::Ui;

/// Adds the same material again, by a name that is free; `None` if it is gone.
pub fn duplicate(document: &SceneDocument, id: MaterialId) -> Option<Edit> {
    let material = document.materials.get(id as usize)?;
    let mut copy = (**material).clone();
    copy.name = document.fresh_material_name(&copy.name);
    Some(Edit::AddMaterial(copy))
}

/// What can be done with a material as a whole.
pub fn buttons(ui: &mut Ui, cx: &mut PanelContext, id: MaterialId) {
    if ui.button(cx.tr("Duplicate")).clicked()
        && let Some(edit) = duplicate(&cx.app.document, id)
    {
        cx.edit(edit);
    }
    let about = cx.tr("Only where nothing is made of it.");
    let delete = ui.button(cx.tr("Delete")).on_hover_text(about);
    if delete.clicked() {
        cx.edit(Edit::DeleteMaterial(id));
    }
}
