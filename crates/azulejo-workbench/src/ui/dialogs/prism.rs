//! The dialog for a prism.

use crate::command::{Command, FileRequest, PrismBase};
use crate::document::SIDES;
use crate::ui::inputs;
use crate::ui::panel_context::PanelContext;
use egui::{DragValue, Grid, Id, Modal, Ui};
use std::path::{Path, PathBuf};

/// The dialog for a prism.
#[derive(Clone, Debug)]
pub struct PrismDialog {
    sides: u32,
    /// The drawing with the outline; `None` for a regular polygon.
    pub drawing: Option<PathBuf>,
    /// World units.
    size: f64,
    height: f64,
}

impl PrismDialog {
    /// Starts with a prism that suits the model, as high as wide.
    pub fn new(size: f64) -> PrismDialog {
        PrismDialog {
            sides: 6,
            drawing: None,
            size,
            height: size,
        }
    }

    /// Draws the dialog; returns whether it is finished.
    pub fn show(&mut self, ui: &Ui, cx: &mut PanelContext) -> bool {
        let mut is_done = false;
        let modal = Modal::new(Id::unique("prism")).show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.heading(cx.tr("Exact prism"));
            Grid::new("prism").num_columns(2).show(ui, |ui| {
                self.base(ui, cx);
                self.lengths(ui, cx);
            });
            ui.horizontal(|ui| {
                if ui.button(cx.tr("Add prism")).clicked() {
                    cx.send(self.command());
                    is_done = true;
                }
                is_done |= ui.button(cx.tr("Cancel")).clicked();
            });
        });
        is_done || modal.should_close()
    }

    /// The number of sides, or the drawing.
    fn base(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        ui.label(cx.tr("Outline"));
        ui.horizontal(|ui| {
            let name = self.drawing.as_deref().and_then(Path::file_name);
            let name = name.map(|n| n.to_string_lossy().into_owned());
            let name = name.unwrap_or_else(|| cx.tr("From a drawing…").to_owned());
            let about =
                cx.tr("Filled shapes of an SVG or PDF, or closed outlines of a DXF drawing");
            if ui.button(name).on_hover_text(about).clicked() {
                cx.send(Command::RequestFile(FileRequest::Outline));
            }
            if self.drawing.is_some() && ui.button(cx.tr("Regular")).clicked() {
                self.drawing = None;
            }
        });
        ui.end_row();
        if self.drawing.is_none() {
            let drag = DragValue::new(&mut self.sides).range(SIDES).speed(0.1);
            inputs::labelled_row(ui, cx.tr("Sides"), drag);
        }
    }

    fn lengths(&mut self, ui: &mut Ui, cx: &PanelContext) {
        for (name, length) in [
            (cx.tr("Larger side"), &mut self.size),
            (cx.tr("Height"), &mut self.height),
        ] {
            let speed = 0.01 * *length;
            inputs::labelled_row(ui, name, inputs::number(length, 1e-9..=1e9).speed(speed));
        }
    }

    fn command(&self) -> Command {
        Command::AddPrism {
            base: match &self.drawing {
                Some(path) => PrismBase::Drawing(path.clone()),
                None => PrismBase::Regular(self.sides),
            },
            size: self.size,
            height: self.height,
        }
    }
}
