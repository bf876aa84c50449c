//! The tree: files, their groups and objects, lights, cameras, materials.

use super::desk::Desk;
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{Edit, Id};
use crate::words::Language;
use azulejo::scene::MaterialId;
use egui::{Align, Layout, RichText, ScrollArea, Sense, Ui};
use std::collections::{BTreeMap, HashSet};

/// What the tree remembers between frames.
#[derive(Default)]
pub struct Tree {
    /// Groups that are closed, by their paths.
    closed: HashSet<String>,
    /// Only what has this in its name is shown.
    filter: String,
    /// What is being renamed, and its name so far.
    renaming: Option<(Id, String)>,
    /// The rows, of which document and filter.
    rows: Vec<Row>,
    made_of: Option<(u64, String, Language)>,
    /// What is selected.
    selected: HashSet<Id>,
    /// What the rows should be scrolled to.
    reveal: Option<Id>,
    last_selected: Option<Id>,
}

/// One line of the tree.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    depth: usize,
    label: String,
    leaf: Leaf,
    /// The paths of the groups that hold it, outermost first.
    within: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum Leaf {
    /// A group: its path, and the objects in it.
    Group(String, Vec<Id>),
    Item(Id),
    Light(Id),
    Camera(Id),
    Material(MaterialId),
}

/// The tree while it is built: groups by name, in the order of names, then things in their own.
#[derive(Default)]
struct Node {
    groups: BTreeMap<String, Node>,
    things: Vec<(String, Leaf)>,
}

impl Node {
    /// Puts a thing where its path leads.
    fn insert(&mut self, path: &str, leaf: Leaf) {
        match path.split_once('/') {
            Some((group, rest)) if !group.is_empty() && !rest.is_empty() => {
                let group = self.groups.entry(group.to_owned()).or_default();
                group.insert(rest, leaf);
            }
            _ => self.things.push((path.to_owned(), leaf)),
        }
    }

    fn ids(&self) -> Vec<Id> {
        let inner = self.groups.values().flat_map(Node::ids);
        let own = self.things.iter().filter_map(|(_, leaf)| match leaf {
            Leaf::Item(id) | Leaf::Light(id) | Leaf::Camera(id) => Some(*id),
            _ => None,
        });
        inner.chain(own).collect()
    }

    fn rows(&self, path: &str, within: &[String], rows: &mut Vec<Row>) {
        for (name, node) in &self.groups {
            let path = format!("{path}/{name}");
            rows.push(Row {
                depth: within.len(),
                label: name.clone(),
                leaf: Leaf::Group(path.clone(), node.ids()),
                within: within.to_vec(),
            });
            let inner: Vec<String> = within.iter().cloned().chain([path.clone()]).collect();
            node.rows(&path, &inner, rows);
        }
        for (name, leaf) in &self.things {
            rows.push(Row {
                depth: within.len(),
                label: name.clone(),
                leaf: leaf.clone(),
                within: within.to_vec(),
            });
        }
    }
}

/// All rows of a document, groups open, that match a filter.
fn rows(app: &App, filter: &str, say: impl Fn(&'static str) -> &'static str) -> Vec<Row> {
    let filter = filter.to_lowercase();
    let matches = |name: &str| filter.is_empty() || name.to_lowercase().contains(&filter);
    let document = &app.document;
    let mut root = Node::default();
    for item in document.items.iter().filter(|i| matches(&i.name)) {
        let branch = item.branch.and_then(|b| document.branches.get(b));
        let top = branch.map_or_else(|| say("made here").to_owned(), |b| b.name.clone());
        let name = inside(&item.name, &top);
        let group = root.groups.entry(top).or_default();
        group.insert(name, Leaf::Item(item.id));
    }
    let mut list = |title: &'static str, things: Vec<(String, Leaf)>| {
        if !things.is_empty() {
            // Behind the files, whatever their names.
            let group = root.groups.entry(format!("\u{10ffff}{}", say(title)));
            group.or_default().things = things;
        }
    };
    let lights = document.lights.iter().filter(|l| matches(&l.light.name));
    list(
        "Lights",
        lights
            .map(|l| (l.light.name.clone(), Leaf::Light(l.id)))
            .collect(),
    );
    let cameras = document.cameras.iter().filter(|c| matches(&c.camera.name));
    list(
        "Cameras",
        cameras
            .map(|c| (c.camera.name.clone(), Leaf::Camera(c.id)))
            .collect(),
    );
    let materials = document.materials.iter().enumerate();
    let materials = materials.filter(|(_, m)| matches(&m.name));
    list(
        "Materials",
        materials
            .map(|(k, m)| (m.name.clone(), Leaf::Material(k as MaterialId)))
            .collect(),
    );
    let mut rows = Vec::new();
    root.rows("", &[], &mut rows);
    for row in &mut rows {
        if let Some(label) = row.label.strip_prefix('\u{10ffff}') {
            row.label = label.to_owned();
        }
    }
    rows
}

/// A name without the branch in front of it, which stands above it already.
fn inside<'a>(name: &'a str, branch: &str) -> &'a str {
    let rest = name.strip_prefix(branch).and_then(|r| r.strip_prefix('/'));
    rest.unwrap_or(name)
}

impl Tree {
    /// Renames what is selected, in its row.
    pub fn begin_rename(&mut self, app: &App) {
        if let [id] = app.selection.ids[..]
            && let Some(name) = app.document.name(id)
        {
            self.renaming = Some((id, name.to_owned()));
            self.reveal = Some(id);
        }
    }

    /// Draws the tree.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let hint = desk.say("Search");
        ui.add(
            egui::TextEdit::singleline(&mut self.filter)
                .hint_text(hint)
                .desired_width(f32::INFINITY),
        );
        self.refresh(desk);
        self.selected = desk.app.selection.ids.iter().copied().collect();
        self.follow_selection(desk.app);
        let visible: Vec<usize> = (0..self.rows.len())
            .filter(|&k| {
                let row = &self.rows[k];
                !row.within.iter().any(|path| self.closed.contains(path))
            })
            .collect();
        if visible.is_empty() {
            let text = desk.say("Drop files here, or open them (Ctrl+O).");
            ui.weak(text);
            return;
        }
        let height = ui.spacing().interact_size.y;
        let target = self.reveal.take().and_then(|id| {
            let is_it = |&k: &usize| self.rows[k].leaf.id() == Some(id);
            visible.iter().position(is_it)
        });
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if let Some(at) = target {
            let spacing = ui.spacing().item_spacing.y;
            let offset = at as f32 * (height + spacing) - 0.4 * ui.available_height();
            area = area.vertical_scroll_offset(offset.max(0.0));
        }
        area.show_rows(ui, height, visible.len(), |ui, range| {
            for at in range {
                self.row(ui, desk, visible[at]);
            }
        });
    }

    fn refresh(&mut self, desk: &Desk) {
        let key = (desk.app.revision(), self.filter.clone(), desk.language);
        if self.made_of.as_ref() != Some(&key) {
            self.rows = rows(desk.app, &self.filter, |text| desk.say(text));
            self.made_of = Some(key);
        }
    }

    /// What was picked in the viewport is shown here too.
    fn follow_selection(&mut self, app: &App) {
        let last = app.selection.ids.last().copied();
        if last == self.last_selected {
            return;
        }
        self.last_selected = last;
        let Some(id) = last else { return };
        if let Some(row) = self.rows.iter().find(|r| r.leaf.id() == Some(id)) {
            row.within.iter().for_each(|path| {
                self.closed.remove(path);
            });
            self.reveal = Some(id);
        }
    }

    fn row(&mut self, ui: &mut Ui, desk: &mut Desk, at: usize) {
        let row = self.rows[at].clone();
        ui.push_id(at, |ui| {
            ui.horizontal(|ui| {
                ui.add_space(14.0 * row.depth as f32);
                match &row.leaf {
                    Leaf::Group(path, ids) => self.group(ui, desk, &row.label, path, ids),
                    Leaf::Material(material) => self.material(ui, desk, &row.label, *material),
                    Leaf::Item(id) | Leaf::Light(id) | Leaf::Camera(id) => {
                        self.thing(ui, desk, &row, *id);
                    }
                }
            });
        });
    }

    fn group(&mut self, ui: &mut Ui, desk: &mut Desk, label: &str, path: &str, ids: &[Id]) {
        let is_open = !self.closed.contains(path);
        let arrow = if is_open { "⏷" } else { "⏵" };
        let name = format!("{} {label}", if is_open { "−" } else { "+" });
        let toggle = ui.add(egui::Button::new(arrow).small().frame(false));
        toggle.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::DisclosureTriangle, true, is_open, &name)
        });
        if toggle.clicked() {
            match is_open {
                true => self.closed.insert(path.to_owned()),
                false => self.closed.remove(path),
            };
        }
        let all = !ids.is_empty() && ids.iter().all(|id| self.selected.contains(id));
        let text = RichText::new(label).strong();
        if ui.selectable_label(all, text).clicked() && !ids.is_empty() {
            desk.wish(Command::Select(Selection {
                ids: ids.to_vec(),
                ..Selection::default()
            }));
        }
        let items: Vec<Id> = (ids.iter().copied())
            .filter(|&id| desk.app.document.item(id).is_some())
            .collect();
        if !items.is_empty() {
            self.eye(ui, desk, label, &items);
        }
    }

    /// Shows and hides.
    fn eye(&self, ui: &mut Ui, desk: &mut Desk, name: &str, ids: &[Id]) {
        let shown = ids.iter().any(|&id| {
            let item = desk.app.document.item(id);
            item.is_some_and(|i| !i.hidden)
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let sign = if shown { "👁" } else { "–" };
            let button = ui.add(egui::Button::new(sign).small().frame(false));
            button.widget_info(|| {
                let does = if shown {
                    desk.say("Hide")
                } else {
                    desk.say("Show")
                };
                egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{does}: {name}"))
            });
            let what = match shown {
                true => desk.say("Hide: out of sight, but it casts and receives light as before"),
                false => desk.say("Show"),
            };
            if button.on_hover_text(what).clicked() {
                desk.edit(Edit::Hide(ids.to_vec(), shown));
            }
        });
    }

    fn material(&self, ui: &mut Ui, desk: &mut Desk, label: &str, material: MaterialId) {
        let known = desk.app.document.materials.get(material as usize);
        if let Some(known) = known {
            let color = super::paint::swatch(known);
            let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, color);
        }
        let is_selected = desk.app.selection.material == Some(material);
        let label = match label {
            "" => desk.say("without name"),
            other => other,
        };
        if ui.selectable_label(is_selected, label).clicked() {
            let mut selection = desk.app.selection.clone();
            selection.material = Some(material);
            desk.wish(Command::Select(selection));
        }
    }

    fn thing(&mut self, ui: &mut Ui, desk: &mut Desk, row: &Row, id: Id) {
        if let Some((renamed, name)) = &mut self.renaming
            && *renamed == id
        {
            let field = egui::TextEdit::singleline(name).hint_text(desk.say("Name"));
            let response = ui.add(field);
            response.request_focus();
            let enter = ui.input(|i| i.key_pressed(egui::Key::Enter));
            let escape = ui.input(|i| i.key_pressed(egui::Key::Escape));
            if enter || escape || response.clicked_elsewhere() {
                if !escape {
                    desk.edit(Edit::Rename(id, name.clone()));
                }
                self.renaming = None;
            }
            return;
        }
        let sign = match row.leaf {
            Leaf::Light(_) => "💡 ",
            Leaf::Camera(_) => "📷 ",
            _ => "",
        };
        let is_selected = self.selected.contains(&id);
        let label = match row.label.as_str() {
            "" => format!("{sign}{}", desk.say("without name")),
            name => format!("{sign}{name}"),
        };
        let response = ui.selectable_label(is_selected, label);
        if response.double_clicked() {
            match desk.app.document.viewpoint(id) {
                Some(view) => {
                    let mut look = desk.app.view.clone();
                    look.camera = view.camera.clone();
                    desk.wish(Command::Look(Box::new(look)));
                }
                None => self.begin_rename_of(desk.app, id),
            }
        } else if response.clicked() {
            desk.select(id, ui.input(|i| i.modifiers.command || i.modifiers.shift));
        }
        if desk.app.document.item(id).is_some() {
            self.eye(ui, desk, &row.label, &[id]);
        }
    }

    fn begin_rename_of(&mut self, app: &App, id: Id) {
        let name = app.document.name(id).unwrap_or_default();
        self.renaming = Some((id, name.to_owned()));
    }
}

impl Leaf {
    fn id(&self) -> Option<Id> {
        match self {
            Leaf::Item(id) | Leaf::Light(id) | Leaf::Camera(id) => Some(*id),
            Leaf::Group(..) | Leaf::Material(_) => None,
        }
    }
}
