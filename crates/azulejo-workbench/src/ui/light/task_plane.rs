//! The task plane: where it lies, and the figures by which standards judge it.

use super::super::panel_context::PanelContext;
use super::row;
use crate::app::TaskPlane;
use crate::app::light_unit::ShownUnit;
use crate::command::{Command, FileRequest};
use crate::document::{MAX_POINTS, TaskGrid, TaskPlaneSettings};
use crate::jobs::JobKind;
use crate::ui::inputs;
use crate::ui::viewport::number;
use egui::{DragValue, Grid, Ui};

/// Draws the section.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    settings(ui, cx);
    let app = cx.app;
    let is_busy = app.is_busy(JobKind::TaskPlane);
    ui.horizontal_wrapped(|ui| {
        let about = cx.tr(
            "Solves the light again with the settings above, and gathers it at the points of the plane.",
        );
        let button = egui::Button::new(cx.tr("Measure the plane"));
        let button = ui.add_enabled(!is_busy && app.document.has_light(), button);
        if button.on_hover_text(about).clicked() {
            cx.send(Command::MeasureTaskPlane);
        }
        if is_busy {
            ui.spinner();
        }
        let save = egui::Button::new(cx.tr("Save as CSV…"));
        if ui.add_enabled(app.task_plane.result.is_some(), save).clicked() {
            cx.send(Command::RequestFile(FileRequest::SaveTaskPlane));
        }
        if ui.button(cx.tr("Remove the plane")).clicked() {
            cx.send(Command::RemoveTaskPlane);
        }
    });
    match &app.task_plane.result {
        Some(plane) => figures(ui, cx, plane),
        None => drop(ui.weak(cx.tr("Not measured yet."))),
    }
}

fn settings(ui: &mut Ui, cx: &mut PanelContext) {
    let old = cx.app.task_plane.settings;
    let mut new = old;
    let grid = Grid::new("task plane settings").num_columns(2);
    grid.spacing([12.0, 5.0]).show(ui, |ui| {
        let about = cx.tr("Above the lowest point of the model.");
        metres(ui, cx.tr("Height"), about, &mut new.height);
        let about = cx.tr("Distance of the plane from the edges of the model's footprint.");
        metres(ui, cx.tr("Margin"), about, &mut new.margin);
        points(ui, cx, &mut new);
    });
    if new != old {
        cx.send(Command::SetTaskPlane(new));
    }
}

fn metres(ui: &mut Ui, name: &str, about: &str, value: &mut f64) {
    let label = ui.label(name).on_hover_text(about);
    let drag = inputs::number(value, 0.0..=1e6).speed(0.01).suffix(" m");
    ui.add(drag).labelled_by(label.id).on_hover_text(about);
    ui.end_row();
}

fn points(ui: &mut Ui, cx: &PanelContext, settings: &mut TaskPlaneSettings) {
    let name = cx.tr("Points");
    let about = cx.tr("Numbers of points along x, and along the other horizontal axis.");
    ui.label(name).on_hover_text(about);
    ui.horizontal(|ui| {
        for (k, count) in settings.counts.iter_mut().enumerate() {
            if k > 0 {
                ui.label("×");
            }
            let drag = DragValue::new(count).range(1..=MAX_POINTS);
            let response = ui.add(drag).on_hover_text(about);
            response.accessible_name(format!("{name} {}", k + 1));
        }
    });
    ui.end_row();
}

/// Irradiance and its uniformity with standard errors.
fn figures(ui: &mut Ui, cx: &PanelContext, plane: &TaskPlane) {
    let Some(figures) = plane.figures() else {
        ui.weak(cx.tr("All points lie inside solids."));
        return;
    };
    let unit = ShownUnit::of(cx.app);
    let light = |(value, error): (f64, f64)| {
        let [value, error] = [value, error].map(|x| number(unit.factor * x));
        format!("{value} ± {error} {}", unit.irradiance())
    };
    let share = |(value, error): (f64, f64)| format!("{value:.3} ± {error:.3}");
    let grid = Grid::new("task plane figures").num_columns(2).striped(true);
    grid.spacing([12.0, 4.0]).show(ui, |ui| {
        row(ui, cx.tr("Minimum"), "", light(figures.least));
        row(ui, cx.tr("Mean"), "", light(figures.mean));
        row(ui, cx.tr("Maximum"), "", light(figures.most));
        let about = cx.tr("Smallest irradiance relative to the mean.");
        row(ui, cx.tr("Uniformity U0"), about, share(figures.uniformity));
        let about = cx.tr("Smallest irradiance relative to the largest.");
        row(
            ui,
            cx.tr("Minimum to maximum"),
            about,
            share(figures.diversity),
        );
    });
    if TaskGrid::of(&cx.app.document, &cx.app.task_plane.settings) != Some(plane.grid) {
        ui.weak(cx.tr("These figures are for another height, margin or number of points."));
    }
    let left_out = plane.cells.iter().filter(|c| c.is_none()).count();
    if left_out > 0 {
        let words = cx.tr("points inside solids are left out");
        ui.weak(format!("{left_out} {words}"));
    }
}
