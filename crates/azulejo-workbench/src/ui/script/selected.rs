//! What steps apply to.

use crate::app::App;
use crate::document::ItemId;
use azulejo::scene::{Material, MaterialId};

/// All selected objects, lights and cameras; at least one.
pub(super) fn selected(app: &App) -> Result<Vec<ItemId>, String> {
    match &app.selection.ids[..] {
        [] => Err("nothing is selected".into()),
        ids => Ok(ids.to_vec()),
    }
}

/// The only selected object, light or camera.
pub(super) fn selected_one(app: &App) -> Result<ItemId, String> {
    match app.selection.ids[..] {
        [id] => Ok(id),
        ref ids => Err(format!("{} items are selected, expected one", ids.len())),
    }
}

/// The selected material.
pub(super) fn selected_material(app: &App) -> Result<(MaterialId, Material), String> {
    let id = app.selection.material.ok_or("no material is selected")?;
    let material = app.document.materials.get(id as usize);
    let material = material.ok_or("the material no longer exists")?;
    Ok((id, Material::clone(material)))
}

/// The first material of a name.
pub(super) fn material_named(app: &App, name: &str) -> Result<MaterialId, String> {
    let at = app.document.materials.iter().position(|m| m.name == name);
    at.map(|at| at as MaterialId)
        .ok_or_else(|| format!("no material is named \"{name}\""))
}
