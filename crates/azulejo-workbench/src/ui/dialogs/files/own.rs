//! Azulejo's own file dialog: the same on every desktop and without one.
//!
//! Everything can be done with the keyboard. The name field has the focus at first; from there arrows
//! and Enter reach the list, and Tab the rest.

use super::browser::{BrowserProblem, BrowserTask, FileBrowser};
use super::listing::ListOptions;
use super::places::{FolderPlace, Places};
use super::rows::FileRows;
use super::typed_path::{crumbs, stem_length};
use crate::ui::panel_context::PanelContext;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{
    Button, Context, Event, Id, Key, Label, Modal, Modifiers, Popup, Rect, ScrollArea, TextEdit,
    Ui, UiBuilder, Vec2, vec2,
};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a frame waits for a folder. Nearly all are read within this time, and then nothing
/// flickers.
const PATIENCE: Duration = Duration::from_millis(30);
/// The size of the dialog in a window that has enough space.
const SIZE: Vec2 = vec2(780.0, 520.0);
/// In a dialog that is narrower than this, places are in a menu.
const NARROW: f32 = 520.0;
/// The width of the places.
const PLACES_WIDTH: f32 = 140.0;

/// The dialog.
pub struct OwnFileDialog {
    browser: FileBrowser,
    rows: FileRows,
    places: Places,
    /// The name of the folder that would be created, while it is typed.
    new_folder: Option<String>,
    /// The field that gets the focus in the next frame, with the part of it to select.
    focus: Option<FocusedField>,
    /// The height of the part below the list, as in the last frame.
    below: f32,
    /// The width of the buttons beside the name, as in the last frame.
    buttons: f32,
}

/// A text field that gets the focus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FocusedField {
    /// The name, with its stem selected.
    NameStem,
    /// The name, with the cursor at its end.
    NameEnd,
    /// The new folder's name, all of it selected.
    NewFolder,
}

/// How the dialog was left.
pub enum DialogAnswer {
    /// Files were chosen.
    Chosen(Vec<PathBuf>),
    /// None was.
    Cancelled,
}

/// What the keys and buttons of a frame ask for.
#[derive(Clone, Copy, Debug, Default)]
struct DialogActions {
    accepts: bool,
    cancels: bool,
}

impl OwnFileDialog {
    /// Opens the dialog in `folder`, with a proposed name.
    pub fn new(
        task: BrowserTask,
        folder: PathBuf,
        name: String,
        options: ListOptions,
        cx: &PanelContext,
    ) -> OwnFileDialog {
        OwnFileDialog {
            browser: FileBrowser::new(task, folder, name, options),
            rows: FileRows::default(),
            places: Places::find(cx),
            new_folder: None,
            focus: Some(FocusedField::NameStem),
            below: 60.0,
            buttons: 140.0,
        }
    }

    /// What the list shows.
    pub fn options(&self) -> ListOptions {
        self.browser.options()
    }

    /// The displayed folder.
    pub fn folder(&self) -> &Path {
        &self.browser.folder
    }

    /// Draws the dialog; returns how it was left.
    pub fn show(&mut self, ui: &Ui, cx: &PanelContext, title: &str) -> Option<DialogAnswer> {
        let context = ui.ctx();
        if self.browser.poll(PATIENCE) {
            context.request_repaint();
        }
        let space = context.content_rect().size();
        let popup_is_open = Popup::is_any_open(context);
        let mut actions = DialogActions::default();
        let modal = Modal::new(Id::unique("files")).show(context, |ui| {
            let frame = ui.style().spacing.menu_margin.sum() + Vec2::splat(16.0);
            let size = SIZE.min(space - frame);
            ui.set_width(size.x);
            ui.set_height(size.y);
            let rect = Rect::from_min_size(ui.min_rect().min, size);
            if !popup_is_open {
                actions = self.keys(ui);
            }
            ui.scope_builder(UiBuilder::new().max_rect(rect), |ui| {
                self.parts(ui, cx, title, &mut actions);
            });
        });
        // A click beside the dialog is no answer: too much may have been typed.
        if modal.is_top_modal && actions.cancels {
            return Some(DialogAnswer::Cancelled);
        }
        if !actions.accepts {
            return None;
        }
        let chosen = self.browser.accept();
        self.focus = Some(match self.browser.problem {
            Some(_) => FocusedField::NameEnd,
            None => FocusedField::NameStem,
        });
        context.request_repaint();
        chosen.map(DialogAnswer::Chosen)
    }

    fn parts(&mut self, ui: &mut Ui, cx: &PanelContext, title: &str, actions: &mut DialogActions) {
        let is_narrow = ui.available_width() < NARROW;
        self.above(ui, cx, title, is_narrow);
        let rest = ui.available_rect_before_wrap();
        let spacing = ui.spacing().item_spacing.y;
        let middle = rest.bottom() - self.below - spacing;
        let mut list = Rect::from_min_max(rest.min, rest.max);
        list.max.y = middle.max(list.min.y);
        if !is_narrow {
            let mut places = list;
            places.max.x = places.min.x + PLACES_WIDTH;
            list.min.x = places.max.x + ui.spacing().item_spacing.x;
            ui.scope_builder(UiBuilder::new().max_rect(places), |ui| {
                ScrollArea::vertical()
                    .id_salt("places")
                    .auto_shrink(false)
                    .show(ui, |ui| self.places(ui, cx));
            });
        }
        ui.scope_builder(UiBuilder::new().max_rect(list), |ui| {
            if self.rows.show(ui, cx, &mut self.browser) {
                actions.accepts = true;
            }
        });
        let mut below = rest;
        below.min.y = middle + spacing;
        let shown = ui.scope_builder(UiBuilder::new().max_rect(below), |ui| {
            self.below(ui, cx, actions);
        });
        let height = shown.response.rect.height();
        if (height - self.below).abs() > 0.5 {
            self.below = height;
            ui.ctx().request_discard("the list has another height");
        }
    }

    /// The keys that act wherever the focus is, or in both the name field and the list.
    fn keys(&mut self, ui: &Ui) -> DialogActions {
        let focused = ui.memory(|m| m.focused());
        let in_name = focused == Some(name_id());
        let in_list = focused == Some(FileRows::id());
        let pressed = |modifiers, key| ui.input_mut(|i| i.consume_key(modifiers, key));
        let mut actions = DialogActions::default();
        if pressed(Modifiers::NONE, Key::Escape) {
            match self.new_folder.take() {
                Some(_) => self.focus = Some(FocusedField::NameEnd),
                None => actions.cancels = true,
            }
        }
        let to_parent = pressed(Modifiers::ALT, Key::ArrowUp)
            || ((in_list || (in_name && self.browser.name.is_empty())) && backspace(ui));
        if to_parent {
            self.browser.enter_parent();
        }
        if in_list {
            self.keys_of_list(ui);
        }
        if in_name || in_list || focused.is_none() {
            actions.accepts = pressed(Modifiers::NONE, Key::Enter);
            self.step(ui, in_list);
        }
        actions
    }

    /// Moves the cursor in the list. In the name field, Shift and the arrows select text.
    fn step(&mut self, ui: &Ui, in_list: bool) {
        let page = self.rows.page();
        let steps = [
            (Key::ArrowUp, -1),
            (Key::ArrowDown, 1),
            (Key::PageUp, -page),
            (Key::PageDown, page),
        ];
        let to_ends = [(Key::Home, isize::MIN), (Key::End, isize::MAX)];
        let to_ends = to_ends.into_iter().filter(|_| in_list);
        for (key, rows) in steps.into_iter().chain(to_ends) {
            // A slow frame has several presses of a key that is held.
            let count = |modifiers| ui.input_mut(|i| i.count_and_consume_key(modifiers, key));
            let extending = if in_list { count(Modifiers::SHIFT) } else { 0 };
            let moving = count(Modifiers::NONE);
            for press in 0..moving + extending {
                self.browser.step(rows, press >= moving);
                self.rows.follow_cursor();
            }
        }
    }

    /// Keys that only the list knows: Ctrl+A; and what is typed there goes to the name field.
    fn keys_of_list(&mut self, ui: &Ui) {
        if ui.input_mut(|i| i.consume_key(Modifiers::COMMAND, Key::A)) {
            self.browser.select_all();
        }
        let typed = ui.input_mut(|i| {
            let mut typed = String::new();
            // The name field is not to type it once more.
            i.events.retain(|event| match event {
                Event::Text(text) => {
                    typed.push_str(text);
                    false
                }
                _ => true,
            });
            typed
        });
        if !typed.trim().is_empty() {
            self.browser.name = typed;
            self.browser.typed();
            self.rows.follow_cursor();
            self.focus = Some(FocusedField::NameEnd);
        }
    }

    /// The title, the buttons and the path.
    fn above(&mut self, ui: &mut Ui, cx: &PanelContext, title: &str, is_narrow: bool) {
        ui.add(Label::new(egui::RichText::new(title).heading()).truncate());
        ui.horizontal(|ui| {
            let has_parent = self.browser.folder.parent().is_some();
            let parent = ui
                .add_enabled(has_parent, Button::new("⬆"))
                .on_hover_text(format!("{} (Alt+↑)", cx.tr("Parent folder")));
            name(&parent, cx.tr("Parent folder"));
            if parent.clicked() {
                self.browser.enter_parent();
            }
            let refresh = ui.button("⟳").on_hover_text(cx.tr("Refresh"));
            name(&refresh, cx.tr("Refresh"));
            if refresh.clicked() {
                self.browser.refresh();
            }
            if ui.button(cx.tr("New folder")).clicked() {
                self.new_folder = Some(cx.tr("New folder").to_owned());
                self.focus = Some(FocusedField::NewFolder);
            }
            if is_narrow {
                ui.menu_button(cx.tr("Places"), |ui| self.places(ui, cx));
            }
            ScrollArea::horizontal()
                .id_salt("path")
                .stick_to_right(true)
                .show(ui, |ui| self.path(ui));
        });
        self.new_folder(ui, cx);
    }

    /// The path, each folder of which can be gone to.
    fn path(&mut self, ui: &mut Ui) {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (k, (label, folder)) in crumbs(&self.browser.folder).into_iter().enumerate() {
            if k > 1 {
                ui.weak("/");
            }
            let is_here = folder == self.browser.folder;
            if ui.selectable_label(is_here, label).clicked() && !is_here {
                self.browser.enter(folder);
            }
        }
    }

    /// The field for the name of a new folder, while there is one.
    fn new_folder(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let Some(mut folder) = self.new_folder.take() else {
            return;
        };
        let (mut creates, mut cancels) = (false, false);
        ui.horizontal(|ui| {
            let label = ui.label(format!("{}:", cx.tr("New folder")));
            // The Enter that pressed the button is not meant for the field.
            let is_focused = ui.memory(|m| m.has_focus(new_folder_id()));
            let takes_focus = self.focus == Some(FocusedField::NewFolder);
            if takes_focus {
                focus(ui.ctx(), new_folder_id(), 0, folder.chars().count());
            }
            creates = is_focused && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Enter));
            let field = TextEdit::singleline(&mut folder).id(new_folder_id());
            let field = ui.add(field.desired_width(180.0)).labelled_by(label.id);
            if takes_focus && field.has_focus() {
                self.focus = None;
            }
            creates |= ui.button(cx.tr("Create")).clicked();
            cancels = ui.button(cx.tr("Cancel")).clicked();
        });
        if creates && !folder.trim().is_empty() {
            self.browser.create_folder(&folder);
            creates = self.browser.problem.is_none();
        } else {
            creates = false;
        }
        if creates || cancels {
            self.focus = Some(FocusedField::NameStem);
        } else {
            self.new_folder = Some(folder);
        }
    }

    /// The places.
    fn places(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let mut gone_to = None;
        ui.with_layout(egui::Layout::top_down_justified(egui::Align::Min), |ui| {
            for place in &self.places.standard {
                place_button(ui, place, &self.browser.folder, &mut gone_to);
            }
            if !self.places.recent.is_empty() {
                ui.add_space(4.0);
                ui.weak(cx.tr("Recent"));
            }
            for place in &self.places.recent {
                place_button(ui, place, &self.browser.folder, &mut gone_to);
            }
        });
        if let Some(folder) = gone_to {
            self.browser.enter(folder);
            ui.close();
        }
    }

    /// The name, the buttons, what is listed, and what is wrong.
    fn below(&mut self, ui: &mut Ui, cx: &PanelContext, actions: &mut DialogActions) {
        if let Some(problem) = &self.browser.problem {
            let color = ui.visuals().error_fg_color;
            let text = problem_text(problem, cx);
            ui.add(Label::new(egui::RichText::new(text).color(color)).wrap());
        }
        ui.horizontal(|ui| {
            let label = ui.label(cx.tr("File:"));
            let takes_focus = self.take_focus(ui.ctx());
            let width = ui.available_width() - self.buttons - ui.spacing().item_spacing.x;
            let field = TextEdit::singleline(&mut self.browser.name).id(name_id());
            let field = ui.add(field.desired_width(width.max(40.0)));
            // In its first frame a dialog only measures itself: there is nothing to focus yet.
            if takes_focus && field.has_focus() {
                self.focus = None;
            }
            if field.labelled_by(label.id).changed() {
                self.browser.typed();
                self.rows.follow_cursor();
            }
            let begin = ui.next_widget_position().x;
            let accept = if self.browser.task.saves {
                cx.tr("Save")
            } else {
                cx.tr("Open")
            };
            let button = Button::new(accept);
            let is_ready = self.browser.is_ready();
            actions.accepts |= ui.add_enabled(is_ready, button).clicked();
            actions.cancels |= ui.button(cx.tr("Cancel")).clicked();
            let width = ui.min_rect().right() - begin;
            if (width - self.buttons).abs() > 0.5 {
                self.buttons = width;
                ui.ctx().request_discard("the buttons have another width");
            }
        });
        ui.horizontal_wrapped(|ui| {
            let mut options = self.browser.options();
            if !self.browser.task.extensions.is_empty() {
                ui.checkbox(&mut options.shows_all, cx.tr("All files"));
            }
            ui.checkbox(&mut options.shows_hidden, cx.tr("Show hidden files"));
            self.browser.set_options(options);
            if let Some(count) = self.browser.many_selected() {
                ui.label(format!("{count} {}", cx.tr("files selected")));
            }
        });
    }

    /// Gives the name field the focus, if it is to get it; returns whether it is.
    fn take_focus(&self, context: &Context) -> bool {
        let name = &self.browser.name;
        let end = name.chars().count();
        match self.focus {
            Some(FocusedField::NameStem) => focus(context, name_id(), 0, stem_length(name)),
            Some(FocusedField::NameEnd) => focus(context, name_id(), end, end),
            Some(FocusedField::NewFolder) | None => return false,
        }
        true
    }
}

fn name_id() -> Id {
    Id::unique("file name")
}

fn new_folder_id() -> Id {
    Id::unique("new folder")
}

/// Gives a text field the focus and selects a part of its text.
fn focus(context: &Context, field: Id, from: usize, to: usize) {
    let mut state = TextEditState::load(context, field).unwrap_or_default();
    let range = CCursorRange::two(CCursor::new(from), CCursor::new(to));
    state.cursor.set_char_range(Some(range));
    state.store(context, field);
    context.memory_mut(|m| m.request_focus(field));
}

/// Whether Backspace is pressed anew. Who holds it to delete a name does not mean the parent folder.
fn backspace(ui: &Ui) -> bool {
    let is_held = |e: &Event| {
        let Event::Key { key, repeat, .. } = e else {
            return false;
        };
        *key == Key::Backspace && *repeat
    };
    !ui.input(|i| i.events.iter().any(is_held))
        && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Backspace))
}

/// Names a button that has only a sign, for screen readers.
fn name(button: &egui::Response, text: &str) {
    let (kind, is_enabled) = (egui::Role::Button, button.enabled());
    button.widget_info(|| egui::WidgetInfo::labeled(kind, is_enabled, text));
}

fn place_button(ui: &mut Ui, place: &FolderPlace, here: &Path, gone_to: &mut Option<PathBuf>) {
    let button = Button::selectable(place.folder == here, &place.label).truncate();
    let button = ui
        .add(button)
        .on_hover_text(place.folder.display().to_string());
    if button.clicked() {
        *gone_to = Some(place.folder.clone());
    }
}

fn problem_text(problem: &BrowserProblem, cx: &PanelContext) -> String {
    match problem {
        BrowserProblem::NoFile(path) => {
            format!("{} {}", cx.tr("There is no such file:"), path.display())
        }
        BrowserProblem::NoFolder(path) => {
            format!("{} {}", cx.tr("There is no such folder:"), path.display())
        }
        BrowserProblem::NotCreated(why) => {
            format!("{} {why}", cx.tr("The folder could not be created:"))
        }
    }
}
