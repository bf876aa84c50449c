//! The tree of the scene: files with their groups and objects, lights, cameras, materials and
//! definitions.

mod definitions;
mod list;
mod rows;

use super::panel_context::PanelContext;
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId};
use azulejo::scene::MaterialId;
use egui::{Align, Layout, RichText, ScrollArea, Sense, Ui};
use list::TreeList;
use rows::{TreeLeaf, TreeRow};

/// The state of the tree between frames.
#[derive(Default)]
pub struct SceneTree {
    /// Only rows whose name contains this are displayed.
    filter: String,
    list: TreeList,
    rename: RenameField,
    /// The item to scroll to.
    reveal: Option<ItemId>,
    last_selected: Option<ItemId>,
    /// Whether a row was clicked in the last frame.
    was_clicked: bool,
}

/// The item being renamed, and its name so far.
#[derive(Default)]
struct RenameField(Option<(ItemId, String)>);

impl RenameField {
    fn begin(&mut self, app: &App, id: ItemId) {
        self.0 = app.document.name(id).map(|name| (id, name.to_owned()));
    }
}

impl SceneTree {
    /// Renames the selection in its row.
    pub fn begin_rename(&mut self, app: &App) {
        if let [id] = app.selection.ids[..] {
            self.rename.begin(app, id);
            self.reveal = Some(id);
        }
    }

    /// Draws the tree.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let hint = cx.tr("Search");
        ui.add(
            egui::TextEdit::singleline(&mut self.filter)
                .hint_text(hint)
                .desired_width(f32::INFINITY),
        );
        // Follow the document and the filter; what was selected elsewhere is scrolled to.
        self.list.follow(cx.app, &self.filter, cx.language);
        self.follow_selection(cx.app);
        let target = self.reveal.take().and_then(|id| self.list.reveal(id));
        let visible = self.list.visible();
        if visible.is_empty() {
            let text = if cx.app.document.is_empty() {
                cx.tr("Drop files here, or open them (Ctrl+O).")
            } else {
                cx.tr("No name contains this text.")
            };
            ui.weak(text);
            return;
        }
        // Only rows in view are laid out, so the target is reached by its offset, a little above the middle.
        let height = ui.spacing().interact_size.y;
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if let Some(at) = target {
            let spacing = ui.spacing().item_spacing.y;
            let offset = at as f32 * (height + spacing) - 0.4 * ui.available_height();
            area = area.vertical_scroll_offset(offset.max(0.0));
        }
        // The rows borrow the list: a group opens or closes after they are drawn.
        let mut toggled = None;
        let rename = &mut self.rename;
        let before = cx.commands.len();
        area.show_rows(ui, height, visible.len(), |ui, range| {
            for &at in &visible[range] {
                let clicked = row(ui, cx, &self.list, at, rename);
                toggled = toggled.or(clicked);
            }
        });
        // A selection made here must not scroll the tree.
        let mut sent = cx.commands[before..].iter();
        self.was_clicked = sent.any(|c| matches!(c, Command::Select(_)));
        if let Some(group) = toggled {
            self.list.toggle(group);
        }
    }

    /// Scrolls to what was picked in the viewport.
    fn follow_selection(&mut self, app: &App) {
        let last = app.selection.ids.last().copied();
        if last != self.last_selected {
            self.last_selected = last;
            // A row that was clicked stays under the pointer.
            if !std::mem::take(&mut self.was_clicked) {
                self.reveal = last.or(self.reveal);
            }
        }
    }
}

/// Draws one row; returns the group to expand or collapse.
fn row(
    ui: &mut Ui,
    cx: &mut PanelContext,
    list: &TreeList,
    at: usize,
    rename: &mut RenameField,
) -> Option<u64> {
    let row = list.row(at);
    let draw = |ui: &mut Ui| {
        ui.add_space(14.0 * row.depth as f32);
        match &row.leaf {
            TreeLeaf::Group(key) => return group(ui, cx, list, at, *key),
            TreeLeaf::Material(id) => material(ui, cx, &row.label, *id),
            TreeLeaf::Definition(users) => definition(ui, cx, &row.label, users),
            TreeLeaf::Item(id) | TreeLeaf::Light(id) | TreeLeaf::Camera(id) => {
                entry(ui, cx, row, *id, list.is_chosen(at), rename);
            }
        }
        None
    };
    ui.push_id(at, |ui| ui.horizontal(draw).inner).inner
}

fn group(ui: &mut Ui, cx: &mut PanelContext, list: &TreeList, at: usize, key: u64) -> Option<u64> {
    let row = list.row(at);
    let (label, is_open) = (&row.label, list.is_open(key));
    let arrow = if is_open { "⏷" } else { "⏵" };
    let name = format!("{} {label}", if is_open { "−" } else { "+" });
    let toggle = ui.add(egui::Button::new(arrow).small().frame(false));
    toggle.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::DisclosureTriangle, true, is_open, &name)
    });
    let text = RichText::new(label).strong();
    if name_button(ui, list.is_chosen(at), text, row.shown.is_some()).clicked() {
        let ids = list.ids(at);
        if !ids.is_empty() {
            cx.send(Command::Select(Selection {
                ids,
                ..Selection::default()
            }));
        }
    }
    if let Some(shown) = row.shown
        && eye(ui, cx, label, shown)
    {
        cx.edit(Edit::Hide(list.ids(at), shown));
    }
    toggle.clicked().then_some(key)
}

/// The name of a row. A long one is cut off before the visibility button, where there is one.
fn name_button(
    ui: &mut Ui,
    is_chosen: bool,
    text: impl Into<egui::WidgetText>,
    has_eye: bool,
) -> egui::Response {
    let room = ui.available_width() - if has_eye { 26.0 } else { 0.0 };
    let name = egui::Button::selectable(is_chosen, text.into()).truncate();
    ui.scope(|ui| {
        ui.set_max_width(room.max(20.0));
        ui.add(name)
    })
    .inner
}

/// The visibility button; returns whether it was clicked.
fn eye(ui: &mut Ui, cx: &PanelContext, name: &str, shown: bool) -> bool {
    let draw = |ui: &mut Ui| {
        let sign = if shown { "👁" } else { "–" };
        let button = ui.add(egui::Button::new(sign).small().frame(false));
        button.widget_info(|| {
            let does = if shown { cx.tr("Hide") } else { cx.tr("Show") };
            egui::WidgetInfo::labeled(egui::Role::Button, true, format!("{does}: {name}"))
        });
        let what = if shown {
            cx.tr("Hide in the viewport only: it still casts and receives light")
        } else {
            cx.tr("Show")
        };
        button.on_hover_text(what).clicked()
    };
    let place = Layout::right_to_left(Align::Center);
    ui.with_layout(place, draw).inner
}

fn material(ui: &mut Ui, cx: &mut PanelContext, label: &str, material: MaterialId) {
    let known = cx.app.document.materials.get(material as usize);
    if let Some(known) = known {
        let color = super::colors::swatch(known);
        let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
        ui.painter().rect_filled(rect, 2.0, color);
    }
    let is_selected = cx.app.selection.material == Some(material);
    let label = match label {
        "" => cx.tr("Unnamed"),
        other => other,
    };
    let response = ui.selectable_label(is_selected, label);
    response.context_menu(|ui| super::material_actions::buttons(ui, cx, material));
    if response.clicked() {
        let mut selection = cx.app.selection.clone();
        selection.material = Some(material);
        cx.send(Command::Select(selection));
    }
}

fn definition(ui: &mut Ui, cx: &mut PanelContext, label: &str, users: &[ItemId]) {
    let response = ui.selectable_label(false, label);
    let what = cx.tr("Click to select the objects that share it");
    if response.on_hover_text(what).clicked() && !users.is_empty() {
        cx.send(Command::Select(Selection {
            ids: users.to_vec(),
            ..Selection::default()
        }));
    }
}

fn entry(
    ui: &mut Ui,
    cx: &mut PanelContext,
    row: &TreeRow,
    id: ItemId,
    is_chosen: bool,
    rename: &mut RenameField,
) {
    if let Some((renamed, name)) = &mut rename.0
        && *renamed == id
    {
        if name_field(ui, cx, id, name) {
            rename.0 = None;
        }
        return;
    }
    let sign = match row.leaf {
        TreeLeaf::Light(_) => "💡 ",
        TreeLeaf::Camera(_) => "📷 ",
        _ => "",
    };
    let label = match row.label.as_str() {
        "" => format!("{sign}{}", cx.tr("Unnamed")),
        name => format!("{sign}{name}"),
    };
    let response = name_button(ui, is_chosen, label, row.shown.is_some());
    if response.double_clicked() {
        match cx.app.document.camera(id) {
            Some(view) => {
                let mut look = cx.app.view.clone();
                look.camera = view.camera.clone();
                cx.send(Command::SetView(Box::new(look)));
            }
            None => rename.begin(cx.app, id),
        }
    } else if response.clicked() {
        cx.select(id, ui.input(|i| i.modifiers.command || i.modifiers.shift));
    }
    if let Some(shown) = row.shown
        && eye(ui, cx, &row.label, shown)
    {
        cx.edit(Edit::Hide(vec![id], shown));
    }
}

/// The name field of a row; returns whether editing has ended.
fn name_field(ui: &mut Ui, cx: &mut PanelContext, id: ItemId, name: &mut String) -> bool {
    let field = egui::TextEdit::singleline(name).hint_text(cx.tr("Name"));
    let response = ui.add(field);
    response.request_focus();
    let enter = ui.input(|i| i.key_pressed(egui::Key::Enter));
    let escape = ui.input(|i| i.key_pressed(egui::Key::Escape));
    let is_done = enter || escape || response.clicked_elsewhere();
    if is_done && !escape {
        cx.edit(Edit::Rename(id, name.clone()));
    }
    is_done
}
