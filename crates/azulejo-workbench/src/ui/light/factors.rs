//! Form factors of the picked patch.

use super::super::panel_context::PanelContext;
use super::percent;
use crate::first_pass::PatchFormFactors;
use crate::ui::help::{self, HelpTerm};
use egui::{Grid, ProgressBar, Ui};

/// Number of objects listed.
const MAX_OBJECTS: usize = 12;

/// Draws the sum, and the objects with the largest form factors.
pub fn show(ui: &mut Ui, cx: &mut PanelContext, seen: &PatchFormFactors) {
    let app = cx.app;
    let name = app.document.name(seen.item).unwrap_or_default();
    ui.label(format!("{} {name}", cx.tr("Patch of")));
    // If the sum exceeds 1 a little, nothing leaves the scene.
    let outside = (1.0 - seen.sum).max(0.0);
    let (sum, rest) = (cx.tr("Sum"), cx.tr("leaves the scene"));
    let text = format!("{sum} {:.4}; {} {rest}", seen.sum, percent(outside));
    ui.horizontal(|ui| {
        ui.label(text).on_hover_text(
            cx.tr("Fractions of the light leaving the patch. In a closed scene they sum to 1."),
        );
        help::mark(ui, cx.language, HelpTerm::FormFactor);
    });
    // The objects come in descending order of their form factors; a click selects one.
    let grid = Grid::new("form factors").num_columns(3).striped(true);
    grid.show(ui, |ui| {
        ui.weak(cx.tr("Object"));
        ui.weak("F");
        ui.end_row();
        for &(id, factor) in seen.objects.iter().take(MAX_OBJECTS) {
            let name = app.document.name(id).unwrap_or_default();
            if ui
                .link(super::probes::shortened(name))
                .on_hover_text(name)
                .clicked()
            {
                cx.select(id, false);
            }
            ui.label(format!("{factor:.4}"));
            // To a screen reader the bar is a meter with the name of the object.
            let bar = ProgressBar::new(factor.clamp(0.0, 1.0) as f32);
            ui.add(bar.desired_width(110.0).desired_height(8.0))
                .widget_info(|| {
                    let words = format!("{name} {}", percent(factor));
                    egui::WidgetInfo::labeled(egui::Role::Meter, true, words)
                });
            ui.end_row();
        }
    });
    // Tell how many objects the table leaves out.
    if let Some(more) = seen
        .objects
        .len()
        .checked_sub(MAX_OBJECTS)
        .filter(|n| *n > 0)
    {
        ui.weak(format!("+ {more} {}", cx.tr("more objects")));
    }
}
