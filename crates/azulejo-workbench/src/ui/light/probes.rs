//! The table of probes.

use super::super::panel_context::PanelContext;
use crate::app::light_unit::ShownUnit;
use crate::app::{Probe, ProbeSurface};
use crate::command::{Command, FileRequest};
use crate::jobs::JobKind;
use crate::ui::help::{self, HelpTerm};
use crate::ui::inspector::named;
use crate::ui::viewport::{number, value};
use azulejo::scene::Rgb;
use egui::{Grid, Ui};

/// Draws the table; returns whether the user wants to pin another probe.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) -> bool {
    let app = cx.app;
    let mut pins = false;
    // Pinning needs an object; measuring needs probes and light, and runs only once at a time.
    ui.horizontal(|ui| {
        let about = cx.tr("Click here, then a surface; or press P over a surface.");
        let button = egui::Button::new(cx.tr("Pin a probe"));
        let button = ui.add_enabled(!app.document.objects.is_empty(), button);
        pins = button.on_hover_text(about).clicked();
        let measures = app.is_busy(JobKind::Probe);
        let about = cx.tr(
            "Solves the light again with the settings above, and gathers it at the probes instead of interpolating between vertices.",
        );
        let button = egui::Button::new(cx.tr("Measure exactly"));
        let makes_sense = !app.probes.is_empty() && !measures && app.document.has_light();
        let button = ui.add_enabled(makes_sense, button).on_hover_text(about);
        if button.clicked() {
            cx.send(Command::MeasureProbes);
        }
        if measures {
            ui.spinner();
        }
    });
    if !app.probes.is_empty() {
        let about = cx.tr("All probes with their places, in the unit that is shown.");
        let button = ui.button(cx.tr("Save as CSV…")).on_hover_text(about);
        if button.clicked() {
            cx.send(Command::RequestFile(FileRequest::SaveProbes));
        }
    }
    // Without probes, a hint takes the place of the table.
    if app.probes.is_empty() {
        ui.weak(cx.tr("No probes yet: press P over a surface to pin one."));
        return pins;
    }
    // Interpolated and measured irradiance are side by side, in the same unit.
    let grid = Grid::new("probes").num_columns(5).striped(true);
    grid.spacing([8.0, 4.0]).show(ui, |ui| {
        ui.weak("#");
        ui.weak(cx.tr("Point"));
        let unit = ShownUnit::of(app).irradiance();
        ui.weak(format!("E, {unit}"));
        ui.horizontal(|ui| {
            ui.weak(format!("{}, {unit}", cx.tr("measured")));
            help::mark(ui, cx.language, HelpTerm::StandardError);
        });
        ui.end_row();
        for probe in &app.probes {
            row(ui, cx, probe);
        }
    });
    pins
}

fn row(ui: &mut Ui, cx: &mut PanelContext, probe: &Probe) {
    let app = cx.app;
    let name = app.document.name(probe.pick.item);
    ui.label(probe.number.to_string());
    ui.vertical(|ui| {
        let link = ui.link(shortened(name.unwrap_or("–")));
        if link.on_hover_text(about(cx, probe)).clicked() && name.is_some() {
            cx.select(probe.pick.item, false);
        }
        if let Some(site) = &probe.site {
            ui.weak(shortened(&named(&app.document, site.paint.material)));
        }
    });
    let front = probe.site.as_ref().filter(|s| s.paint.is_front);
    let light = front.and_then(|s| s.light);
    ui.vertical(|ui| cell(ui, cx, probe.site.as_ref(), light, why_not(cx, probe)));
    let measured = probe.measured.map(|m| (m.value, Some(m.error)));
    let hint = cx.tr("Not measured yet.");
    ui.vertical(|ui| cell(ui, cx, probe.site.as_ref(), measured, hint));
    let remove = ui.small_button("✖");
    let words = format!("{} {}", cx.tr("Remove probe"), probe.number);
    let remove = remove.on_hover_text(&words);
    remove.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, words.clone()));
    if remove.clicked() {
        cx.send(Command::RemoveProbe(probe.number));
    }
    ui.end_row();
}

/// Irradiance with its standard error, and the diffuse radiance that results from it.
fn cell(
    ui: &mut Ui,
    cx: &PanelContext,
    site: Option<&ProbeSurface>,
    light: Option<(Rgb, Option<Rgb>)>,
    why_not: &str,
) {
    let Some((irradiance, error)) = light else {
        ui.weak("–").on_hover_text(why_not);
        return;
    };
    let unit = ShownUnit::of(cx.app);
    let radiance = site.and_then(|s| cx.app.document.radiance(&s.paint, irradiance));
    let (irradiance, error) = (unit.rgb(irradiance), error.map(|e| unit.rgb(e)));
    let mut text = number(irradiance.luminance());
    if let Some(error) = error {
        text += &format!(" ± {}", number(error.luminance()));
    }
    ui.add(egui::Label::new(text).extend())
        .on_hover_text(format!(
            "E = {} ± {} {}",
            value(irradiance),
            error.map_or("?".into(), value),
            unit.irradiance()
        ));
    if let Some(radiance) = radiance {
        let (radiance, unit) = (unit.rgb(radiance), unit.radiance());
        let about = cx.tr("Diffuse radiance leaving it:");
        let text = egui::RichText::new(format!("L = {}", number(radiance.luminance())));
        ui.add(egui::Label::new(text.weak()).extend())
            .on_hover_text(format!("{about} {} {unit}", value(radiance)));
    }
}

/// Why a probe has no values.
fn why_not(cx: &PanelContext, probe: &Probe) -> &'static str {
    match &probe.site {
        None => cx.tr("There is no surface at this point any more."),
        Some(site) if !site.paint.is_front => {
            cx.tr("This is the back of a surface, and light is stored for fronts only: measure it.")
        }
        Some(_) => cx.tr("Not solved yet."),
    }
}

/// The details of a probe for its tooltip.
fn about(cx: &PanelContext, probe: &Probe) -> String {
    let pick = &probe.pick;
    let name = cx.app.document.name(pick.item).unwrap_or("–");
    let three = |v: glam::DVec3| format!("({}, {}, {})", number(v.x), number(v.y), number(v.z));
    let mut text = format!("{name} (#{})\n", pick.item.0);
    if let Some(site) = &probe.site {
        let material = named(&cx.app.document, site.paint.material);
        text += &format!("{} {}\n", cx.tr("face"), site.face);
        text += &format!(
            "{} {material} (#{})\n",
            cx.tr("material"),
            site.paint.material
        );
    }
    text + &format!("{}, n = {}", three(pick.position), three(pick.normal))
}

/// A name shortened at its start, since its end says most.
pub fn shortened(name: &str) -> String {
    const MAX_CHARS: usize = 14;
    let count = name.chars().count();
    if count > MAX_CHARS {
        format!(
            "…{}",
            name.chars().skip(count + 1 - MAX_CHARS).collect::<String>()
        )
    } else {
        name.to_owned()
    }
}
