//! Building the rows of the tree from a document.

use super::definitions;
use crate::document::{ItemId, SceneDocument};
use crate::words::Language;
use azulejo::scene::MaterialId;
use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, HashSet};
use std::hash::{Hash, Hasher};

/// Limit on nested groups: deeper ones become part of the label. A file may nest them without
/// limit.
const MAX_DEPTH: usize = 64;
/// Limit on the length of a label in characters; a name may be as long as its file.
const MAX_LABEL_CHARS: usize = 200;

/// A row of the tree.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TreeRow {
    pub depth: usize,
    pub label: String,
    pub leaf: TreeLeaf,
    /// Index of the row of the enclosing group.
    pub parent: Option<usize>,
    /// Index after the last row of its content.
    pub end: usize,
    /// Whether any of its content is visible; `None` for rows that cannot be hidden.
    pub shown: Option<bool>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TreeLeaf {
    /// A group, by a key that survives rebuilding.
    Group(u64),
    Item(ItemId),
    Light(ItemId),
    Camera(ItemId),
    Material(MaterialId),
    /// A definition, with the objects that use it.
    Definition(Vec<ItemId>),
}

impl TreeLeaf {
    /// The item in this row.
    pub fn id(&self) -> Option<ItemId> {
        match self {
            TreeLeaf::Item(id) | TreeLeaf::Light(id) | TreeLeaf::Camera(id) => Some(*id),
            TreeLeaf::Group(_) | TreeLeaf::Material(_) | TreeLeaf::Definition(_) => None,
        }
    }
}

/// A row of an item, while the tree is built.
pub(super) struct TreeItem {
    pub label: String,
    pub leaf: TreeLeaf,
    pub shown: Option<bool>,
}

/// The tree while it is built: groups sorted by name, followed by items in their own order.
#[derive(Default)]
struct GroupNode {
    groups: BTreeMap<String, GroupNode>,
    entries: Vec<TreeItem>,
}

/// The position at which rows are inserted.
struct ListPosition {
    parent: Option<usize>,
    depth: usize,
    /// Key of the group.
    key: u64,
}

impl GroupNode {
    fn of(entries: Vec<TreeItem>) -> GroupNode {
        GroupNode {
            groups: BTreeMap::new(),
            entries,
        }
    }

    fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.entries.is_empty()
    }

    /// Inserts an item at its path.
    fn insert(&mut self, path: &str, leaf: TreeLeaf, shown: bool) {
        let (mut node, mut rest) = (self, path);
        for _ in 0..MAX_DEPTH {
            match rest.split_once('/') {
                Some((group, inner)) if !group.is_empty() && !inner.is_empty() => {
                    node = node.groups.entry(group.to_owned()).or_default();
                    rest = inner;
                }
                _ => break,
            }
        }
        node.entries.push(TreeItem {
            label: rest.to_owned(),
            leaf,
            shown: Some(shown),
        });
    }

    /// Appends the rows of its content; returns whether any of it is visible.
    fn list(self, position: &ListPosition, rows: &mut Vec<TreeRow>) -> Option<bool> {
        let mut shown = None;
        for (name, node) in self.groups {
            shown = either(shown, node.list_as(&name, position, rows));
        }
        for entry in self.entries {
            shown = either(shown, entry.shown);
            rows.push(TreeRow {
                depth: position.depth,
                label: short(&entry.label),
                leaf: entry.leaf,
                parent: position.parent,
                end: rows.len() + 1,
                shown: entry.shown,
            });
        }
        shown
    }

    /// Appends its rows as a group.
    fn list_as(self, name: &str, position: &ListPosition, rows: &mut Vec<TreeRow>) -> Option<bool> {
        let (at, key) = (rows.len(), key(position.key, name));
        rows.push(TreeRow {
            depth: position.depth,
            label: short(name),
            leaf: TreeLeaf::Group(key),
            parent: position.parent,
            end: at,
            shown: None,
        });
        let within = ListPosition {
            parent: Some(at),
            depth: position.depth + 1,
            key,
        };
        let shown = self.list(&within, rows);
        (rows[at].end, rows[at].shown) = (rows.len(), shown);
        shown
    }
}

fn either(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a || b),
        (a, b) => a.or(b),
    }
}

/// The key of a group: it stays collapsed when the rows are rebuilt.
fn key(parent: u64, name: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    (parent, name).hash(&mut hasher);
    hasher.finish()
}

fn short(name: &str) -> String {
    match name.char_indices().nth(MAX_LABEL_CHARS) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// All rows of a document that match a filter, with groups expanded.
pub(super) fn rows(document: &SceneDocument, filter: &str, language: Language) -> Vec<TreeRow> {
    let filter = filter.to_lowercase();
    let matches = |name: &str| filter.is_empty() || name.to_lowercase().contains(&filter);
    let mut rows = Vec::new();
    let files = ListPosition {
        parent: None,
        depth: 0,
        key: 0,
    };
    let own = objects(document, &matches, language);
    for (title, node) in own.into_iter().filter(|(_, node)| !node.is_empty()) {
        node.list_as(title, &files, &mut rows);
    }
    // After the files whatever their names are, and independent of which of those are collapsed.
    let behind = ListPosition { key: 1, ..files };
    let mut lists = lists(document, &matches, language);
    lists.sort_by_key(|(title, _)| *title);
    let shared = definitions::of(document, language);
    let shared = shared.into_iter().map(|(title, mut entries)| {
        entries.retain(|entry| matches(&entry.label));
        (title.to_owned(), GroupNode::of(entries))
    });
    let shared = GroupNode {
        groups: shared.filter(|(_, node)| !node.is_empty()).collect(),
        entries: Vec::new(),
    };
    lists.push((language.tr("Definitions"), shared));
    for (title, node) in lists.into_iter().filter(|(_, node)| !node.is_empty()) {
        node.list_as(title, &behind, &mut rows);
    }
    rows
}

/// Files in the order in which they were added, each with its groups; then objects created here.
fn objects<'d>(
    document: &'d SceneDocument,
    matches: &impl Fn(&str) -> bool,
    language: Language,
) -> Vec<(&'d str, GroupNode)> {
    let names = document.source_files.iter().map(|b| b.name.as_str());
    let titles = names.chain([language.tr("Created here")]);
    let mut files: Vec<(&str, GroupNode)> =
        titles.map(|title| (title, GroupNode::default())).collect();
    let made_here = document.source_files.len();
    for item in document.objects.iter().filter(|i| matches(&i.name)) {
        let file = item.source_file.unwrap_or(made_here).min(made_here);
        let (title, node) = &mut files[file];
        node.insert(
            inside(&item.name, title),
            TreeLeaf::Item(item.id),
            !item.hidden,
        );
    }
    files
}

/// Lights, cameras, materials and definitions, with their titles.
fn lists(
    document: &SceneDocument,
    matches: &impl Fn(&str) -> bool,
    language: Language,
) -> Vec<(&'static str, GroupNode)> {
    let entry = |name: &str, leaf: TreeLeaf, shown: Option<bool>| {
        matches(name).then(|| TreeItem {
            label: name.to_owned(),
            leaf,
            shown,
        })
    };
    let lights = document.lights.iter();
    let lights =
        lights.filter_map(|l| entry(&l.light.name, TreeLeaf::Light(l.id), Some(!l.hidden)));
    // What shines is a light, whatever its shape; it also stands among the objects.
    let emitters = document.objects.iter().filter(|item| document.shines(item));
    let emitters =
        emitters.filter_map(|item| entry(&item.name, TreeLeaf::Item(item.id), Some(!item.hidden)));
    let lights = lights.chain(emitters);
    let cameras = document.cameras.iter();
    let cameras =
        cameras.filter_map(|c| entry(&c.camera.name, TreeLeaf::Camera(c.id), Some(!c.hidden)));
    let materials = (0..).zip(&document.materials);
    let materials = materials.filter_map(|(k, m)| entry(&m.name, TreeLeaf::Material(k), None));
    vec![
        (language.tr("Lights"), GroupNode::of(lights.collect())),
        (language.tr("Cameras"), GroupNode::of(cameras.collect())),
        (language.tr("Materials"), GroupNode::of(materials.collect())),
    ]
}

/// A name without the prefix of its file, whose row is above it.
fn inside<'a>(name: &'a str, source_file: &str) -> &'a str {
    let rest = name
        .strip_prefix(source_file)
        .and_then(|r| r.strip_prefix('/'));
    rest.unwrap_or(name)
}

/// The rows outside of collapsed groups.
pub(super) fn visible(rows: &[TreeRow], closed: &HashSet<u64>) -> Vec<usize> {
    let mut visible = Vec::new();
    let mut at = 0;
    while let Some(row) = rows.get(at) {
        visible.push(at);
        at = match &row.leaf {
            TreeLeaf::Group(key) if closed.contains(key) => row.end,
            _ => at + 1,
        };
    }
    visible
}

/// Which rows are selected: a group is if all of its content is.
pub(super) fn chosen(rows: &[TreeRow], selected: &HashSet<ItemId>) -> Vec<bool> {
    let mut chosen = vec![false; rows.len()];
    // For each group: its number of items, and how many of them are not selected.
    let mut counts = vec![(0_usize, 0_usize); rows.len()];
    // The content of a group follows its row.
    for (at, row) in rows.iter().enumerate().rev() {
        let (all, others) = match row.leaf.id() {
            Some(id) => (1, usize::from(!selected.contains(&id))),
            None => counts[at],
        };
        chosen[at] = all > 0 && others == 0;
        if let Some(parent) = row.parent {
            counts[parent].0 += all;
            counts[parent].1 += others;
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::sample;
    use std::sync::Arc;

    fn named(name: &str) -> Vec<TreeRow> {
        let mut document = sample();
        document.objects.truncate(1);
        Arc::make_mut(&mut document.objects[0]).name = name.into();
        let mut rows = rows(&document, "", Language::English);
        rows.truncate(rows[0].end);
        rows
    }

    /// Memory used by the texts of rows.
    fn bytes(rows: &[TreeRow]) -> usize {
        let text = |row: &TreeRow| row.label.capacity();
        rows.iter()
            .map(|row| size_of::<TreeRow>() + text(row))
            .sum()
    }

    #[test]
    fn a_name_of_many_groups_is_not_many_rows() {
        let shallow = named("a/b/c");
        let labels: Vec<&str> = shallow.iter().map(|r| r.label.as_str()).collect();
        assert_eq!(labels, ["Created here", "a", "b", "c"]);
        let parents: Vec<_> = shallow.iter().map(|r| r.parent).collect();
        assert_eq!(parents, [None, Some(0), Some(1), Some(2)]);
        for levels in [4_000, 50_000] {
            let deep = named(&"a/".repeat(levels));
            assert_eq!(deep.len(), MAX_DEPTH + 2);
            assert!(bytes(&deep) < 100_000, "{} bytes", bytes(&deep));
            let last = &deep[MAX_DEPTH + 1];
            assert!(last.label.starts_with("a/a/") && last.label.ends_with('…'));
        }
        assert_eq!(named("//a")[1].label, "//a");
    }

    #[test]
    fn closed_groups_show_nothing_of_what_they_hold() {
        let rows = rows(&sample(), "", Language::English);
        let room = rows.iter().position(|r| r.label == "room").unwrap();
        let TreeLeaf::Group(key) = rows[room].leaf else {
            panic!("room is a group")
        };
        assert_eq!(visible(&rows, &HashSet::new()).len(), rows.len());
        let shown = visible(&rows, &HashSet::from([key]));
        assert!(shown.contains(&room));
        assert_eq!(shown.len(), rows.len() - 2);
        assert!(!shown.contains(&(room + 1)) && !shown.contains(&(room + 2)));
    }

    #[test]
    fn files_come_in_their_order_and_what_was_made_here_behind_them() {
        let mut document = sample();
        let source_file = |name: &str| crate::document::SourceFile {
            name: name.into(),
            path: name.into(),
            format: None,
            recipes: Vec::new(),
        };
        document.source_files = vec![source_file("z"), source_file("a")];
        for (item, source_file) in document.objects.iter_mut().zip([None, Some(1), Some(0)]) {
            Arc::make_mut(item).source_file = source_file;
        }
        let rows = rows(&document, "", Language::English);
        let top = rows.iter().filter(|r| r.parent.is_none());
        let labels: Vec<&str> = top.map(|r| r.label.as_str()).take(3).collect();
        assert_eq!(labels, ["z", "a", "Created here"]);
    }

    #[test]
    fn a_group_is_selected_where_all_in_it_is() {
        let rows = rows(&sample(), "", Language::English);
        let of = |ids: &[u64]| {
            let chosen = chosen(&rows, &ids.iter().map(|&id| ItemId(id)).collect());
            let labels = rows.iter().zip(chosen).filter(|(_, is)| *is);
            labels.map(|(r, _)| r.label.clone()).collect::<Vec<_>>()
        };
        assert_eq!(of(&[]), [""; 0]);
        assert_eq!(of(&[1]), ["floor"]);
        // The lamp is one of the lights, too.
        assert_eq!(of(&[1, 2]), ["room", "floor", "lamp", "room/lamp"]);
        assert_eq!(of(&[5]), ["bulb"]);
        assert_eq!(of(&[2, 5]), ["lamp", "Lights", "bulb", "room/lamp"]);
        let labels = of(&[1, 2, 3, 4]);
        assert_eq!(labels[0], "Created here");
        assert!(!labels.iter().any(|l| l == "Materials"), "{labels:?}");
    }

    #[test]
    fn a_group_is_hidden_where_all_in_it_is() {
        let mut document = sample();
        let shown = |document: &SceneDocument, label: &str| {
            let rows = rows(document, "", Language::English);
            rows.iter().find(|r| r.label == label).unwrap().shown
        };
        assert_eq!(shown(&document, "room"), Some(true));
        Arc::make_mut(&mut document.objects[0]).hidden = true;
        assert_eq!(shown(&document, "room"), Some(true));
        Arc::make_mut(&mut document.objects[1]).hidden = true;
        assert_eq!(shown(&document, "room"), Some(false));
        assert_eq!(shown(&document, "Created here"), Some(true));
        assert_eq!(shown(&document, "Cameras"), Some(true));
        assert_eq!(shown(&document, "Materials"), None);
    }
}
