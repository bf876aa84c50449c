//! The rows of the tree, cached between frames: moving the mouse does not visit a hundred thousand
//! rows.

use super::rows::{TreeLeaf, TreeRow, chosen, rows, visible};
use crate::app::App;
use crate::document::{ItemId, SceneDocument, SceneObject};
use crate::words::Language;
use azulejo::scene::Material;
use std::collections::HashSet;
use std::sync::Arc;

/// All rows, with data derived from them.
#[derive(Default)]
pub(super) struct TreeList {
    rows: Vec<TreeRow>,
    made_of: Option<ListKey>,
    /// Collapsed groups, by their keys.
    closed: HashSet<u64>,
    /// Indices of the rows outside of collapsed groups.
    visible: Vec<usize>,
    /// Which rows are selected, and for which selection.
    chosen: Vec<bool>,
    selected: Vec<ItemId>,
    /// How often the rows were rebuilt.
    #[cfg(test)]
    makings: usize,
}

/// Everything that the rows depend on.
struct ListKey {
    document: SceneDocument,
    revision: u64,
    filter: String,
    language: Language,
}

impl TreeList {
    /// Updates the rows to the state of the app.
    pub fn follow(&mut self, app: &App, filter: &str, language: Language) {
        let is_new = self.follow_document(app, filter, language);
        if is_new {
            self.rows = rows(&app.document, filter, language);
            self.visible = visible(&self.rows, &self.closed);
            #[cfg(test)]
            {
                self.makings += 1;
            }
        }
        if is_new || self.selected != app.selection.ids {
            self.selected.clone_from(&app.selection.ids);
            let selected = self.selected.iter().copied().collect();
            self.chosen = chosen(&self.rows, &selected);
        }
    }

    /// Rebuilds the rows if necessary; returns whether it did.
    fn follow_document(&mut self, app: &App, filter: &str, language: Language) -> bool {
        let mut is_new = true;
        if let Some(of) = &self.made_of
            && of.filter == filter
            && of.language == language
        {
            if of.revision == app.revision() {
                return false;
            }
            is_new = !have_same_rows(&of.document, &app.document);
        }
        self.made_of = Some(ListKey {
            document: app.document.clone(),
            revision: app.revision(),
            filter: filter.to_owned(),
            language,
        });
        is_new
    }

    pub fn row(&self, at: usize) -> &TreeRow {
        &self.rows[at]
    }

    /// The rows outside of collapsed groups.
    pub fn visible(&self) -> &[usize] {
        &self.visible
    }

    pub fn is_chosen(&self, at: usize) -> bool {
        self.chosen[at]
    }

    pub fn is_open(&self, group: u64) -> bool {
        !self.closed.contains(&group)
    }

    /// Expands or collapses a group.
    pub fn toggle(&mut self, group: u64) {
        if !self.closed.remove(&group) {
            self.closed.insert(group);
        }
        self.visible = visible(&self.rows, &self.closed);
    }

    /// Expands all groups that contain an item; returns its position among the visible rows.
    pub fn reveal(&mut self, id: ItemId) -> Option<usize> {
        let at = self.rows.iter().position(|r| r.leaf.id() == Some(id))?;
        let mut opened = false;
        let mut row = &self.rows[at];
        while let Some(parent) = row.parent {
            row = &self.rows[parent];
            if let TreeLeaf::Group(key) = &row.leaf {
                opened |= self.closed.remove(key);
            }
        }
        if opened {
            self.visible = visible(&self.rows, &self.closed);
        }
        self.visible.binary_search(&at).ok()
    }

    /// The items in a group.
    pub fn ids(&self, group: usize) -> Vec<ItemId> {
        let within = &self.rows[group..self.rows[group].end];
        within.iter().filter_map(|row| row.leaf.id()).collect()
    }
}

/// Whether two documents have the same rows. Dragging an object changes the document in every
/// frame, but no row.
fn have_same_rows(a: &SceneDocument, b: &SceneDocument) -> bool {
    let materials = all(&a.materials, &b.materials, |a, b| {
        let key = |m: &Material| (m.name.clone(), m.textures.clone(), m.is_emitter());
        Arc::ptr_eq(a, b) || key(a) == key(b)
    });
    let lights = all(&a.lights, &b.lights, |a, b| {
        (a.id, a.hidden, &a.light.name) == (b.id, b.hidden, &b.light.name)
    });
    let cameras = all(&a.cameras, &b.cameras, |a, b| {
        (a.id, a.hidden, &a.camera.name) == (b.id, b.hidden, &b.camera.name)
    });
    materials
        && lights
        && cameras
        && all(&a.source_files, &b.source_files, |a, b| a.name == b.name)
        && all(&a.textures, &b.textures, Arc::ptr_eq)
        && all(&a.objects, &b.objects, |a, b| {
            Arc::ptr_eq(a, b) || is_same_row(a, b)
        })
}

fn is_same_row(a: &SceneObject, b: &SceneObject) -> bool {
    let key = |i: &SceneObject| (i.id, i.source_file, i.hidden);
    key(a) == key(b) && a.name == b.name && Arc::ptr_eq(&a.shape, &b.shape)
}

fn all<T>(a: &[T], b: &[T], alike: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Command, Selection};
    use crate::document::Edit;
    use crate::document::tests::sample;
    use azulejo::scene::Texture;
    use glam::{DAffine3, DVec3};

    fn filled() -> (App, TreeList) {
        let mut app = App::quiet();
        app.execute(Command::Edit(Edit::Append(Box::new(sample())), None));
        let mut list = TreeList::default();
        list.follow(&app, "", Language::English);
        (app, list)
    }

    fn makings(app: &mut App, list: &mut TreeList, edit: Edit) -> usize {
        let before = list.makings;
        app.execute(Command::Edit(edit, None));
        list.follow(app, "", Language::English);
        list.makings - before
    }

    #[test]
    fn rows_are_made_when_they_change_and_not_before() {
        let (mut app, mut list) = filled();
        list.follow(&app, "", Language::English);
        assert_eq!(list.makings, 1);
        let ball = ItemId(3);
        let drag = Edit::Transform(vec![ball, ItemId(5)], DAffine3::from_translation(DVec3::X));
        assert_eq!(makings(&mut app, &mut list, drag), 0);
        let mut white = app.document.materials[1].as_ref().clone();
        white.diffuse *= 0.5;
        let darker = Edit::SetMaterial(1, white.clone());
        assert_eq!(makings(&mut app, &mut list, darker), 0);
        white.name = "grey".into();
        let bulb = app.document.lights[0].id;
        let view = app.document.cameras[0].id;
        for edit in [
            Edit::SetMaterial(1, white),
            Edit::Rename(ball, "marble".into()),
            Edit::Rename(bulb, "sun".into()),
            Edit::Rename(view, "side".into()),
            Edit::Hide(vec![ball], true),
            Edit::Hide(vec![bulb], true),
            Edit::Hide(vec![view], true),
            Edit::Duplicate(vec![ball]),
            Edit::Assign(vec![ball], 0),
            Edit::Delete(vec![view]),
        ] {
            let message = format!("{edit:?}");
            assert_eq!(makings(&mut app, &mut list, edit), 1, "{message}");
        }
        app.execute(Command::Undo);
        list.follow(&app, "", Language::English);
        list.follow(&app, "ball", Language::English);
        list.follow(&app, "ball", Language::Spanish);
        assert_eq!(list.makings, 14);
    }

    #[test]
    fn another_picture_is_another_row() {
        let mut other = sample();
        other.textures[0] = Arc::new(Texture::default());
        assert!(have_same_rows(&other.clone(), &other));
        assert!(!have_same_rows(&sample(), &other));
    }

    #[test]
    fn what_is_looked_for_is_opened_and_found() {
        let (mut app, mut list) = filled();
        let rows = list.visible().len();
        let TreeLeaf::Group(top) = list.row(0).leaf else {
            panic!("the first row is a group")
        };
        list.toggle(top);
        assert!(!list.is_open(top) && list.visible().len() < rows);
        let floor = ItemId(1);
        let at = list.reveal(floor).unwrap();
        assert_eq!(list.row(list.visible()[at]).leaf, TreeLeaf::Item(floor));
        assert!(list.is_open(top) && list.visible().len() == rows);
        assert_eq!(list.reveal(ItemId(99)), None);

        app.execute(Command::Select(Selection::one(floor)));
        list.follow(&app, "", Language::English);
        assert!(list.is_chosen(list.visible()[at]) && !list.is_chosen(0));
        assert_eq!(list.ids(0), [1, 2, 3, 4].map(ItemId));
        assert_eq!(list.makings, 1);
    }
}
