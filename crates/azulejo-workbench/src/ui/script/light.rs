//! Steps `light ...`: what the one selected light becomes.

use super::fields::{finite, number, numbers, one_of, path, split, vector};
use crate::app::App;
use crate::command::Command;
use crate::document::{Edit, SceneLight, SkySettings};
use azulejo::scene::sky::{CieSky, PerezWeather, SkyDistribution, SunPosition, TYPICAL_DEW_POINT};
use azulejo::scene::{Environment, EnvironmentSource, Light, LightKind, Rgb};
use glam::DVec3;
use std::path::PathBuf;

/// What a step `light ...` does.
#[derive(Clone, Debug, PartialEq)]
pub enum LightStep {
    /// `color R G B`: intensity, irradiance or radiance; of skies and pictures a factor.
    Color(DVec3),
    /// `position X Y Z`: of points and spots.
    Position(DVec3),
    /// `direction X Y Z`: of spots and suns.
    Direction(DVec3),
    /// `cone INNER OUTER`: half angles of a spot, degrees.
    Cone(f64, f64),
    /// `sun AZIMUTH ELEVATION`: the place of a sun, or of a sky's, degrees.
    Sun(f64, f64),
    /// `size DEGREES`: the angle that the disc of a sun subtends.
    Size(f64),
    /// `sky uniform`, `sky 1` to `sky 16`: the type of a sky.
    Sky(SkyDistribution),
    /// `level E`: irradiance of level ground by a sky.
    Level(f64),
    /// `ground REFLECTANCE`: of the ground below a sky.
    Ground(f64),
    /// `weather DNI DHI`, `weather DNI DHI DEWPOINT DAY`: makes a sky of weather.
    Weather(PerezWeather),
    /// `picture FILE`: gives an environment another picture.
    Picture(PathBuf),
    /// `rotation DEGREES`: of a picture.
    Rotation(f64),
    /// `extract-sun`: takes the sun out of a picture.
    ExtractSun,
}

/// Parses what follows `light`.
pub(super) fn parse(text: &str) -> Result<LightStep, String> {
    let (word, rest) = split(text);
    Ok(match word {
        "color" => LightStep::Color(vector(rest)?),
        "position" => LightStep::Position(vector(rest)?),
        "direction" => LightStep::Direction(vector(rest)?),
        "cone" => {
            let [inner, outer] = numbers(rest)?;
            LightStep::Cone(inner, outer)
        }
        "sun" => {
            let [azimuth, elevation] = numbers(rest)?;
            LightStep::Sun(azimuth, elevation)
        }
        "size" => LightStep::Size(number(rest)?),
        "sky" => LightStep::Sky(distribution(rest)?),
        "level" => LightStep::Level(number(rest)?),
        "ground" => LightStep::Ground(number(rest)?),
        "weather" => LightStep::Weather(weather(rest)?),
        "picture" => LightStep::Picture(path("light picture", rest)?),
        "rotation" => LightStep::Rotation(number(rest)?),
        "extract-sun" => LightStep::ExtractSun,
        other => {
            return Err(format!(
                "light \"{other}\", expected color, position, direction, cone, sun, size, sky, level, \
                 ground, weather, picture, rotation or extract-sun"
            ));
        }
    })
}

fn distribution(text: &str) -> Result<SkyDistribution, String> {
    let mut all = vec![SkyDistribution::Uniform];
    all.extend(CieSky::all().map(SkyDistribution::Cie));
    one_of("sky", text, &all, |sky| match sky {
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

impl LightStep {
    /// The commands of the step.
    pub(super) fn commands(self, app: &App) -> Result<Vec<Command>, String> {
        let lamp = selected_light(app)?;
        let edit = match self {
            LightStep::Picture(path) => {
                return Ok(vec![Command::LoadEnvironment(path, Some(lamp.id))]);
            }
            LightStep::ExtractSun => Edit::ExtractSun(lamp.id),
            LightStep::Weather(weather) => {
                let (_, settings) = sky(app, &lamp.light.kind)?;
                let sun_altitude = app.document.compass(settings.toward).altitude;
                let weather = PerezWeather {
                    sun_altitude,
                    ..weather
                };
                Edit::SetWeather(lamp.id, weather)
            }
            other => {
                let kind = other.changed(app, lamp.light.kind)?;
                let name = lamp.light.name.clone();
                Edit::SetLight(lamp.id, Light { name, kind })
            }
        };
        Ok(vec![Command::Edit(edit, None)])
    }

    /// The light that a step makes of another.
    fn changed(self, app: &App, mut kind: LightKind) -> Result<LightKind, String> {
        use LightKind::{Directional, Environment, Point, Spot};
        match (self, &mut kind) {
            (LightStep::Color(c), kind) => *color(kind) = Rgb::from(c.to_array()),
            (LightStep::Position(to), Point { position, .. } | Spot { position, .. }) => {
                *position = to;
            }
            (LightStep::Direction(to), Spot { direction, .. } | Directional { direction, .. }) => {
                *direction = to.try_normalize().ok_or("the direction has no length")?;
            }
            (LightStep::Cone(from, to), Spot { inner, outer, .. }) => {
                (*inner, *outer) = (from.to_radians(), to.to_radians());
            }
            (LightStep::Sun(azimuth, elevation), Directional { direction, .. }) => {
                *direction = -toward(app, azimuth, elevation);
            }
            (LightStep::Size(degrees), Directional { half_angle, .. }) => {
                *half_angle = 0.5 * degrees.to_radians();
            }
            (LightStep::Rotation(degrees), Environment(environment)) => {
                let up = app.document.units.up;
                *environment = environment.with_north(up, degrees.to_radians());
            }
            (step, kind) => return step.changed_sky(app, kind),
        }
        Ok(kind)
    }

    fn changed_sky(self, app: &App, kind: &LightKind) -> Result<LightKind, String> {
        let (mut environment, mut settings) = sky(app, kind)?;
        match self {
            LightStep::Sun(azimuth, elevation) => {
                settings.toward = toward(app, azimuth, elevation);
            }
            LightStep::Sky(distribution) => settings.distribution = distribution,
            LightStep::Level(irradiance) => settings.irradiance = irradiance,
            LightStep::Ground(reflectance) => settings.reflectance = reflectance,
            _ => return Err("a light of this kind has no such property".into()),
        }
        environment.source = EnvironmentSource::Sky(app.document.sky_of(&environment, &settings));
        Ok(LightKind::Environment(environment))
    }
}

fn selected_light(app: &App) -> Result<&SceneLight, String> {
    let light = match app.selection.ids[..] {
        [id] => app.document.light(id),
        _ => None,
    };
    light.ok_or_else(|| "no single light is selected".to_owned())
}

fn sky(app: &App, kind: &LightKind) -> Result<(Environment, SkySettings), String> {
    if let LightKind::Environment(environment) = kind
        && let EnvironmentSource::Sky(sky) = environment.source
    {
        return Ok((*environment, app.document.sky_settings(environment, &sky)));
    }
    Err("a light of this kind has no such property".into())
}

fn toward(app: &App, azimuth: f64, elevation: f64) -> DVec3 {
    app.document.toward(SunPosition {
        altitude: elevation.to_radians(),
        azimuth: azimuth.to_radians(),
    })
}

/// The quantity that says how bright a light is, and in which colour.
fn color(kind: &mut LightKind) -> &mut Rgb {
    match kind {
        LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => intensity,
        LightKind::Directional { irradiance, .. } => irradiance,
        LightKind::Ambient { radiance } => radiance,
        LightKind::Environment(environment) => &mut environment.scale,
    }
}
