//! What a picked patch sees.

use super::super::desk::PanelContext;
use super::percent;
use crate::light::PatchFormFactors;
use egui::{Grid, ProgressBar, Ui};

/// Objects that are listed.
const MOST: usize = 12;

/// Draws the sum, and the objects that take most of the patch's light.
pub fn show(ui: &mut Ui, desk: &mut PanelContext, seen: &PatchFormFactors) {
    let app = desk.app;
    let name = app.document.name(seen.item).unwrap_or_default();
    ui.label(format!("{} {name}", desk.say("A patch of")));
    let outside = (1.0 - seen.sum).max(0.0);
    let (sum, rest) = (desk.say("Sum"), desk.say("goes outside"));
    let text = format!("{sum} {:.4}; {} {rest}", seen.sum, percent(outside));
    ui.label(text).on_hover_text(
        desk.say("Shares of the light that leaves the patch. In a closed room they sum up to 1."),
    );
    let grid = Grid::new("form factors").num_columns(3).striped(true);
    grid.show(ui, |ui| {
        ui.weak(desk.say("Object"));
        ui.weak("F");
        ui.end_row();
        for &(id, factor) in seen.objects.iter().take(MOST) {
            let name = app.document.name(id).unwrap_or_default();
            if ui
                .link(super::probes::shortened(name))
                .on_hover_text(name)
                .clicked()
            {
                desk.select(id, false);
            }
            ui.label(format!("{factor:.4}"));
            let bar = ProgressBar::new(factor.clamp(0.0, 1.0) as f32);
            ui.add(bar.desired_width(110.0).desired_height(8.0))
                .widget_info(|| {
                    let words = format!("{name} {}", percent(factor));
                    egui::WidgetInfo::labeled(egui::Role::Meter, true, words)
                });
            ui.end_row();
        }
    });
    if let Some(more) = seen.objects.len().checked_sub(MOST).filter(|n| *n > 0) {
        ui.weak(format!("+ {more} {}", desk.say("more objects")));
    }
}
