//! Properties of light from outside: suns, skies and pictures of the surroundings.

use super::inputs;
use super::lamps::unit;
use super::panel_context::PanelContext;
use crate::command::{Command, FileRequest};
use crate::document::{Edit, ItemId, SceneLight, SkySettings};
use azulejo::scene::sky::{
    CieSky, PerezWeather, Sky, SkyDistribution, SunPosition, TYPICAL_DEW_POINT,
};
use azulejo::scene::{Environment, EnvironmentSource, Light, LightKind, Rgb};
use egui::{ComboBox, DragValue, Grid, Id, Ui};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Weather of a clear day, before the user has typed another.
const CLEAR_DAY: PerezWeather = PerezWeather {
    dni: 600.0,
    dhi: 150.0,
    sun_altitude: 0.0,
    day_of_year: 80,
    dew_point: TYPICAL_DEW_POINT,
};

/// A row with one number; returns whether it was changed.
fn quantity_row(
    ui: &mut Ui,
    name: &str,
    value: &mut f64,
    range: RangeInclusive<f64>,
    unit: &str,
) -> bool {
    let speed = 0.0025 * (range.end() - range.start()).min(100.0);
    let drag = inputs::number(value, range).speed(speed).suffix(unit);
    inputs::labelled_row(ui, name, drag).changed()
}

/// Rows for azimuth and elevation of a sun whose light travels in `direction`.
pub(super) fn sun_place(ui: &mut Ui, cx: &PanelContext, direction: &mut DVec3) -> bool {
    let mut toward = -*direction;
    let names = [cx.tr("Azimuth"), cx.tr("Elevation")];
    let moved = place(ui, cx, names, &mut toward);
    *direction = -toward;
    moved
}

/// Rows for azimuth and elevation by the compass; `toward` is a unit direction of the world.
fn place(ui: &mut Ui, cx: &PanelContext, names: [&str; 2], toward: &mut DVec3) -> bool {
    let document = &cx.app.document;
    let at = document.compass(*toward);
    let (mut azimuth, mut elevation) = (at.azimuth.to_degrees(), at.altitude.to_degrees());
    let moved = quantity_row(ui, names[0], &mut azimuth, 0.0..=360.0, "°")
        | quantity_row(ui, names[1], &mut elevation, -90.0..=90.0, "°");
    if moved {
        *toward = document.toward(SunPosition {
            altitude: elevation.to_radians(),
            azimuth: azimuth.to_radians(),
        });
    }
    moved
}

/// A row for the angle that the disc of a sun subtends.
pub(super) fn sun_size(ui: &mut Ui, cx: &PanelContext, half_angle: &mut f64) -> bool {
    let mut degrees = 2.0 * half_angle.to_degrees();
    let changed = quantity_row(ui, cx.tr("Angular size"), &mut degrees, 0.0..=90.0, "°");
    if changed {
        *half_angle = 0.5 * degrees.to_radians();
    }
    changed
}

/// Rows of a sky or a picture, its brightness apart.
pub(super) fn environment(ui: &mut Ui, cx: &PanelContext, environment: &mut Environment) -> bool {
    let EnvironmentSource::Sky(old) = environment.source else {
        return rotation(ui, cx, environment);
    };
    let document = &cx.app.document;
    let mut settings = document.sky_settings(environment, &old);
    let changed = sky(ui, cx, &mut settings);
    if changed {
        environment.source = EnvironmentSource::Sky(document.sky_of(environment, &settings));
    }
    changed
}

/// A row for the turn of a picture; 0 is as it was loaded.
fn rotation(ui: &mut Ui, cx: &PanelContext, environment: &mut Environment) -> bool {
    let up = cx.app.document.units.up;
    let mut degrees = environment.north(up).to_degrees();
    let turned = quantity_row(ui, cx.tr("Rotation"), &mut degrees, 0.0..=360.0, "°");
    if turned {
        *environment = environment.with_north(up, degrees.to_radians());
    }
    turned
}

/// Rows of a sky; returns whether they changed its settings.
fn sky(ui: &mut Ui, cx: &PanelContext, settings: &mut SkySettings) -> bool {
    ui.label(cx.tr("Type of sky"));
    let chosen = cie_type(ui, cx, &mut settings.distribution);
    ui.end_row();
    let names = [cx.tr("Azimuth of the sun"), cx.tr("Elevation of the sun")];
    let moved = place(ui, cx, names, &mut settings.toward);
    let unit = format!(" {}", unit(cx.app.document.units, "W/m²", "lx"));
    let name = cx.tr("Horizontal irradiance");
    let dimmed = quantity_row(ui, name, &mut settings.irradiance, 0.0..=1e6, &unit);
    let name = cx.tr("Ground reflectance");
    chosen | moved | dimmed | quantity_row(ui, name, &mut settings.reflectance, 0.0..=1.0, "")
}

/// The choice of a distribution; that of weather is made below, from the weather.
fn cie_type(ui: &mut Ui, cx: &PanelContext, distribution: &mut SkyDistribution) -> bool {
    let old = *distribution;
    let combo = ComboBox::new("type of sky", "").width(ui.available_width().min(220.0));
    let cie_skies = CieSky::all().map(SkyDistribution::Cie);
    let skies = [SkyDistribution::Uniform].into_iter().chain(cie_skies);
    inputs::choice(combo, ui, distribution, skies, |sky| sky_name(cx, sky))
        .accessible_name(cx.tr("Type of sky"));
    *distribution != old
}

/// The number and the name of a CIE type, or another distribution.
fn sky_name(cx: &PanelContext, distribution: &SkyDistribution) -> String {
    match distribution {
        SkyDistribution::Uniform => cx.tr("Uniform").to_owned(),
        SkyDistribution::Cie(sky) => format!("CIE {}: {}", sky.number(), cx.tr(sky.name())),
        SkyDistribution::Perez(_) => cx.tr("From weather (Perez)").to_owned(),
    }
}

/// What is done to a sun, a sky or a picture as a whole.
pub(super) fn buttons(ui: &mut Ui, cx: &mut PanelContext, lamp: &SceneLight) {
    match lamp.light.kind {
        LightKind::Directional { direction, .. } => sun_buttons(ui, cx, lamp, -direction),
        LightKind::Environment(environment) => match environment.source {
            EnvironmentSource::Sky(sky) => {
                sky_buttons(ui, cx, lamp, &environment, sky);
                ui.separator();
                weather(ui, cx, lamp.id, &environment, &sky);
            }
            EnvironmentSource::Picture { texture, .. } => {
                let texture = cx.app.document.textures.get(texture as usize);
                let path = texture.map_or("", |t| t.path.as_str());
                picture_buttons(ui, cx, lamp.id, path);
            }
        },
        _ => {}
    }
}

fn sun_buttons(ui: &mut Ui, cx: &mut PanelContext, lamp: &SceneLight, toward: DVec3) {
    if !ui.button(cx.tr("Use clear-sky irradiance")).clicked() {
        return;
    }
    let document = &cx.app.document;
    let clear = document
        .daylight_units()
        .clear_sun(document.compass(toward).altitude);
    let mut light = lamp.light.clone();
    if let LightKind::Directional { irradiance, .. } = &mut light.kind {
        *irradiance = Rgb::grey(clear);
    }
    cx.edit(Edit::SetLight(lamp.id, light));
}

fn sky_buttons(
    ui: &mut Ui,
    cx: &mut PanelContext,
    lamp: &SceneLight,
    environment: &Environment,
    sky: Sky,
) {
    let document = &cx.app.document;
    let old = document.sky_settings(environment, &sky);
    let mut new = old;
    ui.horizontal_wrapped(|ui| {
        if let SkyDistribution::Cie(kind) = sky.distribution
            && ui.button(cx.tr("Use typical irradiance")).clicked()
        {
            let units = document.daylight_units();
            let typical = units.cie_sky(kind.number(), Some(sky.toward_sun), None);
            new.irradiance = typical.map_or(old.irradiance, |sky| sky.diffuse_horizontal());
        }
        if let Some((sun, _)) = document.first_sun()
            && ui.button(cx.tr("Align with sun")).clicked()
        {
            new.toward = sun;
        }
    });
    if new != old {
        let kind = LightKind::Environment(Environment {
            source: EnvironmentSource::Sky(document.sky_of(environment, &new)),
            ..*environment
        });
        let name = lamp.light.name.clone();
        cx.edit(Edit::SetLight(lamp.id, Light { name, kind }));
    }
}

/// Weather to make a sky of. The weather of a sky is not stored with it, so the fields show what
/// was typed last.
fn weather(ui: &mut Ui, cx: &mut PanelContext, lamp: ItemId, around: &Environment, sky: &Sky) {
    let draft = Id::unique(("weather", lamp));
    let mut typed: PerezWeather = ui.data(|d| d.get_temp(draft)).unwrap_or(CLEAR_DAY);
    ui.strong(cx.tr("Weather data"));
    Grid::new("weather").num_columns(2).show(ui, |ui| {
        let irradiance = 0.0..=1_500.0;
        let name = cx.tr("Direct normal irradiance");
        quantity_row(ui, name, &mut typed.dni, irradiance.clone(), " W/m²");
        let name = cx.tr("Diffuse horizontal irradiance");
        quantity_row(ui, name, &mut typed.dhi, irradiance, " W/m²");
        quantity_row(
            ui,
            cx.tr("Dew point"),
            &mut typed.dew_point,
            -60.0..=40.0,
            " °C",
        );
        let day = DragValue::new(&mut typed.day_of_year).range(1..=366);
        inputs::labelled_row(ui, cx.tr("Day of the year"), day);
    });
    ui.data_mut(|d| d.insert_temp(draft, typed));
    if ui.button(cx.tr("Create sky from weather")).clicked() {
        let toward = around.world_from_environment * sky.toward_sun;
        typed.sun_altitude = cx.app.document.compass(toward).altitude;
        cx.edit(Edit::SetWeather(lamp, typed));
    }
}

fn picture_buttons(ui: &mut Ui, cx: &mut PanelContext, lamp: ItemId, path: &str) {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    ui.weak(file);
    ui.horizontal_wrapped(|ui| {
        if ui.button(cx.tr("Change image…")).clicked() {
            cx.send(Command::RequestFile(FileRequest::Environment(Some(lamp))));
        }
        if ui.button(cx.tr("Extract the sun")).clicked() {
            cx.edit(Edit::ExtractSun(lamp));
        }
    });
}
