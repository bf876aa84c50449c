//! The dialog for solid text.

use crate::command::{Command, FileRequest};
use crate::ui::panel_context::PanelContext;
use crate::ui::{focus, inputs};
use egui::{DragValue, Grid, Id, Modal, Ui};
use std::path::{Path, PathBuf};

/// The dialog for solid text.
#[derive(Clone, Debug)]
pub struct TextDialog {
    text: String,
    size: f64,
    depth: f64,
    /// The font file; `None` for the built-in typeface.
    pub(super) font: Option<PathBuf>,
}

impl TextDialog {
    /// Starts with a font size that suits the model.
    pub fn new(size: f64) -> TextDialog {
        TextDialog {
            text: String::new(),
            size,
            depth: 0.25,
            font: None,
        }
    }

    /// Draws the dialog; returns whether it is finished.
    pub(super) fn show(&mut self, ui: &Ui, cx: &mut PanelContext) -> bool {
        let mut done = false;
        let mut asks_font = false;
        let modal = Modal::new(Id::unique("letters")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(cx.tr("Solid text"));
            // The text has the focus when the dialog opens.
            let label = ui.label(cx.tr("Text"));
            let field = ui.add(
                egui::TextEdit::multiline(&mut self.text)
                    .desired_rows(2)
                    .desired_width(f32::INFINITY),
            );
            focus::at_first(&field.labelled_by(label.id));
            // The depth of letters is relative to the font size, and without a file a built-in font is used.
            Grid::new("letters").num_columns(2).show(ui, |ui| {
                let speed = 0.01 * self.size;
                let drag = DragValue::new(&mut self.size).range(1e-9..=1e9);
                inputs::labelled_row(ui, cx.tr("Font size (em)"), drag.speed(speed));
                let drag = DragValue::new(&mut self.depth).range(1e-3..=1e3);
                inputs::labelled_row(ui, cx.tr("Depth (em)"), drag.speed(0.01));
                ui.label(cx.tr("Font"));
                let name = self.font.as_deref().and_then(Path::file_name);
                let name = name.map(|n| n.to_string_lossy().into_owned());
                asks_font = ui
                    .button(name.unwrap_or_else(|| "DejaVu Serif".into()))
                    .clicked();
                ui.end_row();
            });
            // Blank text has no solid that could be added.
            ui.horizontal(|ui| {
                let ready = !self.text.trim().is_empty();
                if ui
                    .add_enabled(ready, egui::Button::new(cx.tr("Add text")))
                    .clicked()
                {
                    cx.send(Command::AddText {
                        text: self.text.clone(),
                        size: self.size,
                        depth: self.depth,
                        font: self.font.clone(),
                    });
                    done = true;
                }
                done |= ui.button(cx.tr("Cancel")).clicked();
            });
        });
        // The file dialog takes the place of this one, which returns after it.
        if asks_font {
            cx.send(Command::RequestFile(FileRequest::Font));
            return false;
        }
        done || modal.should_close()
    }
}
