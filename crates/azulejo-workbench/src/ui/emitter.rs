//! An object that shines, as a light: its flux, its radiance, its colour temperature.

use super::inspector::named;
use super::panel_context::PanelContext;
use super::viewport::number;
use super::{color_temperature, inputs};
use crate::app::light_unit::{EFFICACY, ShownUnit};
use crate::command::{Command, Selection};
use crate::document::{Edit, SceneDocument, SceneObject};
use crate::gpu::display_mesh;
use azulejo::scene::math::area_vector;
use azulejo::scene::{Material, MaterialId, Rgb, Shape};
use egui::{Grid, Id, Ui};
use glam::DVec3;
use std::f64::consts::PI;

/// What an object emits by one of its materials.
#[derive(Clone, Copy, Debug, PartialEq)]
struct EmittingPart {
    material: MaterialId,
    /// Area of its fronts, world units².
    area: f64,
}

/// The emissive materials of an object, with the areas that have them.
fn parts(document: &SceneDocument, item: &SceneObject) -> Vec<EmittingPart> {
    let shines = |m: &&MaterialId| {
        let material = document.materials.get(**m as usize);
        material.is_some_and(|m| m.is_emitter())
    };
    let mut parts: Vec<EmittingPart> = (item.materials().iter().filter(shines))
        .map(|&material| EmittingPart {
            material,
            area: 0.0,
        })
        .collect();
    if parts.is_empty() {
        return parts;
    }
    let size = item.bounds().diagonal();
    let mesh = match &*item.shape {
        Shape::Mesh(mesh) => std::borrow::Cow::Borrowed(mesh),
        // The chords of a round shape: its area to a thousandth.
        other => display_mesh(other, 2e-4 * size.max(f64::MIN_POSITIVE), false),
    };
    let mut corners: Vec<DVec3> = Vec::new();
    for face in 0..mesh.faces.len() {
        let material = mesh.face_materials.get(face).copied();
        let Some(part) = parts.iter_mut().find(|p| Some(p.material) == material) else {
            continue;
        };
        corners.clear();
        let place = |&v: &u32| item.placement.transform_point3(mesh.positions[v as usize]);
        corners.extend(mesh.faces.get(face).iter().map(place));
        part.area += area_vector(&corners).length();
    }
    parts
}

/// Flux of a matt emitter, in the unit of the document: π times area times radiance per side.
fn flux(material: &Material, area: f64, metres: f64) -> Rgb {
    let sides = if material.emits_back { 2.0 } else { 1.0 };
    material.emission * (sides * PI * area * metres * metres)
}

/// The areas, kept until the document changes: an emitter may have a million faces.
fn kept_parts(ui: &Ui, cx: &PanelContext, item: &SceneObject) -> Vec<EmittingPart> {
    type Kept = (u64, Vec<EmittingPart>);
    let id = Id::unique(("emitter", item.id));
    let revision = cx.app.revision();
    let kept = ui.data(|d| d.get_temp::<Kept>(id));
    if let Some((_, parts)) = kept.filter(|(of, _)| *of == revision) {
        return parts;
    }
    let parts = parts(&cx.app.document, item);
    ui.data_mut(|d| d.insert_temp(id, (revision, parts.clone())));
    parts
}

/// Draws the light of an object that shines; nothing for others.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext, item: &SceneObject) {
    let parts = kept_parts(ui, cx, item);
    if parts.is_empty() {
        return;
    }
    ui.separator();
    ui.strong(cx.tr("Area light"));
    let metres = cx.app.document.units.metres();
    for part in parts {
        let Some(material) = cx.app.document.materials.get(part.material as usize) else {
            continue;
        };
        let material = Material::clone(material);
        Grid::new(("emitter", item.id, part.material))
            .num_columns(2)
            .show(ui, |ui| {
                ui.label(cx.tr("Material"));
                if ui.link(named(&cx.app.document, part.material)).clicked() {
                    cx.send(Command::Select(Selection {
                        ids: vec![item.id],
                        faces: None,
                        material: Some(part.material),
                    }));
                }
                ui.end_row();
                flux_row(ui, cx, part, &material, metres);
                radiance_row(ui, cx, &material);
                if let Some(hue) = temperature_row(ui, cx, material.emission) {
                    let mut new = material.clone();
                    new.emission = hue;
                    cx.edit(Edit::SetMaterial(part.material, new));
                }
            });
    }
}

/// Flux in watts and in lumens; either can be typed.
fn flux_row(
    ui: &mut Ui,
    cx: &mut PanelContext,
    part: EmittingPart,
    material: &Material,
    metres: f64,
) {
    let is_photometric = cx.app.document.units.photometric;
    let total = flux(material, part.area, metres).luminance();
    let [watts, lumens] = watts_and_lumens(total, is_photometric);
    ui.label(cx.tr("Flux"));
    ui.horizontal(|ui| {
        for (value, unit) in [(watts, "W"), (lumens, "lm")] {
            let mut typed = value;
            let drag = inputs::number(&mut typed, 1e-9..=1e15)
                .speed((0.01 * value).max(1e-3))
                .max_decimals(3)
                .suffix(format!(" {unit}"));
            let field = ui.add(drag);
            field.widget_info(|| {
                egui::WidgetInfo::labeled(
                    egui::Role::SpinButton,
                    true,
                    format!("{} {unit}", cx.tr("Flux")),
                )
            });
            if field.changed() && value > 0.0 {
                let mut new = material.clone();
                new.emission *= typed / value;
                cx.edit(Edit::SetMaterial(part.material, new));
            }
        }
    });
    ui.end_row();
}

/// A flux of white light in watts and in lumens.
pub(super) fn watts_and_lumens(flux: f64, is_photometric: bool) -> [f64; 2] {
    if is_photometric {
        [flux / EFFICACY, flux]
    } else {
        [flux, flux * EFFICACY]
    }
}

fn radiance_row(ui: &mut Ui, cx: &PanelContext, material: &Material) {
    let unit = ShownUnit::of(cx.app);
    ui.label(cx.tr("Radiance"));
    let radiance = unit.factor * material.emission.luminance();
    ui.label(format!("{} {}", number(radiance), unit.radiance()));
    ui.end_row();
}

/// The colour temperature of a light; returns the light in another colour of the same luminance if
/// one was chosen.
pub(super) fn temperature_row(ui: &mut Ui, cx: &PanelContext, light: Rgb) -> Option<Rgb> {
    let temperature = color_temperature::of(light);
    ui.label(cx.tr("Colour temperature"));
    let mut kelvin = temperature.unwrap_or(6_500.0);
    let range = color_temperature::LEAST..=color_temperature::MOST;
    let mut drag = inputs::number(&mut kelvin, range)
        .speed(10.0)
        .max_decimals(0)
        .suffix(" K");
    if temperature.is_none() {
        // The field is for choosing one; that of this colour there is not.
        drag = drag.custom_formatter(|_, _| "–".into());
    }
    let field = ui.add(drag).accessible_name(cx.tr("Colour temperature"));
    if temperature.is_none() {
        field
            .clone()
            .on_hover_text(cx.tr("Far from the colour of any black body."));
    }
    ui.end_row();
    if !field.changed() {
        return None;
    }
    color_temperature::light_of(kelvin, light.luminance())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::App;
    use crate::command::Command;
    use crate::document::NewShapeKind;

    #[test]
    fn a_square_lamp_emits_pi_times_area_times_radiance() {
        let mut app = App::quiet();
        app.execute(Command::AddShape(NewShapeKind::AreaLight));
        let item = app.document.objects[0].clone();
        let parts = parts(&app.document, &item);
        assert_eq!(parts.len(), 1);
        assert!((parts[0].area - 1.0).abs() < 1e-12, "{}", parts[0].area);
        let material = &app.document.materials[parts[0].material as usize];
        let total = flux(material, parts[0].area, 1.0);
        assert!((total.luminance() - PI * 10.0).abs() < 1e-9);
        // In a model of millimetres the same square is a millionth.
        assert!((flux(material, 1.0, 1e-3).r / total.r - 1e-6).abs() < 1e-12);
        assert_eq!(watts_and_lumens(2.0, false), [2.0, 358.0]);
        assert_eq!(watts_and_lumens(179.0, true), [1.0, 179.0]);
    }

    #[test]
    fn what_does_not_shine_is_no_light() {
        let mut app = App::quiet();
        app.execute(Command::AddShape(NewShapeKind::Sphere));
        let item = app.document.objects[0].clone();
        assert!(parts(&app.document, &item).is_empty());
    }
}
