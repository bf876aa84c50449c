//! The editor of the selected material, with what it is shown.

use super::brdf::{BrdfEditor, EditorInput, EditorResponse, PreviewLight};
use super::material_actions::buttons;
use super::panel_context::PanelContext;
use crate::command::{Command, FileRequest};
use crate::document::{Edit, ItemId, SceneDocument};
use azulejo::scene::{Light, Material, MaterialId, Shape};
use egui::Ui;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The editor of materials.
#[derive(Default)]
pub struct MaterialPanel {
    editor: BrdfEditor,
    preview: PreviewCache,
    /// A reflection model that waits for a place to be saved.
    pub saving: Option<String>,
    /// Counts finished changes: each is one step of undo.
    changes: u64,
}

impl MaterialPanel {
    /// Shows the material that is selected.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let app = cx.app;
        let id = app.selection.material;
        let found = id.and_then(|id| Some((id, app.document.materials.get(id as usize)?)));
        let Some((id, material)) = found else {
            ui.weak(cx.tr("Select an object, or a material in the tree."));
            return;
        };
        ui.horizontal(|ui| buttons(ui, cx, id));
        let shown = EditorInput {
            // The same number is another material where some were taken away.
            key: u64::from(id) | (app.document.materials.len() as u64) << 32,
            material,
            others: &app.document.materials,
            light: self.preview.light(cx),
            is_photometric: app.document.units.photometric,
        };
        for answer in self.editor.ui(ui, cx.language, &shown) {
            self.take(answer, id, cx);
        }
    }

    fn take(&mut self, answer: EditorResponse, id: MaterialId, cx: &mut PanelContext) {
        match answer {
            EditorResponse::Change {
                material,
                is_finished,
            } => {
                // Presses of the mouse count up from 0, finished changes down from the end.
                let gesture = Some(u64::MAX - self.changes);
                cx.send(Command::Edit(Edit::SetMaterial(id, material), gesture));
                self.changes += u64::from(is_finished);
            }
            EditorResponse::Load => cx.send(Command::RequestFile(FileRequest::LoadBrdf)),
            EditorResponse::Save(text) => {
                self.saving = Some(text);
                cx.send(Command::RequestFile(FileRequest::SaveBrdf));
            }
        }
    }
}

/// The light of the preview sphere, kept as long as what shines stays what it is.
#[derive(Default)]
struct PreviewCache {
    /// The document and the selection that were looked at last.
    seen: Option<(u64, Vec<ItemId>)>,
    kept: Option<(Option<LightingKey>, PreviewLight)>,
}

impl PreviewCache {
    /// The scene's own light, at the selection or in the middle; a studio where nothing shines.
    fn light(&mut self, cx: &PanelContext) -> &PreviewLight {
        let app = cx.app;
        let (revision, ids) = (app.revision(), &app.selection.ids);
        let is_seen = (self.seen.as_ref()).is_some_and(|(r, s)| *r == revision && s == ids);
        if !is_seen {
            self.seen = Some((revision, ids.clone()));
            let shining = LightingKey::of(&app.document, ids);
            if self.kept.as_ref().is_none_or(|(of, _)| *of != shining) {
                let light = match &shining {
                    Some(s) => PreviewLight::of_scene(&app.document.lamps_scene(), s.at),
                    None => PreviewLight::studio(),
                };
                self.kept = Some((shining, light));
            }
        }
        let (_, light) = self
            .kept
            .get_or_insert_with(|| (None, PreviewLight::studio()));
        light
    }
}

/// All that the light at a place depends on: while a material is dragged about that does not
/// shine, nothing of it changes, and no lamp need be looked at again.
#[derive(PartialEq)]
struct LightingKey {
    at: DVec3,
    up: azulejo::scene::Up,
    lights: Vec<Light>,
    /// Objects that shine.
    items: Vec<(ShapePointer, DAffine3)>,
    /// What they are made of.
    materials: Vec<Arc<Material>>,
}

/// A shape that is equal to itself alone: nobody looks through its faces to find out.
struct ShapePointer(Arc<Shape>);

impl PartialEq for ShapePointer {
    fn eq(&self, other: &ShapePointer) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl LightingKey {
    /// What shines on the selection, or on the middle of everything; `None` where nothing does.
    fn of(document: &SceneDocument, ids: &[ItemId]) -> Option<LightingKey> {
        if !document.has_light() {
            return None;
        }
        let chosen = document.bounds(Some(ids));
        let at = if chosen.is_empty() {
            document.bounds(None).centre()
        } else {
            chosen.centre()
        };
        let emitters = document.materials.iter().filter(|m| m.is_emitter());
        let materials = &document.materials;
        let shines = |m: MaterialId| materials.get(m as usize).is_some_and(|m| m.is_emitter());
        let items = document.objects.iter();
        let items = items.filter(|item| item.materials().iter().any(|&m| shines(m)));
        Some(LightingKey {
            at,
            up: document.units.up,
            lights: document.lights.iter().map(|l| l.light.clone()).collect(),
            items: items
                .map(|i| (ShapePointer(Arc::clone(&i.shape)), i.placement))
                .collect(),
            materials: emitters.cloned().collect(),
        })
    }
}
