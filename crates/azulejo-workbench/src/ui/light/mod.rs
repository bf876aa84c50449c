//! The Light tab: settings, progress and results of the solver.

mod control;
mod energy;
mod engines;
mod factors;
mod plot;
mod probes;
mod report;
mod series;
mod settings;
mod task_plane;
#[cfg(test)]
mod tests;

pub(super) use control::seconds;
pub(super) use report::count;

use super::panel_context::PanelContext;
use egui::{CollapsingHeader, RichText, Ui};

/// Draws the tab; returns whether the user wants to pin a probe.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) -> bool {
    settings::show(ui, cx);
    ui.add_space(6.0);
    control::show(ui, cx);
    ui.add_space(2.0);
    if !cx.app.lighting.measures.is_empty() {
        section(ui, cx.tr("Convergence"), |ui| plot::show(ui, cx));
    }
    let report = cx.app.lighting.solution.as_ref();
    if let Some(report) = report.and_then(|s| s.report.as_ref()) {
        section(ui, cx.tr("Energy balance"), |ui| {
            energy::show(ui, cx, &report.balance)
        });
        section(ui, cx.tr("Statistics"), |ui| report::show(ui, cx, report));
    }
    let pins = section(ui, cx.tr("Probes"), |ui| probes::show(ui, cx));
    if cx.app.task_plane.is_added {
        section(ui, cx.tr("Task plane"), |ui| task_plane::show(ui, cx));
    }
    if let Some(seen) = &cx.app.lighting.form_factors {
        section(ui, cx.tr("Form factors of a patch"), |ui| {
            factors::show(ui, cx, seen)
        });
    }
    pins.unwrap_or(false)
}

/// A collapsible section.
fn section<R>(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui) -> R) -> Option<R> {
    let header = CollapsingHeader::new(RichText::new(name).strong()).default_open(true);
    header.show_unindented(ui, body).body_returned
}

/// A name and a value in a grid with two columns.
fn row(ui: &mut Ui, name: &str, about: &str, value: String) {
    let label = ui.label(name);
    if !about.is_empty() {
        label.on_hover_text(about);
    }
    ui.add(egui::Label::new(value).wrap());
    ui.end_row();
}

/// A percentage with a suitable number of digits.
pub(super) fn percent(share: f64) -> String {
    let hundredths = 100.0 * share;
    let digits = match hundredths.abs() {
        x if x >= 10.0 || x == 0.0 => 0,
        x if x >= 1.0 => 1,
        _ => 2,
    };
    format!("{hundredths:.digits$} %")
}
