//! Properties of a light source without area.

use super::inspector::{name, speed, vector};
use super::panel_context::PanelContext;
use super::viewport::number;
use super::{emitter, inputs, polar, surroundings};
use crate::document::{Edit, ItemId, SceneLight};
use azulejo::luminaire::kinds::LuminaireKind;
use azulejo::scene::{EnvironmentSource, Light, LightKind, Rgb, Units};
use egui::{Grid, Ui};
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

/// Draws the properties.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext, lamp: &SceneLight) {
    name(ui, cx, lamp.id, &lamp.light.name);
    let mut light = lamp.light.clone();
    let rows = Grid::new("light").num_columns(2);
    let changed = rows.show(ui, |ui| numbers(ui, cx, lamp.id, &mut light.kind));
    ui.weak(attenuation(&light, cx));
    if let LightKind::Luminaire { scale, web, .. } = &light.kind {
        let units = cx.app.document.units;
        let kind = LuminaireKind {
            name: &light.name,
            web,
            scale: scale.mean(),
            lights: 1,
        };
        let square = units.metres() * units.metres();
        polar::show(ui, cx, &kind, (unit(units, "W/sr", "cd"), square));
    }
    if changed.inner {
        cx.edit(Edit::SetLight(lamp.id, light));
    }
    surroundings::buttons(ui, cx, lamp);
}

/// The rows of a light; returns whether they changed it.
fn numbers(ui: &mut Ui, cx: &PanelContext, lamp: ItemId, kind: &mut LightKind) -> bool {
    let units = cx.app.document.units;
    let step = speed(&cx.app.document);
    // E = I/d² with d in units of the scene: an intensity in W/sr is I times the square of one.
    let square = units.metres() * units.metres();
    match kind {
        LightKind::Point {
            position,
            intensity,
        } => {
            let moved = vector(ui, cx.tr("Position"), position, step);
            let (name, unit) = (cx.tr("Intensity"), unit(units, "W/sr", "cd"));
            let dimmed = light_color(ui, cx, lamp, name, (unit, square), intensity);
            total(ui, cx, 4.0 * PI * square * intensity.luminance());
            moved | dimmed
        }
        LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        } => {
            let moved = vector(ui, cx.tr("Position"), position, step)
                | unit_vector(ui, cx.tr("Direction"), direction);
            let (name, unit) = (cx.tr("Intensity"), unit(units, "W/sr", "cd"));
            let dimmed = light_color(ui, cx, lamp, name, (unit, square), intensity);
            moved | dimmed | cone(ui, cx, inner, outer)
        }
        LightKind::Luminaire {
            position,
            world_from_web,
            scale,
            web,
        } => {
            // Without negative zeros, which would be shown.
            let aim = DVec3::ZERO - world_from_web.z_axis;
            let mut turned = aim;
            let moved = vector(ui, cx.tr("Position"), position, step)
                | unit_vector(ui, cx.tr("Direction"), &mut turned);
            if turned != aim {
                let turn = DMat3::from_quat(DQuat::from_rotation_arc(aim, turned));
                *world_from_web = turn * *world_from_web;
            }
            let moved = moved | spin(ui, cx, world_from_web);
            let (name, unit) = (cx.tr("Greatest intensity"), unit(units, "W/sr", "cd"));
            let dimmed = light_color(ui, cx, lamp, name, (unit, square * web.most()), scale);
            total(ui, cx, web.sphere_integral() * square * scale.luminance());
            moved | dimmed
        }
        LightKind::Directional {
            direction,
            irradiance,
            half_angle,
        } => {
            let moved = surroundings::sun_place(ui, cx, direction);
            let (name, unit) = (cx.tr("Irradiance"), unit(units, "W/m²", "lx"));
            let dimmed = light_color(ui, cx, lamp, name, (unit, 1.0), irradiance);
            moved | dimmed | surroundings::sun_size(ui, cx, half_angle)
        }
        LightKind::Ambient { radiance } => {
            let (name, unit) = (cx.tr("Radiance"), unit(units, "W/(sr·m²)", "cd/m²"));
            light_color(ui, cx, lamp, name, (unit, 1.0), radiance)
        }
        LightKind::Environment(environment) => {
            let changed = surroundings::environment(ui, cx, environment);
            let name = cx.tr("Brightness");
            changed | light_color(ui, cx, lamp, name, ("×", 1.0), &mut environment.scale)
        }
    }
}

/// A row with the angle by which a luminaire is turned about its aim, counter-clockwise as seen from behind; returns
/// whether it was changed.
fn spin(ui: &mut Ui, cx: &PanelContext, world_from_web: &mut DMat3) -> bool {
    let aim = -world_from_web.z_axis;
    let plain = DMat3::from_quat(DQuat::from_rotation_arc(-DVec3::Z, aim));
    let now = plain.transpose() * world_from_web.x_axis;
    let was = now.y.atan2(now.x).to_degrees();
    let mut degrees = was;
    let name = cx.tr("Turn about the aim");
    let drag = inputs::number(&mut degrees, -180.0..=180.0)
        .speed(0.5)
        .suffix("°");
    let changed = inputs::labelled_row(ui, name, drag).changed();
    if changed {
        let turn = DMat3::from_axis_angle(-aim, (degrees - was).to_radians());
        *world_from_web = turn * *world_from_web;
    }
    changed
}

/// A row with the flux of a light in watts and in lumens.
fn total(ui: &mut Ui, cx: &PanelContext, flux: f64) {
    let is_photometric = cx.app.document.units.photometric;
    let [watts, lumens] = emitter::watts_and_lumens(flux, is_photometric);
    ui.label(cx.tr("Flux"));
    ui.label(format!("{} W, {} lm", number(watts), number(lumens)));
    ui.end_row();
}

/// The unit of a quantity, radiometric or photometric.
pub(super) fn unit(
    units: Units,
    radiometric: &'static str,
    photometric: &'static str,
) -> &'static str {
    if units.photometric {
        photometric
    } else {
        radiometric
    }
}

/// A row with strength and colour of a light, in a unit and times a factor; colours are relative to
/// their brightest channel.
fn light_color(
    ui: &mut Ui,
    cx: &PanelContext,
    lamp: ItemId,
    name: &str,
    (unit, factor): (&str, f64),
    light: &mut Rgb,
) -> bool {
    let last = egui::Id::unique(("hue", lamp));
    let (mut strength, mut hue) = inputs::parts(ui, last, *light);
    let old = (strength, hue);
    ui.label(name);
    ui.horizontal(|ui| {
        inputs::picked(ui, cx.tr("Emission colour"), &mut hue, inputs::hue);
        let mut shown = strength * factor;
        let speed = (0.01 * shown).max(1e-9);
        let drag = inputs::number(&mut shown, 0.0..=1e12)
            .speed(speed)
            .suffix(format!(" {unit}"));
        if ui.add(drag).accessible_name(name).changed() {
            strength = shown / factor;
        }
    });
    ui.end_row();
    if let Some(warm) = emitter::temperature_row(ui, cx, *light) {
        *light = warm;
        return true;
    }
    if (strength, hue) == old {
        return false;
    }
    inputs::keep_hue(ui, last, hue);
    let new = hue * strength;
    // The colour of a light that is off is remembered without an edit.
    let changed = new != *light;
    *light = new;
    changed
}

/// The attenuation of a light with distance, which follows from its type.
fn attenuation(light: &Light, cx: &PanelContext) -> &'static str {
    match light.kind {
        LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Luminaire { .. } => {
            cx.tr("Falls off with the square of the distance.")
        }
        LightKind::Directional { .. } => cx.tr("Independent of the distance."),
        LightKind::Ambient { .. } => cx.tr("Uniform from all directions."),
        LightKind::Environment(environment) => match environment.source {
            EnvironmentSource::Picture { .. } => cx.tr("From all directions, as in the image."),
            EnvironmentSource::Sky(_) => cx.tr("From the sky, and from the ground below it."),
        },
    }
}

/// A direction; vectors without a direction are rejected.
fn unit_vector(ui: &mut Ui, name: &str, direction: &mut DVec3) -> bool {
    let mut typed = *direction;
    if !vector(ui, name, &mut typed, 0.01) {
        return false;
    }
    match typed.try_normalize() {
        Some(unit) => {
            *direction = unit;
            true
        }
        None => false,
    }
}

fn cone(ui: &mut Ui, cx: &PanelContext, inner: &mut f64, outer: &mut f64) -> bool {
    let mut degrees = [inner.to_degrees(), outer.to_degrees()];
    let names = [cx.tr("Inner angle"), cx.tr("Outer angle")];
    let mut changed = false;
    for k in 0..2 {
        let drag = inputs::number(&mut degrees[k], 0.0..=180.0)
            .speed(0.25)
            .suffix("°");
        if inputs::labelled(ui, names[k], drag).changed() {
            changed = true;
            // The field being changed pushes the other one.
            match k {
                0 => degrees[1] = degrees[1].max(degrees[0]),
                _ => degrees[0] = degrees[0].min(degrees[1]),
            }
        }
        ui.end_row();
    }
    if changed {
        (*inner, *outer) = (degrees[0].to_radians(), degrees[1].to_radians());
    }
    changed
}
