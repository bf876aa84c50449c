//! Steps `light ...`: what the one selected light becomes.

use super::fields::{finite, number, numbers, one_of, path, split, vector};
use super::step::{StepResult, commands};
use crate::app::App;
use crate::command::Command;
use crate::document::{Edit, SceneLight, SkySettings};
use azulejo::scene::sky::{CieSky, PerezWeather, SkyDistribution, SunPosition, TYPICAL_DEW_POINT};
use azulejo::scene::{Environment, EnvironmentSource, LightKind, Rgb};
use glam::DVec3;

/// Parses what follows `light`.
pub(super) fn parse(text: &str) -> StepResult {
    use LightKind::{Directional, Point, Spot};
    let (word, rest) = split(text);
    match word {
        "color" => set(vector(rest), |_, kind, c| {
            assign(color(kind), Rgb::from(c.to_array()))
        }),
        "position" => set(vector(rest), |_, kind, to| match kind {
            Point { position, .. } | Spot { position, .. } => assign(position, to),
            _ => false,
        }),
        "direction" => set(direction(rest), |_, kind, to| match kind {
            Spot { direction, .. } | Directional { direction, .. } => assign(direction, to),
            _ => false,
        }),
        "cone" => set(numbers::<2>(rest), |_, kind, degrees| {
            let [from, to] = degrees.map(f64::to_radians);
            match kind {
                Spot { inner, outer, .. } => assign(inner, from) && assign(outer, to),
                _ => false,
            }
        }),
        "sun" => set(numbers(rest), move_sun),
        "size" => set(number(rest), |_, kind, degrees| match kind {
            Directional { half_angle, .. } => assign(half_angle, 0.5 * degrees.to_radians()),
            _ => false,
        }),
        "sky" => set_sky(distribution(rest), |sky, kind| sky.distribution = kind),
        "level" => set_sky(number(rest), |sky, level| sky.irradiance = level),
        "ground" => set_sky(number(rest), |sky, share| sky.reflectance = share),
        "weather" => {
            let weather = weather(rest)?;
            edit(move |app, lamp| {
                let (_, settings) = sky(app, &lamp.light.kind).ok_or(NO_SUCH_PROPERTY)?;
                let sun_altitude = app.document.compass(settings.toward).altitude;
                let weather = PerezWeather {
                    sun_altitude,
                    ..weather
                };
                Ok(Command::Edit(Edit::SetWeather(lamp.id, weather), None))
            })
        }
        "picture" => {
            let path = path("light picture", rest)?;
            edit(|_, lamp| Ok(Command::LoadEnvironment(path, Some(lamp.id))))
        }
        "rotation" => set(number(rest), |app, kind, degrees| match kind {
            LightKind::Environment(environment) => {
                let up = app.document.units.up;
                let turned = environment.with_north(up, degrees.to_radians());
                assign(environment, turned)
            }
            _ => false,
        }),
        "extract-sun" => edit(|_, lamp| Ok(Command::Edit(Edit::ExtractSun(lamp.id), None))),
        other => Err(format!(
            "light \"{other}\", expected color, position, direction, cone, sun, size, sky, level, \
             ground, weather, picture, rotation or extract-sun"
        )),
    }
}

const NO_SUCH_PROPERTY: &str = "a light of this kind has no such property";

/// A step that makes one command for the selected light.
fn edit(make: impl FnOnce(&App, &SceneLight) -> Result<Command, String> + 'static) -> StepResult {
    Ok(commands(|app| Ok(vec![make(app, selected_light(app)?)?])))
}

/// A step that changes the selected light by a value; `change` returns whether lights of this kind have
/// the property.
fn set<T: 'static>(
    value: Result<T, String>,
    change: impl FnOnce(&App, &mut LightKind, T) -> bool + 'static,
) -> StepResult {
    let value = value?;
    edit(move |app, lamp| {
        let mut light = lamp.light.clone();
        if !change(app, &mut light.kind, value) {
            return Err(NO_SUCH_PROPERTY.into());
        }
        Ok(Command::Edit(Edit::SetLight(lamp.id, light), None))
    })
}

/// A step that changes the selected sky by a value.
fn set_sky<T: 'static>(
    value: Result<T, String>,
    change: impl FnOnce(&mut SkySettings, T) + 'static,
) -> StepResult {
    set(value, |app, kind, value| {
        let Some((mut environment, mut settings)) = sky(app, kind) else {
            return false;
        };
        change(&mut settings, value);
        environment.source = EnvironmentSource::Sky(app.document.sky_of(&environment, &settings));
        assign(kind, LightKind::Environment(environment))
    })
}

fn assign<T>(place: &mut T, value: T) -> bool {
    *place = value;
    true
}

/// Moves a sun, or that of a sky, to azimuth and elevation in degrees.
fn move_sun(app: &App, kind: &mut LightKind, degrees: [f64; 2]) -> bool {
    let [azimuth, altitude] = degrees.map(f64::to_radians);
    let toward = app.document.toward(SunPosition { altitude, azimuth });
    if let LightKind::Directional { direction, .. } = kind {
        return assign(direction, -toward);
    }
    let Some((mut environment, settings)) = sky(app, kind) else {
        return false;
    };
    let settings = SkySettings { toward, ..settings };
    environment.source = EnvironmentSource::Sky(app.document.sky_of(&environment, &settings));
    assign(kind, LightKind::Environment(environment))
}

fn direction(text: &str) -> Result<DVec3, String> {
    let direction = vector(text)?.try_normalize();
    direction.ok_or_else(|| "the direction has no length".to_owned())
}

fn distribution(text: &str) -> Result<SkyDistribution, String> {
    let mut skies = vec![SkyDistribution::Uniform];
    skies.extend(CieSky::all().map(SkyDistribution::Cie));
    one_of("sky", text, &skies, |sky| match sky {
        SkyDistribution::Cie(sky) => sky.number().to_string(),
        _ => "uniform".to_owned(),
    })
}

fn weather(text: &str) -> Result<PerezWeather, String> {
    let (dni, dhi, dew_point, day) = match finite(text).as_deref() {
        Some([dni, dhi]) => (*dni, *dhi, TYPICAL_DEW_POINT, 80.0),
        Some([dni, dhi, dew_point, day]) => (*dni, *dhi, *dew_point, *day),
        _ => return Err(format!("\"{text}\" is not 2 or 4 numbers")),
    };
    Ok(PerezWeather {
        dni,
        dhi,
        sun_altitude: 0.0,
        day_of_year: day.clamp(1.0, 366.0) as u32,
        dew_point,
    })
}

fn selected_light(app: &App) -> Result<&SceneLight, String> {
    let light = match app.selection.ids[..] {
        [id] => app.document.light(id),
        _ => None,
    };
    light.ok_or_else(|| "no single light is selected".to_owned())
}

fn sky(app: &App, kind: &LightKind) -> Option<(Environment, SkySettings)> {
    let LightKind::Environment(environment) = kind else {
        return None;
    };
    let EnvironmentSource::Sky(sky) = environment.source else {
        return None;
    };
    Some((*environment, app.document.sky_settings(environment, &sky)))
}

/// The quantity that says how bright a light is, and in which colour.
fn color(kind: &mut LightKind) -> &mut Rgb {
    match kind {
        LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => intensity,
        LightKind::Luminaire { scale, .. } => scale,
        LightKind::Directional { irradiance, .. } => irradiance,
        LightKind::Ambient { radiance } => radiance,
        LightKind::Environment(environment) => &mut environment.scale,
    }
}
