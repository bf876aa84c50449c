//! The comparison of engines on the picked patch.

use super::super::colors::lines;
use super::super::panel_context::PanelContext;
use super::count;
use super::plot::{curve, error_and_seconds, framed};
use crate::command::Command;
use crate::engine_comparison::EngineRun;
use crate::first_pass::EngineChoice;
use crate::jobs::JobKind;
use crate::ui::viewport::number;
use egui::{Grid, Ui, WidgetInfo};
use egui_plot::Corner;

/// Draws the button, and what has been computed so far: a plot, and its points as a table.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let app = cx.app;
    let runs = app.is_busy(JobKind::FormFactors);
    ui.horizontal(|ui| {
        let about = cx.tr(
            "Computes the form factors of this patch by rays and by hemicubes with more and more samples, and compares them with those of formulas.",
        );
        let button = ui.add_enabled(!runs, egui::Button::new(cx.tr("Compare engines")));
        if button.on_hover_text(about).clicked() {
            cx.send(Command::CompareEngines);
        }
        if runs {
            ui.spinner();
        }
    });
    let found = &app.lighting.engine_runs;
    if !found.is_empty() {
        plot(ui, cx, found);
        table(ui, cx, found);
    }
}

fn plot(ui: &mut Ui, cx: &PanelContext, found: &[EngineRun]) {
    let title = cx.tr("Error against time of a row");
    ui.weak(title);
    let [blue, orange, ..] = lines(ui);
    let point = |run: &EngineRun| [run.seconds, run.error].map(|x| x.max(1e-12).log10());
    let ys = found.iter().map(|run| point(run)[1]);
    let plot = framed("engines", Corner::LeftBottom, ys);
    let shown = error_and_seconds(plot, cx).show(ui, |plot| {
        for (engine, name, color) in [
            (EngineChoice::Rays, cx.tr("Rays"), blue),
            (EngineChoice::Hemicube, cx.tr("Hemicubes"), orange),
        ] {
            let own = found.iter().filter(|run| run.engine == engine);
            curve(plot, name, &own.map(point).collect::<Vec<_>>(), color);
        }
    });
    let info = || WidgetInfo::labeled(egui::Role::Image, true, title);
    shown.response.widget_info(info);
}

fn table(ui: &mut Ui, cx: &PanelContext, found: &[EngineRun]) {
    let grid = Grid::new("engine runs").num_columns(4).striped(true);
    grid.show(ui, |ui| {
        let samples = cx.tr("Rays or pixels");
        for name in [cx.tr("Engine"), samples, "ms", cx.tr("Error")] {
            ui.weak(name);
        }
        ui.end_row();
        for run in found {
            ui.label(match run.engine {
                EngineChoice::Rays => cx.tr("Rays"),
                _ => cx.tr("Hemicubes"),
            });
            ui.label(count(run.samples.into()));
            ui.label(number(1e3 * run.seconds));
            ui.label(format!("{} %", number(100.0 * run.error)));
            ui.end_row();
        }
    });
}
