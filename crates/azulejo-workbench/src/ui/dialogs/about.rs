//! Information about azulejo.

use crate::ui::panel_context::PanelContext;
use egui::{Id, Modal, Ui};

/// Draws the information about azulejo while it is open.
pub(super) fn show(ui: &Ui, cx: &PanelContext, is_open: &mut bool) {
    if !*is_open {
        return;
    }
    let mut is_done = false;
    let modal = Modal::new(Id::unique("about")).show(ui.ctx(), |ui| {
        ui.set_width(380.0);
        ui.heading(format!("azulejo {}", env!("CARGO_PKG_VERSION")));
        ui.label(cx.tr("Global illumination for the models people already have."));
        is_done = ui.button(cx.tr("Close")).clicked();
    });
    *is_open = !(is_done || modal.should_close());
}
