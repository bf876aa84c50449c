//! Edits, undo and redo, and the selection.

use super::{App, Severity};
use crate::command::Selection;
use crate::document::{Edit, ItemId, SceneDocument};
use crate::jobs::JobKind;
use azulejo::scene::{Material, Shape};
use azulejo::trace::time::Instant;
use std::sync::Arc;

/// Memory that the undo history may use beside the document, in bytes: half a gigabyte. For a
/// document larger than half of that, twice its own size; otherwise an edit of everything could
/// hardly be undone.
pub(super) const UNDO_BYTES: u64 = 512 << 20;

/// The state that undo restores.
#[derive(Clone, Debug)]
pub(super) struct UndoSnapshot {
    document: SceneDocument,
    selection: Vec<ItemId>,
    revision: u64,
}

impl UndoSnapshot {
    /// Bytes that the snapshot holds and `document` does not.
    fn bytes_beyond(&self, document: &SceneDocument) -> u64 {
        let selection = self.selection.capacity() * size_of::<ItemId>();
        self.document.bytes_beyond(document) + selection as u64
    }
}

impl App {
    fn version(&self) -> UndoSnapshot {
        UndoSnapshot {
            document: self.document.clone(),
            selection: self.selection.ids.clone(),
            revision: self.revision,
        }
    }

    pub(super) fn edit(&mut self, edit: &Edit, gesture: Option<u64>) {
        #[cfg(test)]
        self.executed.1.push(edit.clone());
        if !edit.changes(&self.document) {
            return;
        }
        let before = self.version();
        let material = self.chosen_material();
        let mut notes = Vec::new();
        match edit.apply_noting(&mut self.document, &mut notes) {
            Ok(ids) => {
                let about = edit.subject(&before.document, &self.document, &ids);
                self.push_history((edit.label(), about), before, gesture);
                self.changed();
                self.select_after(edit, ids, material);
                let notes = notes.into_iter();
                notes.for_each(|note| self.report(Severity::Warning, note));
            }
            Err(refused) => {
                let text = self.tr(&refused.0).to_owned();
                self.report(Severity::Error, text);
            }
        }
    }

    /// Records the state before the last edit, and drops old steps beyond the memory limit.
    fn push_history(
        &mut self,
        (label, about): (&'static str, Option<String>),
        before: UndoSnapshot,
        gesture: Option<u64>,
    ) {
        let document = &self.document;
        self.history.record(label, about, before, gesture);
        self.history
            .set_bytes(|version| version.bytes_beyond(document));
        // Measuring the document takes time, so only do it when it matters.
        if self.history.bytes() > self.undo_bytes {
            let most = self.undo_bytes.max(2 * document.bytes());
            self.history.limit_bytes(most);
        }
    }

    /// Selects what an edit created and deselects what it deleted; `material` is the one that was
    /// being edited before.
    fn select_after(&mut self, edit: &Edit, ids: Vec<ItemId>, material: Option<Arc<Material>>) {
        match edit {
            Edit::AddMaterial(_) => {
                self.selection.material = Some((self.document.materials.len() - 1) as u32);
            }
            Edit::Delete(_) => {
                self.selection.ids.retain(|&id| self.document.has(id));
                // Pressing the same key again must not apply to the material of a deleted object.
                if self.selection.ids.is_empty() {
                    self.selection.material = None;
                }
            }
            Edit::DeleteMaterial(_) | Edit::DeleteUnusedMaterials => {
                let is_there = self.follow_material(material);
                self.selection.material = self.selection.material.filter(|_| is_there);
            }
            Edit::Duplicate(_)
            | Edit::AddShape(_)
            | Edit::AddLight(_)
            | Edit::AddEnvironment(..)
            | Edit::ExtractSun(_)
            | Edit::AddCamera(_) => {
                // A camera of the view that shows the model need not be seen itself.
                if !matches!(edit, Edit::AddCamera(_)) {
                    self.reveal(&ids);
                }
                self.select(Selection {
                    ids,
                    ..Selection::default()
                });
            }
            Edit::AddStudio => {
                // Its camera sees the model under its lamps; a file's own view is kept.
                let camera = self
                    .document
                    .cameras
                    .iter()
                    .find(|c| c.source_file.is_none());
                if let Some(view) = camera.filter(|c| c.camera.name == "studio") {
                    self.view.camera = view.camera.clone();
                }
                self.frame_from_outside();
            }
            _ => {}
        }
        self.prune_selection();
    }

    /// Updates everything that depends on which document is open.
    fn changed(&mut self) {
        self.revision = self.new_revision();
        self.edited();
    }

    /// Updates everything that depends on the content of the document.
    fn edited(&mut self) {
        self.changed_at.get_or_insert_with(Instant::now);
        self.jobs.cancel_kind(JobKind::FormFactors);
        (self.finer_mesh, self.save_when_solved) = (None, None);
        self.lightmap_outdated();
        if self.lighting.document_changed(&self.document) {
            self.light_changed();
        }
        self.refresh_probes();
        self.refresh_task_plane();
        self.close_render();
        self.update_recipe_notes();
    }

    /// Returns a revision number that no document has had before.
    pub(super) fn new_revision(&mut self) -> u64 {
        self.latest += 1;
        self.latest
    }

    pub(super) fn undo(&mut self) {
        let now = self.version();
        if let Some(version) = self.history.undo(now) {
            self.go_to(version);
        }
    }

    pub(super) fn redo(&mut self) {
        let now = self.version();
        if let Some(version) = self.history.redo(now) {
            self.go_to(version);
        }
    }

    fn go_to(&mut self, version: UndoSnapshot) {
        let material = self.chosen_material();
        let loses_all = !self.selection.ids.is_empty() && version.selection.is_empty();
        self.document = version.document;
        self.selection.ids = version.selection;
        self.revision = version.revision;
        self.follow_material(material);
        if loses_all {
            self.selection.material = None;
        }
        self.prune_selection();
        self.edited();
    }

    pub(super) fn select(&mut self, selection: Selection) {
        self.selection = selection;
        self.history.end_gesture();
        self.prune_selection();
        self.sync_material();
    }

    pub(super) fn select_all(&mut self) {
        let document = &self.document;
        let items = document.objects.iter().map(|i| i.id);
        let lights = document.lights.iter().map(|l| l.id);
        let cameras = document.cameras.iter().map(|c| c.id);
        self.selection.ids = items.chain(lights).chain(cameras).collect();
        self.selection.faces = None;
        self.sync_material();
    }

    /// Makes the material of the selected object the one being edited.
    fn sync_material(&mut self) {
        let items = self.selection.ids.iter();
        let mut items = items.filter_map(|&id| self.document.object(id));
        if self.selection.material.is_none() {
            let first = items.find_map(|item| item.materials().first().copied());
            self.selection.material = first;
        }
    }

    /// Removes deleted objects, faces and materials from the selection.
    fn prune_selection(&mut self) {
        let document = &self.document;
        let selection = &mut self.selection;
        selection.ids.retain(|&id| document.has(id));
        let has_faces =
            |(id, faces): &(ItemId, Vec<u32>)| match document.object(*id).map(|i| &*i.shape) {
                Some(Shape::Mesh(mesh)) => faces.iter().all(|&f| (f as usize) < mesh.faces.len()),
                _ => false,
            };
        selection.faces = selection.faces.take().filter(has_faces);
        if (selection.material).is_some_and(|m| m as usize >= document.materials.len()) {
            selection.material = None;
        }
    }
}
