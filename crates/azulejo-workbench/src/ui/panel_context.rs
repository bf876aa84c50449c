//! What every part of the window is given.

use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId};
use crate::words::Language;

/// The state to show, and the wishes that come of it.
pub struct PanelContext<'a> {
    /// What there is.
    pub app: &'a App,
    /// The language to say it in.
    pub language: Language,
    /// The drag that goes on, if one does: its edits are one step of undo.
    pub gesture: Option<u64>,
    /// Whether a dialog or a question lies over everything: keys are for it.
    pub is_covered: bool,
    /// What was asked for.
    pub commands: Vec<Command>,
}

impl PanelContext<'_> {
    /// `english` in the window's language.
    pub fn tr(&self, english: &'static str) -> &'static str {
        self.language.tr(english)
    }

    /// A stage of a job in the window's language; as the job says it, if it is not known.
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
            "reading" => self.tr("reading"),
            "parsing" => self.tr("parsing"),
            "render" => self.tr("tracing rays"),
            "" => self.tr("preparing"),
            other => other,
        }
    }

    /// Asks for something.
    pub fn send(&mut self, command: Command) {
        self.commands.push(command);
    }

    /// Asks for a change of the document.
    pub fn edit(&mut self, edit: Edit) {
        self.commands.push(Command::Edit(edit, self.gesture));
    }

    /// Selects one thing, or adds it to the selection, or takes it away.
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
