//! The dialog where the desktop has none: one field for a path.

use super::request::FileAnswer;
use super::typed_path::{PathProblem, check, stem_length};
use crate::ui::panel_context::PanelContext;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Button, Context, Id, Key, Label, Modal, Modifiers, RichText, TextEdit, Ui};
use std::ops::Range;
use std::path::PathBuf;

/// Width of the dialog in points, in a window that has the space.
const WIDTH: f32 = 520.0;
/// Points that a window leaves beside it.
const MARGIN: f32 = 48.0;

/// A dialog with one field, in which a path is typed.
pub struct PathDialog {
    /// Whether a file is written, which need not exist.
    saves: bool,
    /// The folder where relative paths begin.
    folder: PathBuf,
    /// The text of the field.
    text: String,
    /// Why the text is not a file that can be opened or written.
    problem: Option<PathProblem>,
    /// The characters to select once the field has the focus, which it is to get.
    selects: Option<Range<usize>>,
}

impl PathDialog {
    /// A dialog with a proposed name, which is selected without its extension.
    pub fn new(saves: bool, folder: PathBuf, name: String) -> PathDialog {
        PathDialog {
            saves,
            folder,
            problem: None,
            selects: Some(0..stem_length(&name)),
            text: name,
        }
    }

    /// Draws the dialog; returns how it was left.
    pub fn show(&mut self, ui: &Ui, cx: &PanelContext, title: &str) -> Option<FileAnswer> {
        let (mut accepts, mut cancels) = (false, false);
        let width = ui.ctx().content_rect().width() - MARGIN;
        let modal = Modal::new(Id::unique("path dialog")).show(ui.ctx(), |ui| {
            ui.set_width(width.min(WIDTH));
            ui.heading(title);
            let folder = RichText::new(self.folder.display().to_string());
            ui.add(Label::new(folder.weak()).truncate());
            accepts = takes_enter(ui);
            self.field(ui, cx);
            ui.horizontal(|ui| {
                let accept = cx.tr(if self.saves { "Save" } else { "Open" });
                let is_ready = !self.text.trim().is_empty();
                accepts |= ui.add_enabled(is_ready, Button::new(accept)).clicked();
                cancels = ui.button(cx.tr("Cancel")).clicked();
            });
        });
        // A click outside the dialog is not an answer: too much may have been typed.
        cancels |= modal.is_top_modal && ui.input(|i| i.key_pressed(Key::Escape));
        if cancels {
            return Some(FileAnswer::Cancelled);
        }
        (accepts && !self.text.trim().is_empty()).then(|| self.accept(ui.ctx()))?
    }

    /// The file that is meant by the text, or a reason why there is none.
    fn accept(&mut self, context: &Context) -> Option<FileAnswer> {
        match check(self.saves, &self.folder, &self.text) {
            Ok(path) => Some(FileAnswer::Chosen(vec![path])),
            Err(problem) => {
                let end = self.text.chars().count();
                (self.problem, self.selects) = (Some(problem), Some(end..end));
                context.request_repaint();
                None
            }
        }
    }

    /// The field, and below it what is wrong with its text.
    fn field(&mut self, ui: &mut Ui, cx: &PanelContext) {
        let label = ui.label(cx.tr("File:"));
        if let Some(selects) = self.selects.clone() {
            focus(ui.ctx(), selects);
        }
        let field = TextEdit::singleline(&mut self.text).id(field_id());
        let field = ui.add(field.desired_width(f32::INFINITY));
        // In its first frame a dialog only measures itself: there is nothing to focus yet.
        if field.has_focus() {
            self.selects = None;
        }
        if field.labelled_by(label.id).changed() {
            self.problem = None;
        }
        if let Some(problem) = &self.problem {
            let text = RichText::new(problem_text(problem, cx));
            let color = ui.visuals().error_fg_color;
            ui.add(Label::new(text.color(color)).wrap());
        }
    }
}

fn field_id() -> Id {
    Id::unique("typed path")
}

/// Gives the field the focus and selects a part of its text.
fn focus(context: &Context, characters: Range<usize>) {
    let mut state = TextEditState::load(context, field_id()).unwrap_or_default();
    let (from, to) = (CCursor::new(characters.start), CCursor::new(characters.end));
    let range = CCursorRange::two(from, to);
    state.cursor.set_char_range(Some(range));
    state.store(context, field_id());
    context.memory_mut(|m| m.request_focus(field_id()));
}

/// Whether Enter is pressed, and not for a button. The field, which would give up its focus, does not
/// get it.
fn takes_enter(ui: &Ui) -> bool {
    let focused = ui.memory(|m| m.focused());
    focused.is_none_or(|id| id == field_id())
        && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Enter))
}

fn problem_text(problem: &PathProblem, cx: &PanelContext) -> String {
    let (text, path) = match problem {
        PathProblem::NoFile(path) => (cx.tr("There is no such file:"), path),
        PathProblem::NoFolder(path) => (cx.tr("There is no such folder:"), path),
        PathProblem::IsFolder(path) => (cx.tr("This is a folder:"), path),
    };
    format!("{text} {}", path.display())
}
