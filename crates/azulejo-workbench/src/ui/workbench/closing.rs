//! The window's title, and when it may close.

use super::Workbench;
use crate::app::App;
use crate::command::Command;
use crate::jobs::JobKind;
use egui::ViewportCommand;

impl Workbench {
    pub(super) fn update_window(&mut self, context: &egui::Context) {
        let (asks_close, focused) = context.input(|i| {
            let viewport = i.viewport();
            (viewport.close_requested(), viewport.focused.unwrap_or(true))
        });
        self.handle_close(context, asks_close);
        if focused && !self.was_focused {
            self.app.check_disk();
            // Its question is displayed in the next frame.
            context.request_repaint();
        }
        self.was_focused = focused;
        let title = title(&self.app);
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Closes the window at a request of the system: nobody can be asked, so unsaved changes are left
    /// as a recovery copy.
    pub(super) fn end_if_asked(&mut self, context: &egui::Context) {
        if self.ending.is_asked() && !self.is_leaving {
            self.is_leaving = true;
            self.keep_place();
            self.ending.note(self.app.leave_recovery());
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Closes the window at the user's request, after all files are written and not with changes
    /// that the user has not given up, including those made meanwhile.
    fn handle_close(&mut self, context: &egui::Context, asks_close: bool) {
        let was_leaving = self.is_leaving;
        let ends = asks_close || self.app.closing;
        let is_lost = self.rescue.is_none();
        if !ends || is_lost || self.is_leaving {
            self.is_leaving |= ends;
        } else if self.app.is_busy(JobKind::Save) {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            if !self.app.closing {
                self.app.execute(Command::Quit);
            }
        } else if self.app.close_loses_changes() {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.app.closing = false;
            self.app.execute(Command::Quit);
        } else {
            self.is_leaving = true;
        }
        if self.is_leaving && !was_leaving {
            self.keep_place();
        }
        if self.is_leaving && self.app.closing {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }
}

/// The file, a mark for unsaved changes, and the program.
fn title(app: &App) -> String {
    let file = app.file.as_ref().and_then(|f| f.path.file_name());
    let source_file = app.document.source_files.first().map(|b| b.name.clone());
    let name = file
        .map(|n| n.to_string_lossy().into_owned())
        .or(source_file);
    let mark = if app.is_changed() { "• " } else { "" };
    match name {
        Some(name) => format!("{mark}{name} – azulejo"),
        None => format!("{mark}azulejo"),
    }
}
