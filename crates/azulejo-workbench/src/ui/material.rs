//! The Material tab: the editor of the selected material.

use super::brdf::{BrdfEditor, EditorInput, EditorResponse, PreviewLight, SpherePictures};
use super::material_actions::buttons;
use super::material_library;
use super::panel_context::PanelContext;
use crate::command::{Command, FileRequest};
use crate::document::{Edit, ItemId, SceneDocument};
use azulejo::scene::{Light, Material, MaterialId, Shape};
use egui::Ui;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The Material tab.
#[derive(Default)]
pub struct MaterialPanel {
    editor: BrdfEditor,
    preview: PreviewCache,
    pictures: SpherePictures,
    /// A reflection model whose file the user is choosing.
    pub saving: Option<String>,
    /// Counts finished changes: each is an undo step.
    changes: u64,
}

impl MaterialPanel {
    /// Draws the editor for the selected material.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let app = cx.app;
        let id = app.selection.material;
        let selected = id.and_then(|id| Some((id, app.document.materials.get(id as usize)?)));
        let Some((id, material)) = selected else {
            ui.weak(cx.tr("Select an object, or a material in the tree."));
            self.library(ui, cx, None);
            return;
        };
        self.library(ui, cx, Some(id));
        ui.horizontal(|ui| buttons(ui, cx, id));
        let shown = EditorInput {
            // The same index is another material after a deletion.
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

    /// The library; a click is an undo step of its own.
    fn library(&mut self, ui: &mut Ui, cx: &mut PanelContext, material: Option<MaterialId>) {
        let gesture = u64::MAX - self.changes;
        let clicked = material_library::show(ui, cx, &mut self.pictures, material, gesture);
        self.changes += u64::from(clicked);
    }

    fn take(&mut self, answer: EditorResponse, id: MaterialId, cx: &mut PanelContext) {
        match answer {
            EditorResponse::Change {
                material,
                is_finished,
            } => {
                // Mouse gestures count up from 0, finished changes down from the maximum.
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

/// The lighting of the preview sphere, cached until the emitters change.
#[derive(Default)]
struct PreviewCache {
    /// Revision of the document and selection at the last update.
    made_for: Option<(u64, Vec<ItemId>)>,
    kept: Option<(Option<LightingKey>, PreviewLight)>,
}

impl PreviewCache {
    /// The scene's light at the selection or at its centre; a studio if nothing emits light.
    fn light(&mut self, cx: &PanelContext) -> &PreviewLight {
        let app = cx.app;
        let (revision, ids) = (app.revision(), &app.selection.ids);
        let is_current = (self.made_for.as_ref()).is_some_and(|(r, s)| *r == revision && s == ids);
        if !is_current {
            self.made_for = Some((revision, ids.clone()));
            let shining = LightingKey::of(&app.document, ids);
            if self.kept.as_ref().is_none_or(|(of, _)| *of != shining) {
                let light = match &shining {
                    Some(s) => PreviewLight::of_scene(&app.document.emitters_scene(), s.at),
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

/// Everything that determines the light at a point: editing a material that does not emit changes
/// nothing here, so that the lighting need not be recomputed.
#[derive(PartialEq)]
struct LightingKey {
    at: DVec3,
    up: azulejo::scene::Up,
    lights: Vec<Light>,
    /// Emissive objects.
    items: Vec<(ShapePointer, DAffine3)>,
    materials: Vec<Arc<Material>>,
}

/// A shape compared by address, without looking at its faces.
struct ShapePointer(Arc<Shape>);

impl PartialEq for ShapePointer {
    fn eq(&self, other: &ShapePointer) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl LightingKey {
    /// The emitters, and the selection's position or the centre of the model; `None` without
    /// emitters.
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
