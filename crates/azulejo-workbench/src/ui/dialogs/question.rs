//! Questions about unsaved changes and changed files.

use crate::app::PendingQuestion;
use crate::command::Command;
use crate::jobs::JobKind;
use crate::ui::focus;
use crate::ui::panel_context::PanelContext;
use crate::ui::viewport::render_state;
use egui::{Id, Modal, Response, Ui};

/// The button that Enter presses.
fn first(button: Response) -> Response {
    focus::at_first(&button);
    button
}

/// Draws the question that the app is waiting for, if there is one.
pub(super) fn show(ui: &Ui, cx: &mut PanelContext) {
    let Some(question) = cx.app.question.clone() else {
        return;
    };
    // Hide the question while a save is running or its file is being chosen.
    if cx.app.is_busy(JobKind::Save) || cx.app.asking.is_some() {
        return;
    }
    let modal = Modal::new(Id::unique("question")).show(ui.ctx(), |ui| {
        ui.set_width(380.0);
        match &question {
            PendingQuestion::Unsaved(_) => {
                ui.heading(cx.tr("Unsaved changes"));
                if let Some(file) = &cx.app.file {
                    ui.label(file.path.display().to_string());
                }
                ui.label(cx.tr("If you continue, they will be lost."));
                ui.horizontal(|ui| {
                    if first(ui.button(cx.tr("Save"))).clicked() {
                        cx.send(Command::Save);
                    }
                    if ui.button(cx.tr("Don't save")).clicked() {
                        cx.send(Command::Discard);
                    }
                    if ui.button(cx.tr("Cancel")).clicked() {
                        cx.send(Command::CancelPending);
                    }
                });
            }
            PendingQuestion::ChangedOnDisk(path) => {
                ui.heading(cx.tr("The file has changed on disk"));
                ui.label(path.display().to_string());
                ui.label(cx.tr("Another program has written it since it was opened here."));
                ui.horizontal(|ui| {
                    if ui.button(cx.tr("Overwrite")).clicked() {
                        cx.send(Command::SaveAnyway);
                    }
                    if ui.button(cx.tr("Reload")).clicked() {
                        cx.send(Command::Discard);
                    }
                    if first(ui.button(cx.tr("Cancel"))).clicked() {
                        cx.send(Command::CancelPending);
                    }
                });
            }
            PendingQuestion::UnfinishedRender => {
                ui.heading(cx.tr("The image is not finished"));
                ui.label(render_state(cx));
                ui.horizontal(|ui| {
                    if first(ui.button(cx.tr("Save as it is…"))).clicked() {
                        cx.send(Command::SaveUnfinishedRender);
                    }
                    if ui.button(cx.tr("Keep rendering")).clicked() {
                        cx.send(Command::CancelPending);
                    }
                });
            }
        }
    });
    if modal.should_close() {
        cx.send(Command::CancelPending);
    }
}
