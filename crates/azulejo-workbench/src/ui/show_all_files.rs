//! A checkbox beside the file dialog that shows files with unknown extensions too.

use super::panel_context::PanelContext;
use egui::{Area, Context, Frame, Id, Order};
use egui_file::FileDialog;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether all files are shown. The format is detected from the content in the end.
#[derive(Default)]
pub struct ShowAllFiles(Arc<AtomicBool>);

impl ShowAllFiles {
    /// The filter of the dialog: files accepted by `offers`, or all.
    pub fn filter(&self, offers: impl Fn(&Path) -> bool + Send + Sync + 'static) -> FileFilter {
        let all = Arc::clone(&self.0);
        Box::new(move |path| all.load(Ordering::Relaxed) || offers(path))
    }

    /// Draws the checkbox below the dialog.
    pub fn show(&self, context: &Context, cx: &PanelContext, id: Id, dialog: &mut FileDialog) {
        let Some(rect) = context.memory(|m| m.area_rect(id)) else {
            return;
        };
        let mut all = self.0.load(Ordering::Relaxed);
        let area = Area::new(Id::unique("all files"))
            .order(Order::Middle)
            .fixed_pos(rect.left_bottom());
        let shown = area.show(context, |ui| {
            let frame = Frame::window(ui.style());
            frame.show(ui, |ui| ui.checkbox(&mut all, cx.tr("All files")))
        });
        // The dialog moves itself to the top in every frame, and a small window has no space below
        // it.
        context.move_to_top(shown.response.layer_id);
        if shown.inner.inner.changed() {
            self.0.store(all, Ordering::Relaxed);
            // Reads the folder again.
            let folder = dialog.directory().to_owned();
            dialog.set_path(folder);
        }
    }
}

/// Decides whether a file is listed.
type FileFilter = Box<dyn Fn(&Path) -> bool + Send + Sync + 'static>;
