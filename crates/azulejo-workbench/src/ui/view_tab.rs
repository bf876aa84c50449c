//! The View tab: shading, false colours, background, fog.

use super::actions::shading_action;
use super::dialogs::map_name;
use super::inputs;
use super::panel_context::PanelContext;
use crate::app::light_unit::{EFFICACY, ShownUnit};
use crate::command::{Command, FileRequest};
use crate::document::Edit;
use crate::variants::all;
use crate::view::{
    Backdrop, COLORS, Comparison, LightUnit, ModelView, SectionPlane, Shading, linear_from_srgb,
};
use azulejo::scene::{Backplate, BackplateFit, Fog, SceneBackground};
use egui::{Color32, ComboBox, DragValue, Sense, Slider, Ui};

/// Draws the tab.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let old = &cx.app.view;
    let mut view = old.clone();
    exposure(ui, cx, &mut view);
    light_unit(ui, cx, &mut view);
    ui.separator();
    false_colors(ui, cx, &mut view);
    ui.separator();
    background(ui, cx, &mut view);
    ui.separator();
    fog(ui, cx, &mut view);
    ui.separator();
    ui.checkbox(&mut view.shows_markers, cx.tr("Lights and cameras"));
    ui.checkbox(&mut view.shows_grid, cx.tr("Grid"));
    ui.checkbox(&mut view.shows_cube, cx.tr("Orientation cube"));
    cutaway(ui, cx, &mut view);
    comparison(ui, cx, &mut view);
    let mut degrees = view.camera.vertical_fov.to_degrees();
    ui.horizontal_wrapped(|ui| {
        let slider = Slider::new(&mut degrees, 5.0..=120.0)
            .suffix("°")
            .clamping(egui::SliderClamping::Edits);
        if inputs::labelled(ui, cx.tr("Field of view"), slider).changed() {
            view.camera.vertical_fov = degrees.to_radians();
        }
    });
    if view != *old {
        cx.send(Command::SetView(Box::new(view)));
    }
}

/// The unit in which light is shown, whatever that of the file is.
fn light_unit(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    let name = |unit| match unit {
        LightUnit::Document => cx.tr("as in the file"),
        LightUnit::Radiometric => "W/m²",
        LightUnit::Photometric => "lx",
    };
    let combo = ComboBox::new("light unit", cx.tr("Show light in"));
    inputs::choice(combo, ui, &mut view.light_unit, all(), |&u| name(u));
    if ShownUnit::of(cx.app).factor != 1.0 {
        let words = cx.tr("Converted by a luminous efficacy of");
        ui.weak(format!("{words} {EFFICACY} lm/W."));
    }
}

fn exposure(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    ui.horizontal_wrapped(|ui| {
        let mut auto = view.exposure.is_none();
        if ui.checkbox(&mut auto, cx.tr("Auto exposure")).changed() {
            view.exposure = (!auto).then_some(cx.app.auto_exposure());
        }
        if let Some(exposure) = &mut view.exposure {
            let slider = Slider::new(exposure, 1e-4..=1e4).logarithmic(true);
            let response = ui.add(slider);
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Slider, true, cx.tr("Exposure"))
            });
        }
    });
}

fn false_colors(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    ui.strong(cx.tr("False colours"));
    let colors = &mut view.false_color;
    let combo = ComboBox::new("false map", cx.tr("Colour map"));
    inputs::choice(combo, ui, &mut colors.map, all(), |&m| map_name(m, cx));
    let range = cx.app.shown_range();
    let mut auto = colors.range.is_none();
    if ui.checkbox(&mut auto, cx.tr("Auto range")).changed() {
        let now = range.map_or((0.0, 1.0), |r| (r.low, r.usual));
        colors.range = (!auto).then_some(now);
    }
    let unit = ShownUnit::of(cx.app);
    if let Some((low, high)) = &mut colors.range {
        // Typed in the unit that is shown, stored in that of the document.
        let mut shown = [unit.factor * *low, unit.factor * *high];
        let before = shown;
        ui.horizontal_wrapped(|ui| {
            let speed = (0.01 * (shown[1] - shown[0]).abs()).max(1e-6);
            for (value, name) in shown.iter_mut().zip([cx.tr("From"), cx.tr("To")]) {
                inputs::labelled(ui, name, inputs::number(value, 0.0..=1e12).speed(speed));
            }
            ui.label(unit.irradiance());
        });
        if shown != before {
            (*low, *high) = (shown[0] / unit.factor, shown[1] / unit.factor);
        }
    }
    ui.checkbox(&mut colors.logarithmic, cx.tr("Logarithmic"));
    ui.horizontal_wrapped(|ui| {
        let drag = DragValue::new(&mut colors.isolines).range(0..=64);
        inputs::labelled(ui, cx.tr("Bands between isolines"), drag);
    });
}

/// What of the model is hidden, so that one sees into it.
fn cutaway(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    ui.checkbox(&mut view.hides_backs, cx.tr("Hide back faces"));
    let mut has = view.section.is_some();
    ui.horizontal_wrapped(|ui| {
        if ui.checkbox(&mut has, cx.tr("Section plane")).changed() {
            let new = SectionPlane::below_ceiling(cx.app.document.units.up);
            view.section = has.then_some(new);
        }
        if let Some(section) = &mut view.section {
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                ui.selectable_value(&mut section.axis, axis, name);
            }
        }
    });
    if let Some(section) = &mut view.section {
        ui.horizontal_wrapped(|ui| {
            let slider = Slider::new(&mut section.at, 0.0..=1.0).max_decimals(3);
            let name = cx.tr("Section plane");
            ui.add(slider)
                .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
            ui.checkbox(&mut section.is_flipped, cx.tr("Other side"));
        });
    }
}

/// Another shading mode at the right of the view.
fn comparison(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    let with = view.comparison.map(|c| c.with);
    let name = |with: Option<Shading>| match with {
        None => cx.tr("None"),
        Some(shading) => shading_action(cx.app, shading).map_or("", |a| cx.tr(a.label)),
    };
    let mut chosen = with;
    let combo = ComboBox::new("compare", cx.tr("Compare with"));
    let entries = [None].into_iter().chain(all().map(Some));
    inputs::choice(combo, ui, &mut chosen, entries, |&s| name(s));
    if chosen != with {
        let at = view.comparison.map_or(0.5, |c| c.at);
        view.comparison = chosen.map(|with| Comparison { with, at });
    }
}

fn background(ui: &mut Ui, cx: &mut PanelContext, view: &mut ModelView) {
    ui.strong(cx.tr("Background"));
    if ui
        .radio(view.backdrop == Backdrop::Scene, cx.tr("From the scene"))
        .clicked()
    {
        view.backdrop = Backdrop::Scene;
    }
    // The settings of the scene's background appear only while it is shown.
    if view.backdrop == Backdrop::Scene {
        own_background(ui, cx);
    }
    // The swatches are painted, so each is announced to screen readers as a named button.
    ui.horizontal_wrapped(|ui| {
        for (name, [r, g, b]) in COLORS {
            let (rect, response) = ui.allocate_exact_size(egui::vec2(20.0, 20.0), Sense::click());
            let name = cx.tr(name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
            ui.painter()
                .rect_filled(rect, 3.0, Color32::from_rgb(r, g, b));
            if view.backdrop == Backdrop::Color([r, g, b]) || response.has_focus() {
                let stroke = ui.visuals().selection.stroke;
                ui.painter()
                    .rect_stroke(rect, 3.0, stroke, egui::StrokeKind::Outside);
            }
            if response.on_hover_text(name).clicked() {
                view.backdrop = Backdrop::Color([r, g, b]);
            }
        }
        // Any other colour starts from the current one, or from dark grey.
        let mut any = match view.backdrop {
            Backdrop::Color(color) => color,
            _ => [64, 64, 64],
        };
        let any_color = ui.color_edit_button_srgb(&mut any);
        if any_color.on_hover_text(cx.tr("Any colour")).changed() {
            view.backdrop = Backdrop::Color(any);
        }
    });
    // An image is part of the scene, with settings of its own.
    ui.horizontal_wrapped(|ui| {
        if ui.button(cx.tr("Image…")).clicked() {
            cx.send(Command::RequestFile(FileRequest::Backplate));
        }
    });
    if let (Backdrop::Scene, Some(SceneBackground::Backplate(plate))) =
        (view.backdrop, cx.app.document.background)
    {
        backplate(ui, cx, view, plate);
    }
}

/// The image behind the scene: how it fills the view, and how bright it is.
fn backplate(ui: &mut Ui, cx: &mut PanelContext, view: &ModelView, old: Backplate) {
    let mut plate = old;
    ui.horizontal_wrapped(|ui| {
        for fit in BackplateFit::ALL {
            let name = match fit {
                BackplateFit::Scaled => cx.tr("Scaled"),
                BackplateFit::Centered => cx.tr("Centred"),
                BackplateFit::Tiled => cx.tr("Tiled"),
            };
            ui.selectable_value(&mut plate.fit, fit, name);
        }
    });
    ui.horizontal_wrapped(|ui| {
        let unit = ShownUnit::of(cx.app);
        let label = ui.label(cx.tr("Radiance of white"));
        let mut white = plate.radiance * unit.factor;
        let speed = 0.01 * white.max(1e-3);
        let field = inputs::number(&mut white, 0.0..=1e9)
            .speed(speed)
            .suffix(format!(" {}", unit.radiance()));
        let field = ui.add(field).labelled_by(label.id);
        let why =
            cx.tr("Pictures are exposed like the surfaces: this is what the image shows as white.");
        if field.on_hover_text(why).changed() {
            plate.radiance = white / unit.factor;
        }
        let as_it_is = cx.tr("Match exposure");
        let why = cx.tr("Shows the image at its own brightness in the exposure of the view.");
        if ui.button(as_it_is).on_hover_text(why).clicked() {
            plate.radiance = 1.0 / cx.app.exposure(view);
        }
    });
    if plate != old {
        cx.edit(Edit::SetBackground(Some(SceneBackground::Backplate(plate))));
    }
}

/// The background stored in the scene.
fn own_background(ui: &mut Ui, cx: &mut PanelContext) {
    let old = cx.app.document.background;
    let mut has = old.is_some();
    ui.horizontal_wrapped(|ui| {
        if ui
            .checkbox(&mut has, cx.tr("Background in the scene"))
            .changed()
        {
            let quiet = linear_from_srgb([64, 96, 160]);
            cx.edit(Edit::SetBackground(has.then_some(quiet.into())));
        }
        // A picture has no colour to pick.
        if let Some(mut radiance) = old.and_then(|b| b.color()) {
            let name = cx.tr("Background");
            if inputs::picked(ui, name, &mut radiance, Some) {
                cx.edit(Edit::SetBackground(Some(radiance.into())));
            }
        }
    });
}

fn fog(ui: &mut Ui, cx: &mut PanelContext, view: &mut ModelView) {
    let old = cx.app.document.fog;
    let mut has = old.is_some();
    let reach = cx.app.document.bounds(None).diagonal().max(1e-3);
    if ui.checkbox(&mut has, cx.tr("Fog in the scene")).changed() {
        let fog = Fog {
            color: linear_from_srgb([160, 170, 180]),
            visibility: 3.0 * reach,
            exponential: true,
        };
        cx.edit(Edit::SetFog(has.then_some(fog)));
    }
    let Some(mut fog) = old else { return };
    let before = fog;
    ui.horizontal_wrapped(|ui| {
        inputs::picked(ui, cx.tr("Fog"), &mut fog.color, Some);
        let drag = inputs::number(&mut fog.visibility, 1e-6..=1e12).speed(0.01 * reach);
        inputs::labelled(ui, cx.tr("Visibility range"), drag);
    });
    ui.checkbox(&mut fog.exponential, cx.tr("Exponential, as in real fog"));
    ui.checkbox(&mut view.shows_fog, cx.tr("Show in viewport"));
    if fog != before {
        cx.edit(Edit::SetFog(Some(fog)));
    }
}
