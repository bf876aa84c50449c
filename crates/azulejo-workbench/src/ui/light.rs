//! The solver: what it should do, and how far it is.

use super::desk::Desk;
use super::viewport::{irradiance_unit, number};
use crate::command::Command;
use crate::jobs::Kind;
use crate::light::EngineName;
use egui::{ComboBox, DragValue, Grid, Ui};

/// Draws the tab.
pub fn show(ui: &mut Ui, desk: &mut Desk) {
    let app = desk.app;
    let old = app.lighting.settings;
    let mut new = old;
    ComboBox::new("engine", desk.say("Engine"))
        .selected_text(engine_name(new.engine, desk))
        .show_ui(ui, |ui| {
            for engine in EngineName::ALL {
                ui.selectable_value(&mut new.engine, engine, engine_name(engine, desk));
            }
        });
    Grid::new("solver").num_columns(2).show(ui, |ui| {
        let label = ui.label(desk.say("Patches"));
        ui.add(
            DragValue::new(&mut new.patches)
                .range(1..=10_000_000)
                .speed(50),
        )
        .labelled_by(label.id);
        ui.end_row();
        let label = ui.label(desk.say("Error aimed at"));
        let mut percent = 100.0 * new.error;
        let drag = DragValue::new(&mut percent)
            .range(0.1..=100.0)
            .speed(0.1)
            .suffix(" %");
        if ui.add(drag).labelled_by(label.id).changed() {
            new.error = percent / 100.0;
        }
        ui.end_row();
    });
    if new != old {
        desk.wish(Command::SetLight(new));
    }
    let _ = (Kind::Solve, irradiance_unit(app), number(0.0));
}

fn engine_name(engine: EngineName, desk: &Desk) -> &'static str {
    match engine {
        EngineName::Auto => desk.say("by itself"),
        EngineName::Rays => desk.say("rays"),
        EngineName::Hemicube => desk.say("hemicubes"),
        EngineName::Hybrid => desk.say("hemicubes and rays"),
        EngineName::Analytic => desk.say("formulas"),
    }
}
