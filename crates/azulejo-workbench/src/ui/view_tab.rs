//! The View tab: shading, false colours, background, fog.

use super::dialogs::map_name;
use super::inputs;
use super::panel_context::PanelContext;
use crate::command::{Command, FileRequest};
use crate::document::Edit;
use crate::view::{Backdrop, BackgroundFit, COLORS, ColorMap, ModelView, linear_from_srgb};
use azulejo::scene::Fog;
use egui::{Color32, ComboBox, DragValue, Sense, Slider, Ui};

/// Draws the tab.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let old = &cx.app.view;
    let mut view = old.clone();
    exposure(ui, cx, &mut view);
    ui.separator();
    false_colors(ui, cx, &mut view);
    ui.separator();
    background(ui, cx, &mut view);
    ui.separator();
    fog(ui, cx, &mut view);
    ui.separator();
    ui.checkbox(&mut view.shows_markers, cx.tr("Lights and cameras"));
    ui.checkbox(&mut view.shows_grid, cx.tr("Grid"));
    let mut degrees = view.camera.vertical_fov.to_degrees();
    ui.horizontal(|ui| {
        let label = ui.label(cx.tr("Field of view"));
        let slider = Slider::new(&mut degrees, 5.0..=120.0)
            .suffix("°")
            .clamping(egui::SliderClamping::Edits);
        if ui.add(slider).labelled_by(label.id).changed() {
            view.camera.vertical_fov = degrees.to_radians();
        }
    });
    if view != *old {
        cx.send(Command::SetView(Box::new(view)));
    }
}

fn exposure(ui: &mut Ui, cx: &PanelContext, view: &mut ModelView) {
    ui.horizontal(|ui| {
        let mut auto = view.exposure.is_none();
        if ui.checkbox(&mut auto, cx.tr("Auto exposure")).changed() {
            view.exposure = (!auto).then_some(super::viewport::auto_exposure(cx.app));
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
    ComboBox::new("false map", cx.tr("Colour map"))
        .selected_text(map_name(colors.map, cx))
        .show_ui(ui, |ui| {
            for map in ColorMap::ALL {
                ui.selectable_value(&mut colors.map, map, map_name(map, cx));
            }
        });
    let found = super::viewport::shown_range(cx.app);
    let mut auto = colors.range.is_none();
    if ui.checkbox(&mut auto, cx.tr("Auto range")).changed() {
        let now = found.map_or((0.0, 1.0), |r| (r.low, r.usual));
        colors.range = (!auto).then_some(now);
    }
    if let Some((low, high)) = &mut colors.range {
        ui.horizontal(|ui| {
            let speed = (0.01 * (*high - *low).abs()).max(1e-6);
            let label = ui.label(cx.tr("From"));
            ui.add(inputs::number(low, 0.0..=1e12).speed(speed))
                .labelled_by(label.id);
            let label = ui.label(cx.tr("To"));
            ui.add(inputs::number(high, 0.0..=1e12).speed(speed))
                .labelled_by(label.id);
        });
    }
    ui.checkbox(&mut colors.logarithmic, cx.tr("Logarithmic"));
    ui.horizontal(|ui| {
        let label = ui.label(cx.tr("Bands between isolines"));
        ui.add(DragValue::new(&mut colors.isolines).range(0..=64))
            .labelled_by(label.id);
    });
}

fn background(ui: &mut Ui, cx: &mut PanelContext, view: &mut ModelView) {
    ui.strong(cx.tr("Background"));
    if ui
        .radio(view.backdrop == Backdrop::Scene, cx.tr("From the scene"))
        .clicked()
    {
        view.backdrop = Backdrop::Scene;
    }
    if view.backdrop == Backdrop::Scene {
        own_background(ui, cx);
    }
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
        let mut any = match view.backdrop {
            Backdrop::Color(color) => color,
            _ => [64, 64, 64],
        };
        let any_color = ui.color_edit_button_srgb(&mut any);
        if any_color.on_hover_text(cx.tr("Any colour")).changed() {
            view.backdrop = Backdrop::Color(any);
        }
    });
    ui.horizontal(|ui| {
        if ui.button(cx.tr("Image…")).clicked() {
            cx.send(Command::RequestFile(FileRequest::Backdrop));
        }
        if let Backdrop::Image(_, fit) = &mut view.backdrop {
            ui.selectable_value(fit, BackgroundFit::Scaled, cx.tr("Scaled"));
            ui.selectable_value(fit, BackgroundFit::Centered, cx.tr("Centred"));
            ui.selectable_value(fit, BackgroundFit::Tiled, cx.tr("Tiled"));
        }
    });
}

/// The background stored in the scene.
fn own_background(ui: &mut Ui, cx: &mut PanelContext) {
    let old = cx.app.document.background;
    let mut has = old.is_some();
    ui.horizontal(|ui| {
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
    ui.horizontal(|ui| {
        inputs::picked(ui, cx.tr("Fog"), &mut fog.color, Some);
        let label = ui.label(cx.tr("Visibility range"));
        let drag = inputs::number(&mut fog.visibility, 1e-6..=1e12);
        ui.add(drag.speed(0.01 * reach)).labelled_by(label.id);
    });
    ui.checkbox(&mut fog.exponential, cx.tr("Exponential, as in real fog"));
    ui.checkbox(&mut view.shows_fog, cx.tr("Show in viewport"));
    if fog != before {
        cx.edit(Edit::SetFog(Some(fog)));
    }
}
