//! What the solver should do.

use super::super::desk::PanelContext;
use crate::command::Command;
use crate::light::{EngineChoice, LightSettings, USUAL_TIME};
use egui::{ComboBox, DragValue, Grid, Ui};

/// Bounces that are offered when they are to be counted.
const USUAL_BOUNCES: u32 = 3;

/// Draws the fields.
pub fn show(ui: &mut Ui, desk: &mut PanelContext) {
    let old = desk.app.lighting.settings;
    let mut new = old;
    let grid = Grid::new("light settings").num_columns(2);
    grid.spacing([12.0, 5.0]).show(ui, |ui| {
        engine(ui, desk, &mut new);
        patches(ui, desk, &mut new);
        error(ui, desk, &mut new);
        time(ui, desk, &mut new);
        bounces(ui, desk, &mut new);
    });
    if new != old {
        desk.wish(Command::SetLight(new));
    }
}

fn engine(ui: &mut Ui, desk: &PanelContext, settings: &mut LightSettings) {
    let about = desk.say("Who computes the form factors between patches.");
    let label = ui.label(desk.say("Engine")).on_hover_text(about);
    ComboBox::from_id_salt("engine")
        .width(170.0)
        .selected_text(name(settings.engine, desk))
        .show_ui(ui, |ui| {
            for engine in EngineChoice::ALL {
                let value = &mut settings.engine;
                ui.selectable_value(value, engine, name(engine, desk))
                    .on_hover_text(what(engine, desk));
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text(what(settings.engine, desk));
    ui.end_row();
}

fn name(engine: EngineChoice, desk: &PanelContext) -> &'static str {
    match engine {
        EngineChoice::Auto => desk.say("by itself"),
        EngineChoice::Rays => desk.say("rays"),
        EngineChoice::Hemicube => desk.say("hemicubes"),
        EngineChoice::Hybrid => desk.say("hemicubes and rays"),
        EngineChoice::Analytic => desk.say("formulas"),
    }
}

fn what(engine: EngineChoice, desk: &PanelContext) -> &'static str {
    match engine {
        EngineChoice::Auto => {
            desk.say("Formulas where surfaces are flat and few enough to pair, else rays.")
        }
        EngineChoice::Rays => desk.say("Rays from all over each patch, through mirrors and glass."),
        EngineChoice::Hemicube => desk.say("Pictures of what each patch sees."),
        EngineChoice::Hybrid => {
            desk.say("Pictures for what is seen straight, rays for what mirrors and glass show.")
        }
        EngineChoice::Analytic => desk.say("Formulas for pairs of polygons, with exact shadows."),
    }
}

fn patches(ui: &mut Ui, desk: &PanelContext, settings: &mut LightSettings) {
    let about = desk.say(
        "About how many pieces the surfaces are divided into. More show finer shadows; twice as \
         many take up to four times the time.",
    );
    let label = ui.label(desk.say("Patches")).on_hover_text(about);
    let speed = (0.01 * f64::from(settings.patches)).max(1.0);
    let drag = DragValue::new(&mut settings.patches)
        .range(1..=10_000_000)
        .speed(speed)
        .update_while_editing(false);
    ui.add(drag).labelled_by(label.id).on_hover_text(about);
    ui.end_row();
}

fn error(ui: &mut Ui, desk: &PanelContext, settings: &mut LightSettings) {
    let about = desk.say(
        "Estimated relative error at which the solver rests. Half the error takes about four \
         times the time.",
    );
    let label = ui.label(desk.say("Error aimed at")).on_hover_text(about);
    let mut percent = 100.0 * settings.error;
    let drag = DragValue::new(&mut percent)
        .range(0.1..=100.0)
        .speed(0.05)
        .max_decimals(2)
        .suffix(" %")
        .update_while_editing(false);
    let field = ui.add(drag).labelled_by(label.id).on_hover_text(about);
    if field.changed() {
        settings.error = percent / 100.0;
    }
    ui.end_row();
}

fn time(ui: &mut Ui, desk: &PanelContext, settings: &mut LightSettings) {
    let about = desk.say(
        "After this time the solver ends with what it has, and says how good that is. Rests do \
         not count.",
    );
    let mut limited = settings.time.is_some();
    let words = desk.say("Time limit");
    let check = ui.checkbox(&mut limited, words).on_hover_text(about);
    if check.changed() {
        settings.time = limited.then_some(USUAL_TIME);
    }
    match &mut settings.time {
        None => {
            ui.weak(desk.say("no limit"));
        }
        Some(seconds) => {
            let drag = DragValue::new(seconds)
                .range(0.1..=1e6)
                .speed(0.5)
                .max_decimals(1)
                .suffix(" s")
                .update_while_editing(false);
            ui.add(drag).labelled_by(check.id).on_hover_text(about);
        }
    }
    ui.end_row();
}

fn bounces(ui: &mut Ui, desk: &PanelContext, settings: &mut LightSettings) {
    let about = desk.say(
        "Light is reflected from surface to surface until next to nothing is left, or so many \
         times: 0 is direct light alone.",
    );
    let mut counted = settings.bounces.is_some();
    let words = desk.say("Count bounces");
    let check = ui.checkbox(&mut counted, words).on_hover_text(about);
    if check.changed() {
        settings.bounces = counted.then_some(USUAL_BOUNCES);
    }
    match &mut settings.bounces {
        None => {
            ui.weak(desk.say("until little is left"));
        }
        Some(bounces) => {
            let drag = DragValue::new(bounces)
                .range(0..=1_000)
                .speed(0.1)
                .update_while_editing(false);
            ui.add(drag).labelled_by(check.id).on_hover_text(about);
        }
    }
    ui.end_row();
}
