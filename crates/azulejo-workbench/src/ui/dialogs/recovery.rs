//! The question about recovery copies after a crash.

use crate::command::Command;
use crate::ui::panel_context::PanelContext;
use egui::{Id, Modal, Ui};
use std::path::Path;

/// Offers the recovery copies, until the user has answered.
pub(super) fn show(ui: &Ui, cx: &mut PanelContext, is_answered: &mut bool) {
    let copies = cx.app.recoverable();
    if *is_answered || copies.is_empty() {
        return;
    }
    let modal = Modal::new(Id::unique("recovery")).show(ui.ctx(), |ui| {
        ui.set_width(460.0);
        ui.heading(cx.tr("Recover unsaved work?"));
        ui.label(cx.tr("Unsaved work from the last session:"));
        for one in copies {
            ui.horizontal(|ui| {
                let name = one.original.as_deref().and_then(Path::file_name);
                let name = name.map(|n| n.to_string_lossy().into_owned());
                ui.label(name.unwrap_or_else(|| cx.tr("Unnamed").into()));
                ui.weak(age(one.written, cx));
                if ui.button(cx.tr("Recover")).clicked() {
                    cx.send(Command::Recover(one.copy.clone()));
                    *is_answered = true;
                }
                if ui.button(cx.tr("Delete")).clicked() {
                    cx.send(Command::DeleteRecovery(one.copy.clone()));
                }
            });
        }
        if ui.button(cx.tr("Ask me later")).clicked() {
            *is_answered = true;
        }
    });
    *is_answered |= modal.should_close();
}

/// How long ago a recovery copy was written.
fn age(written: u64, cx: &PanelContext) -> String {
    let now =
        azulejo::trace::time::SystemTime::now().duration_since(azulejo::trace::time::UNIX_EPOCH);
    let seconds = now.map_or(0, |d| d.as_secs().saturating_sub(written));
    match seconds {
        0..3_600 => format!("{} min", seconds / 60),
        3_600..86_400 => format!("{} h", seconds / 3_600),
        _ => format!("{} {}", seconds / 86_400, cx.tr("days")),
    }
}
