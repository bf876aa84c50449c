//! The editor of the selected material, with what it is shown.

use super::brdf::{Answer, Editor, PreviewLight, Shown};
use super::desk::Desk;
use super::stock::buttons;
use crate::command::{Ask, Command};
use crate::document::{Document, Edit, Id};
use azulejo::scene::{Light, Material, MaterialId, Shape};
use egui::Ui;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The editor of materials.
#[derive(Default)]
pub struct Materials {
    editor: Editor,
    preview: Preview,
    /// A reflection model that waits for a place to be saved.
    pub saving: Option<String>,
    /// Counts finished changes: each is one step of undo.
    changes: u64,
}

impl Materials {
    /// Shows the material that is selected.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let app = desk.app;
        let id = app.selection.material;
        let found = id.and_then(|id| Some((id, app.document.materials.get(id as usize)?)));
        let Some((id, material)) = found else {
            ui.weak(desk.say("Select an object, or a material in the tree."));
            return;
        };
        ui.horizontal(|ui| buttons(ui, desk, id));
        let shown = Shown {
            // The same number is another material where some were taken away.
            key: u64::from(id) | (app.document.materials.len() as u64) << 32,
            material,
            others: &app.document.materials,
            light: self.preview.light(desk),
            is_photometric: app.document.units.photometric,
        };
        for answer in self.editor.ui(ui, desk.language, &shown) {
            self.take(answer, id, desk);
        }
    }

    fn take(&mut self, answer: Answer, id: MaterialId, desk: &mut Desk) {
        match answer {
            Answer::Change {
                material,
                is_finished,
            } => {
                // Presses of the mouse count up from 0, finished changes down from the end.
                let gesture = Some(u64::MAX - self.changes);
                desk.wish(Command::Edit(Edit::SetMaterial(id, material), gesture));
                self.changes += u64::from(is_finished);
            }
            Answer::Load => desk.wish(Command::Ask(Ask::LoadBrdf)),
            Answer::Save(text) => {
                self.saving = Some(text);
                desk.wish(Command::Ask(Ask::SaveBrdf));
            }
        }
    }
}

/// The light of the preview sphere, kept as long as what shines stays what it is.
#[derive(Default)]
struct Preview {
    /// The document and the selection that were looked at last.
    seen: Option<(u64, Vec<Id>)>,
    kept: Option<(Option<Shining>, PreviewLight)>,
}

impl Preview {
    /// The scene's own light, at the selection or in the middle; a studio where nothing shines.
    fn light(&mut self, desk: &Desk) -> &PreviewLight {
        let app = desk.app;
        let (revision, ids) = (app.revision(), &app.selection.ids);
        let is_seen = (self.seen.as_ref()).is_some_and(|(r, s)| *r == revision && s == ids);
        if !is_seen {
            self.seen = Some((revision, ids.clone()));
            let shining = Shining::of(&app.document, ids);
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
struct Shining {
    at: DVec3,
    up: azulejo::scene::Up,
    lights: Vec<Light>,
    /// Objects that shine.
    items: Vec<(Shared, DAffine3)>,
    /// What they are made of.
    materials: Vec<Arc<Material>>,
}

/// A shape that is equal to itself alone: nobody looks through its faces to find out.
struct Shared(Arc<Shape>);

impl PartialEq for Shared {
    fn eq(&self, other: &Shared) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Shining {
    /// What shines on the selection, or on the middle of everything; `None` where nothing does.
    fn of(document: &Document, ids: &[Id]) -> Option<Shining> {
        if !document.has_light() {
            return None;
        }
        let chosen = document.bounds(Some(ids));
        let at = match chosen.is_empty() {
            true => document.bounds(None).centre(),
            false => chosen.centre(),
        };
        let emitters = document.materials.iter().filter(|m| m.is_emitter());
        let materials = &document.materials;
        let shines = |m: MaterialId| materials.get(m as usize).is_some_and(|m| m.is_emitter());
        let items = document.items.iter();
        let items = items.filter(|item| item.materials().iter().any(|&m| shines(m)));
        Some(Shining {
            at,
            up: document.units.up,
            lights: document.lights.iter().map(|l| l.light.clone()).collect(),
            items: items
                .map(|i| (Shared(Arc::clone(&i.shape)), i.placement))
                .collect(),
            materials: emitters.cloned().collect(),
        })
    }
}
