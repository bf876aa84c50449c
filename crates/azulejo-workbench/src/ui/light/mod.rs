//! The solver: what it should do, how far it is, and what it found.

mod balance;
mod control;
mod factors;
mod found;
mod plot;
mod probes;
mod series;
mod settings;
#[cfg(test)]
mod tests;

use super::desk::PanelContext;
use egui::{CollapsingHeader, RichText, Ui};

/// Draws the tab; whether a probe is to be pinned.
pub fn show(ui: &mut Ui, desk: &mut PanelContext) -> bool {
    settings::show(ui, desk);
    ui.add_space(6.0);
    control::show(ui, desk);
    ui.add_space(2.0);
    if !desk.app.lighting.measures.is_empty() {
        section(ui, desk.say("Convergence"), |ui| plot::show(ui, desk));
    }
    let report = desk.app.lighting.solution.as_ref();
    if let Some(report) = report.and_then(|s| s.report.as_ref()) {
        section(ui, desk.say("Energy"), |ui| {
            balance::show(ui, desk, &report.balance)
        });
        section(ui, desk.say("How it was found"), |ui| {
            found::show(ui, desk, report)
        });
    }
    let pins = section(ui, desk.say("Probes"), |ui| probes::show(ui, desk));
    if let Some(seen) = &desk.app.lighting.seen {
        section(ui, desk.say("Form factors of a patch"), |ui| {
            factors::show(ui, desk, seen)
        });
    }
    pins.unwrap_or(false)
}

/// A part of the tab that can be folded away.
fn section<R>(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui) -> R) -> Option<R> {
    let header = CollapsingHeader::new(RichText::new(name).strong()).default_open(true);
    header.show_unindented(ui, body).body_returned
}

/// A name and a value in a grid of two columns.
fn row(ui: &mut Ui, name: &str, about: &str, value: String) {
    let label = ui.label(name);
    if !about.is_empty() {
        label.on_hover_text(about);
    }
    ui.add(egui::Label::new(value).wrap());
    ui.end_row();
}

/// A share in hundredths, with no more digits than it is worth.
fn percent(share: f64) -> String {
    let hundredths = 100.0 * share;
    let digits = match hundredths.abs() {
        x if x >= 10.0 || x == 0.0 => 0,
        x if x >= 1.0 => 1,
        _ => 2,
    };
    format!("{hundredths:.digits$} %")
}
