//! Solver settings.

use super::super::panel_context::PanelContext;
use crate::command::Command;
use crate::first_pass::{DEFAULT_TIME, EngineChoice, LightSettings};
use crate::ui::help::{self, HelpTerm};
use crate::ui::{focus, inputs};
use crate::variants::all;
use egui::{ComboBox, DragValue, Grid, Ui};

/// Number of bounces when the limit is switched on.
const DEFAULT_BOUNCES: u32 = 3;

/// Draws the fields.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let old = cx.app.lighting.settings;
    let mut new = old;
    let grid = Grid::new("light settings").num_columns(2);
    grid.spacing([12.0, 5.0]).show(ui, |ui| {
        engine(ui, cx, &mut new);
        patches(ui, cx, &mut new);
        error(ui, cx, &mut new);
        time(ui, cx, &mut new);
        bounces(ui, cx, &mut new);
    });
    let about = cx.tr(
        "Stores the light on the vertices of the model. Without it, the light is stored on a finer mesh, which shows finer shadows.",
    );
    ui.checkbox(&mut new.keep_mesh, cx.tr("Keep the faces of the model"))
        .on_hover_text(about);
    if new != old {
        cx.send(Command::SetLight(new));
    }
}

fn engine(ui: &mut Ui, cx: &PanelContext, settings: &mut LightSettings) {
    let about = cx.tr("Method for computing form factors between patches.");
    let label = ui.label(cx.tr("Engine")).on_hover_text(about);
    ComboBox::from_id_salt("engine")
        .width(ui.available_width().min(170.0))
        .selected_text(name(settings.engine, cx))
        .show_ui(ui, |ui| {
            focus::close_list(ui);
            for engine in all() {
                let value = &mut settings.engine;
                ui.selectable_value(value, engine, name(engine, cx))
                    .on_hover_text(what(engine, cx));
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text(what(settings.engine, cx));
    ui.end_row();
}

fn name(engine: EngineChoice, cx: &PanelContext) -> &'static str {
    match engine {
        EngineChoice::Auto => cx.tr("Auto"),
        EngineChoice::Rays => cx.tr("Rays"),
        EngineChoice::Hemicube => cx.tr("Hemicubes"),
        EngineChoice::Hybrid => cx.tr("Hemicubes and rays"),
        EngineChoice::Analytic => cx.tr("Analytic"),
    }
}

fn what(engine: EngineChoice, cx: &PanelContext) -> &'static str {
    match engine {
        EngineChoice::Auto => {
            cx.tr("Closed-form expressions for planar surfaces if there are few enough pairs, otherwise rays.")
        }
        EngineChoice::Rays => cx.tr("Rays from points all over each patch, including mirrors and glass."),
        EngineChoice::Hemicube => cx.tr("Item buffers rendered from each patch."),
        EngineChoice::Hybrid => {
            cx.tr("Item buffers for direct visibility, rays for mirrors and glass.")
        }
        EngineChoice::Analytic => cx.tr("Closed-form expressions for pairs of polygons, with exact shadows."),
    }
}

fn patches(ui: &mut Ui, cx: &PanelContext, settings: &mut LightSettings) {
    let about = cx.tr(
        "Approximate number of patches. More patches show finer shadows; twice as many take up to four times as long.",
    );
    let label = ui.label(cx.tr("Patches")).on_hover_text(about);
    let speed = (0.01 * f64::from(settings.patches)).max(1.0);
    let drag = DragValue::new(&mut settings.patches)
        .range(1..=10_000_000)
        .speed(speed)
        .update_while_editing(false);
    ui.horizontal(|ui| {
        ui.add(drag).labelled_by(label.id).on_hover_text(about);
        help::mark(ui, cx.language, HelpTerm::Patch);
    });
    ui.end_row();
}

fn error(ui: &mut Ui, cx: &PanelContext, settings: &mut LightSettings) {
    let about = cx.tr(
        "Estimated relative error at which the solver stops. Half the error takes about four times as long.",
    );
    inputs::error_row(ui, cx.tr("Target error"), about, &mut settings.error);
}

fn time(ui: &mut Ui, cx: &PanelContext, settings: &mut LightSettings) {
    fn field(seconds: &mut f64) -> DragValue<'_> {
        let drag = DragValue::new(seconds).range(0.1..=1e6).speed(0.5);
        drag.max_decimals(1).suffix(" s")
    }
    let about = cx
        .tr("The solver stops after this time and reports the error reached. Pauses do not count.");
    let name = cx.tr("Time limit");
    limit(
        ui,
        cx,
        [name, about],
        &mut settings.time,
        (DEFAULT_TIME, field),
    );
}

fn bounces(ui: &mut Ui, cx: &PanelContext, settings: &mut LightSettings) {
    fn field(bounces: &mut u32) -> DragValue<'_> {
        DragValue::new(bounces).range(0..=1_000).speed(0.1)
    }
    let about = cx.tr(
        "Maximum number of diffuse bounces; without a limit, until the remaining light is negligible. 0 is direct light only.",
    );
    let name = cx.tr("Limit bounces");
    limit(
        ui,
        cx,
        [name, about],
        &mut settings.bounces,
        (DEFAULT_BOUNCES, field),
    );
}

/// A row with a limit that may be off; `usual` is its value when it is switched on.
fn limit<T: Copy>(
    ui: &mut Ui,
    cx: &PanelContext,
    [name, about]: [&str; 2],
    limit: &mut Option<T>,
    (usual, field): (T, fn(&mut T) -> DragValue<'_>),
) {
    let mut is_on = limit.is_some();
    let check = ui.checkbox(&mut is_on, name).on_hover_text(about);
    if check.changed() {
        *limit = is_on.then_some(usual);
    }
    match limit {
        None => drop(ui.weak(cx.tr("No limit"))),
        Some(value) => {
            let drag = field(value).update_while_editing(false);
            ui.add(drag).labelled_by(check.id).on_hover_text(about);
        }
    }
    ui.end_row();
}
