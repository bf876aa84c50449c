//! The context passed to every panel of the window.

use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId};
use crate::words::Language;

/// What every panel gets: the state, and a place for its commands.
pub struct PanelContext<'a> {
    /// The state to display.
    pub app: &'a App,
    /// The language of the window.
    pub language: Language,
    /// The current mouse gesture, if there is one: its edits are one undo step.
    pub gesture: Option<u64>,
    /// Whether a modal dialog is open and takes the keyboard.
    pub is_covered: bool,
    /// The commands issued in this frame.
    pub commands: Vec<Command>,
}

impl PanelContext<'_> {
    /// Translates `english` to the language of the window.
    pub fn tr(&self, english: &'static str) -> &'static str {
        self.language.tr(english)
    }

    /// Translates the stage of a job; unknown stages are returned as they are.
    pub fn stage<'s>(&self, stage: &'s str) -> &'s str {
        match stage {
            "direct light" => self.tr("direct light"),
            "form factors" => self.tr("form factors"),
            "formulas" => self.tr("formulas"),
            "merging" => self.tr("merging"),
            "scaling rows" | "row sums" | "grey interchange" => self.tr("balancing rows"),
            "exchange areas" => self.tr("exchange areas"),
            "forecast" => self.tr("forecast"),
            "refining" => self.tr("refining"),
            "bounces" => self.tr("bounces"),
            "shooting" => self.tr("shooting"),
            "irradiance" => self.tr("irradiance"),
            "radiance" => self.tr("radiance"),
            "charts" => self.tr("charts"),
            "texels" | "points" => self.tr("texels"),
            "shadow edges" => self.tr("shadow edges"),
            "comparing with paths" => self.tr("comparing with paths"),
            "reading" => self.tr("reading"),
            "parsing" => self.tr("parsing"),
            "render" => self.tr("tracing rays"),
            "" => self.tr("preparing"),
            other => other,
        }
    }

    /// Issues a command.
    pub fn send(&mut self, command: Command) {
        self.commands.push(command);
    }

    /// Issues an edit of the document.
    pub fn edit(&mut self, edit: Edit) {
        self.commands.push(Command::Edit(edit, self.gesture));
    }

    /// Selects an object, light or camera; with `adds` toggles it in the selection.
    pub fn select(&mut self, id: ItemId, adds: bool) {
        let mut selection = if adds {
            self.app.selection.clone()
        } else {
            Selection::default()
        };
        selection.faces = None;
        match selection.ids.iter().position(|&i| i == id) {
            Some(at) => {
                selection.ids.remove(at);
            }
            None => selection.ids.push(id),
        }
        if !adds {
            selection.material = None;
        }
        self.send(Command::Select(selection));
    }
}
