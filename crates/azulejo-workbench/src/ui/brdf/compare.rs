//! Choosing a material to compare with.

use super::catalog::{GROUPS, example};
use super::file::with_description;
use super::theme::row;
use crate::ui::focus;
use crate::words::Language;
use azulejo::scene::Material;
use azulejo::scene::brdf::{Description, ModelInfo, find};
use egui::{ComboBox, RichText, Ui};
use std::sync::Arc;

/// The other material.
pub(super) struct ComparedMaterial {
    name: String,
    material: Arc<Material>,
    /// Its index among the scene's materials; `None` for an example of a model.
    index: Option<usize>,
}

/// Draws the choice.
pub(super) fn choose(
    ui: &mut Ui,
    language: Language,
    compared: &mut Option<ComparedMaterial>,
    others: &[Arc<Material>],
) {
    let none = language.tr("None");
    let chosen = compared.as_ref().map_or(none, |c| &c.name).to_owned();
    let about = language.tr("Both are shown in the same plots; the second is dashed.");
    row(ui, language.tr("Compare with"), about, |ui, label| {
        let combo = ComboBox::from_id_salt("compare")
            .selected_text(&chosen)
            .width((ui.available_width() - 8.0).min(220.0))
            .height(420.0)
            .truncate();
        let shown = combo.show_ui(ui, |ui| {
            focus::close_list(ui);
            if ui.selectable_label(compared.is_none(), none).clicked() {
                *compared = None;
            }
            if let Some(new) = entries(ui, language, others) {
                *compared = Some(new);
            }
        });
        shown.response.accessible_name(label);
    });
}

/// Materials of the scene, and the first example of each model.
fn entries(ui: &mut Ui, language: Language, others: &[Arc<Material>]) -> Option<ComparedMaterial> {
    let mut chosen = None;
    if !others.is_empty() {
        ui.label(RichText::new(language.tr("Materials of the scene")).strong());
    }
    for (index, material) in others.iter().enumerate() {
        let name = name(language, material);
        if ui
            .push_id(index, |ui| ui.selectable_label(false, format!("   {name}")))
            .inner
            .clicked()
        {
            chosen = Some(ComparedMaterial {
                name,
                material: material.clone(),
                index: Some(index),
            });
        }
    }
    for group in &GROUPS {
        ui.label(RichText::new((group.title)(language)).strong());
        for info in group.models() {
            let entry = ui.selectable_label(false, format!("   {}", language.tr(info.title)));
            let about = info.examples.first().copied().unwrap_or_default();
            if entry.on_hover_text(about).clicked() {
                chosen = exemplary(language, info);
            }
        }
    }
    chosen
}

fn exemplary(language: Language, info: &'static ModelInfo) -> Option<ComparedMaterial> {
    let description = Description::Model(example(info, 0)?);
    let material = with_description(&Material::default(), description).ok()?;
    Some(ComparedMaterial {
        name: language.tr(info.title).to_owned(),
        material: Arc::new(material),
        index: None,
    })
}

/// The other material in its current state: a material of the scene may have been changed or
/// deleted.
pub(super) fn current<'a>(
    compared: &'a mut Option<ComparedMaterial>,
    others: &[Arc<Material>],
) -> Option<(&'a str, &'a Material)> {
    let compared = compared.as_mut()?;
    let now = compared.index.and_then(|k| others.get(k));
    if let Some(now) = now.filter(|m| m.name == compared.material.name) {
        compared.material = now.clone();
    }
    Some((&compared.name, &compared.material))
}

/// The name of a material, or that of its model.
pub(super) fn name(language: Language, material: &Material) -> String {
    if !material.name.is_empty() {
        return material.name.clone();
    }
    match material.brdf.as_ref().map(|brdf| brdf.description()) {
        Some(Description::Model(model)) => find(&model.name).map_or(model.name.clone(), |info| {
            language.tr(info.title).to_owned()
        }),
        Some(Description::File { path, .. }) => path.clone(),
        _ => language.tr("Unnamed").to_owned(),
    }
}
