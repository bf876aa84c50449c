//! Light from outside: `--sun`, `--sky`, `--environment` and `--background`, and `--studio`.

pub mod args;

use crate::failure::Failure;
use crate::session::Session;
use args::{GroundArg, Site, SkyArg, SunArg, SurroundingsArgs};
use azulejo::models;
use azulejo::surroundings::{
    DaylightError, DaylightUnits, GROUND_REFLECTANCE, SurroundingPicture, WeatherFile, extract_sun,
    is_studio_part, limit_paint, modelled_ground, studio, sun_light,
};
use azulejo_scene::environment::upright;
use azulejo_scene::sky::{
    PerezWeather, Sky, SkyDistribution, SunPosition, TYPICAL_DEW_POINT, direction_from,
};
use azulejo_scene::{
    Environment, EnvironmentSource, Light, LightKind, Rgb, Scene, SceneBackground, TextureId,
};
use azulejo_trace::Tracer;
use glam::DVec3;
use jiff::Timestamp;
use jiff::tz::{Offset, TimeZone};
use std::borrow::Cow;
use std::path::Path;

/// Adds the light from outside that the options give. `instant` is that of `--time`.
pub fn add(
    scene: &mut Scene,
    args: &SurroundingsArgs,
    site: Option<Site>,
    instant: Option<Timestamp>,
    session: &mut Session,
) -> Result<(), Failure> {
    let (mut args, mut site) = (Cow::Borrowed(args), site);
    if let Some(path) = &args.weather {
        let weather = weather(path, instant, session)?;
        site = site.or(Some(weather.site));
        args.to_mut().sky = Some(weather.sky);
    }
    let args = &*args;
    let has_clock = site.is_some() && instant.is_some();
    if args.has_sky() || has_clock {
        Daylight::new(scene, args, site, instant)?.add(scene, session)?;
    } else if instant.is_some() || site.is_some() {
        let missing = if site.is_some() {
            "--time"
        } else {
            "--place LAT,LON"
        };
        return Err(Failure::misuse(format_args!(
            "the sun's position needs both a place and an instant: {missing} is missing"
        )));
    }
    if let Some(path) = &args.environment {
        let mut environment = environment(scene, path, session)?;
        let turn = args.environment_rotate.to_radians() + args.north.to_radians();
        environment.world_from_environment = upright(scene.units.up, turn);
        environment.scale = Rgb::grey(args.environment_strength);
        if args.extract_sun {
            take_sun_out(scene, &environment, session);
        }
        push(scene, "environment", LightKind::Environment(environment));
        scene.background = None;
    }
    if let Some(what) = &args.background {
        scene.background = Some(match crate::values::vector(what) {
            Ok(color) if color.min_element() >= 0.0 => Rgb::from(color.to_array()).into(),
            Ok(_) => return Err(Failure::misuse("--background: a radiance is below 0")),
            Err(_) => SceneBackground::Environment(environment(scene, what.as_ref(), session)?),
        });
    }
    if args.studio {
        add_studio(scene, session)?;
    }
    Ok(())
}

/// The place of a weather file, and its sky at an instant.
struct WeatherAt {
    site: Site,
    sky: SkyArg,
}

/// Reads a weather file.
pub fn read_weather(path: &Path) -> Result<WeatherFile, Failure> {
    let bytes = models::read_bytes(path)?;
    let file = WeatherFile::read(&String::from_utf8_lossy(&bytes));
    file.map_err(|e| Failure::failed(format_args!("{}: {e}", path.display())))
}

/// Finds the weather of an instant.
fn weather(
    path: &Path,
    instant: Option<Timestamp>,
    session: &mut Session,
) -> Result<WeatherAt, Failure> {
    let Some(instant) = instant else {
        return Err(Failure::misuse(
            "--weather: the weather is that of an instant: give --time, as in 2025-06-21T14:00+02:00",
        ));
    };
    let failed = |words: String| Failure::failed(format_args!("{}: {words}", path.display()));
    let file = read_weather(path)?;
    // Files count hours of local standard time.
    let ahead = (file.time_zone * 3600.0).round() as i32;
    let offset = Offset::from_seconds(ahead).map_err(|e| failed(e.to_string()))?;
    let local = offset.to_datetime(instant);
    let hour = f64::from(local.hour()) + f64::from(local.minute()) / 60.0;
    let record = file.record(local.month() as u8, local.day() as u8, hour);
    let when = local.strftime("%-d %B, %H:%M");
    let record = record.ok_or_else(|| {
        let hours = file.records().len();
        failed(format!(
            "it has no record of {when} (UTC{offset}), and {hours} of other hours"
        ))
    })?;
    let (Some(dni), Some(dhi)) = (record.direct_normal, record.diffuse_horizontal) else {
        return Err(failed(format!(
            "the irradiance by sun and sky is missing on {when} (UTC{offset})"
        )));
    };
    session.tell(&format!(
        "weather of {} on {when} (UTC{offset}): {dni} W/m² direct normal, {dhi} W/m² diffuse horizontal",
        file.city
    ));
    Ok(WeatherAt {
        site: Site::new(file.latitude, file.longitude),
        sky: SkyArg::Perez {
            dni,
            dhi,
            dew_point: record.dew_point,
        },
    })
}

/// Puts the scene into a studio; its camera is for scenes that have none.
fn add_studio(scene: &mut Scene, session: &mut Session) -> Result<(), Failure> {
    if scene.has_lightmap() {
        return Err(Failure::misuse(
            "--studio: the model shows the light of its lightmap, which lamps would not change: leave out \
             --studio, or remove the lightmap with bake --strip",
        ));
    }
    if scene
        .objects
        .iter()
        .any(|object| is_studio_part(&object.name))
    {
        session.note("--studio: the scene is in a studio already");
        return Ok(());
    }
    if scene.has_light() {
        session.note("--studio: the scene has light of its own, which shines too");
    }
    let limited = limit_paint(scene);
    if limited > 0 {
        session.note(&format!(
            "--studio: materials that reflect more light than any paint are taken to reflect 90%: {limited}"
        ));
    }
    if let Some(mut around) = studio(scene, &Tracer::new(scene)) {
        if !scene.cameras.is_empty() {
            around.cameras.clear();
        }
        scene.merge(around);
    }
    Ok(())
}

/// Reads a picture of the surroundings, and adds it to the scene's textures.
fn environment(
    scene: &mut Scene,
    path: &Path,
    session: &mut Session,
) -> Result<Environment, Failure> {
    let (picture, warnings) = SurroundingPicture::read(path)?;
    warnings.iter().for_each(|warning| session.note(warning));
    let texture = scene.textures.len() as TextureId;
    scene.textures.push(picture.texture);
    let up = scene.units.up;
    Ok(Environment::picture(texture, picture.projection, up))
}

/// Replaces the sun in the picture of an environment by a light, or says that there is none.
fn take_sun_out(scene: &mut Scene, environment: &Environment, session: &mut Session) {
    let EnvironmentSource::Picture {
        texture,
        projection,
    } = environment.source
    else {
        return;
    };
    let Some(image) = &mut scene.textures[texture as usize].image else {
        return;
    };
    match extract_sun(image, projection) {
        Err(why) => session.note(&format!("--extract-sun: no sun found: {why}")),
        Ok(extracted) => {
            let irradiance = extracted.irradiance * environment.scale;
            let at = SunPosition::of(extracted.toward);
            session.tell(&format!(
                "the sun of the picture stands at azimuth {:.1}°, elevation {:.1}° \
                 of the picture: {} pixels of {:.2}°, irradiance {:.4} of what faces it",
                at.azimuth.to_degrees(),
                at.altitude.to_degrees(),
                extracted.pixels,
                2.0 * extracted.half_angle.to_degrees(),
                irradiance.mean()
            ));
            let kind = LightKind::Directional {
                direction: -(environment.world_from_environment * extracted.toward).normalize(),
                irradiance,
                half_angle: extracted.half_angle,
            };
            push(scene, "sun", kind);
        }
    }
}

fn push(scene: &mut Scene, name: &str, kind: LightKind) {
    let name = name.to_owned();
    scene.lights.push(Light { name, kind });
}

/// The sun that the options give.
#[derive(Default)]
struct AskedSun {
    /// Unit, toward it, in the sky's frame.
    toward: Option<DVec3>,
    /// Irradiance of what faces it.
    irradiance: Option<f64>,
    /// Day of the year, from 1.
    day: Option<u32>,
}

/// The sun and the sky to add.
struct Daylight {
    sky: Option<Sky>,
    /// Unit, toward the sun in the sky's frame, and its irradiance.
    sun: Option<(DVec3, f64)>,
    /// Radians clockwise.
    north: f64,
    ground: Option<GroundArg>,
    /// Whether the sun is below the horizon.
    is_night: bool,
    /// What to say.
    notes: Vec<String>,
}

impl Daylight {
    fn new(
        scene: &Scene,
        args: &SurroundingsArgs,
        site: Option<Site>,
        instant: Option<Timestamp>,
    ) -> Result<Daylight, Failure> {
        let mut daylight = Daylight {
            sky: None,
            sun: None,
            north: args.north.to_radians(),
            ground: args.ground,
            is_night: false,
            notes: Vec::new(),
        };
        let AskedSun {
            toward,
            irradiance: given,
            day,
        } = daylight.requested_sun(scene, args, site, instant)?;
        let units = DaylightUnits {
            photometric: scene.units.photometric,
            solar: args.solar,
        };
        let altitude = toward.map(|d| d.z.clamp(-1.0, 1.0).asin());
        let mut beam = altitude.map(|a| units.clear_sun(a));
        match args.sky {
            None => {}
            Some(SkyArg::Uniform(radiance)) => daylight.sky = Some(Sky::uniform(radiance)),
            Some(SkyArg::Cie(kind, irradiance)) => {
                daylight.sky = Some(units.cie_sky(kind, toward, irradiance)?);
                // Overcast and partly cloudy skies hide the sun unless it is requested.
                let is_clear = (11..=15).contains(&kind);
                beam = beam.filter(|_| is_clear || args.sun.is_some());
            }
            Some(SkyArg::Perez {
                dni,
                dhi,
                dew_point,
            }) => {
                let (Some(toward), Some(altitude)) = (toward, altitude) else {
                    return Err(Failure::misuse(
                        "--sky perez: needs the sun: give --sun AZ,EL, or --place LAT,LON and --time",
                    ));
                };
                let weather = PerezWeather {
                    dni,
                    dhi,
                    sun_altitude: altitude,
                    day_of_year: day.unwrap_or(80),
                    dew_point: dew_point.unwrap_or(TYPICAL_DEW_POINT),
                };
                let (sky, direct) = units.perez_sky(&weather, toward);
                daylight.sky = Some(sky);
                beam = Some(direct);
            }
        }
        let irradiance = given.or(beam).filter(|_| args.sun != Some(SunArg::Off));
        if let (Some(toward), Some(irradiance)) = (toward, irradiance) {
            if toward.z <= 0.0 {
                daylight.is_night = true;
            } else if irradiance > 0.0 {
                daylight.sun = Some((toward, irradiance));
            }
        }
        Ok(daylight)
    }

    /// Where the sun stands, and what is said of it.
    fn requested_sun(
        &mut self,
        scene: &Scene,
        args: &SurroundingsArgs,
        site: Option<Site>,
        instant: Option<Timestamp>,
    ) -> Result<AskedSun, Failure> {
        // A direction needs neither place nor instant; an instant of --sun precedes that of --time.
        let (instant, given) = match &args.sun {
            Some(SunArg::Toward(place, irradiance)) => {
                let turn = upright(scene.units.up, self.north).conjugate();
                return Ok(AskedSun {
                    toward: Some(place.toward(|d| turn * d)),
                    irradiance: *irradiance,
                    day: instant.map(day_of_year),
                });
            }
            Some(SunArg::At(instant, irradiance)) => (Some(*instant), *irradiance),
            Some(SunArg::Irradiance(irradiance)) => (instant, Some(*irradiance)),
            Some(SunArg::Off) | None => (instant, None),
        };
        // Place and instant belong together; both may be absent only where the sun is not needed.
        let (site, instant) = match (site, instant) {
            (Some(site), Some(instant)) => (site, instant),
            (None, None) if matches!(args.sun, Some(SunArg::Off) | None) => {
                return Ok(AskedSun::default());
            }
            (None, _) => {
                return Err(Failure::misuse(
                    "where the sun stands depends on the place: give --place LAT,LON, or --sun AZ,EL",
                ));
            }
            (Some(_), None) => {
                return Err(Failure::misuse(
                    "where the sun stands depends on the instant: give --time, as in \
                     2025-06-21T14:00+02:00",
                ));
            }
        };
        // State the position, by which a mistake in place or time zone shows.
        let at: SunPosition = site.sun(instant).map_err(Failure::misuse)?;
        self.notes.push(format!(
            "the sun stands at azimuth {:.1}°, elevation {:.1}°",
            at.azimuth.to_degrees(),
            at.altitude.to_degrees()
        ));
        Ok(AskedSun {
            toward: Some(direction_from(at.azimuth, at.altitude)),
            irradiance: given,
            day: Some(day_of_year(instant)),
        })
    }

    fn add(mut self, scene: &mut Scene, session: &mut Session) -> Result<(), Failure> {
        let beam = self.sun.map_or(0.0, |(toward, e)| e * toward.z.max(0.0));
        let has_ground = modelled_ground(scene);
        let reflectance = match (self.ground, &has_ground) {
            (Some(GroundArg::None), _) => 0.0,
            (Some(GroundArg::Reflectance(share)), Some(name)) => {
                session.note(&format!(
                    "--ground: \"{name}\" is a ground already, and the light of both is added: \
                     --ground none leaves out the one below the horizon"
                ));
                share
            }
            (Some(GroundArg::Reflectance(share)), None) => share,
            (None, _) if self.sky.is_some() => GROUND_REFLECTANCE,
            (None, _) => 0.0,
        };
        if self.sky.is_none() && reflectance > 0.0 {
            self.sky = Some(Sky::uniform(0.0));
        }
        if let Some(sky) = self.sky {
            let sky = sky.with_ground(reflectance, beam);
            let what = kind_of(&sky);
            self.notes.push(format!(
                "{what}: {:.4} on level ground, {:.4} with the sun",
                sky.diffuse_horizontal(),
                sky.diffuse_horizontal() + beam
            ));
            let environment = Environment::sky(sky, scene.units.up, self.north);
            push(scene, "sky", LightKind::Environment(environment));
            scene.background = None;
        }
        if let Some((toward, irradiance)) = self.sun {
            let kind = sun_light(toward, scene.units.up, self.north, irradiance);
            push(scene, "sun", kind);
        }
        if self.is_night {
            session.note("the sun is below the horizon: it does not shine");
        }
        self.notes.iter().for_each(|note| session.tell(note));
        Ok(())
    }
}

fn kind_of(sky: &Sky) -> String {
    match sky.distribution {
        SkyDistribution::Uniform => "uniform sky".into(),
        SkyDistribution::Cie(sky) => format!("CIE sky {}", sky.number()),
        SkyDistribution::Perez(_) => "sky of Perez".into(),
    }
}

fn day_of_year(instant: Timestamp) -> u32 {
    instant.to_zoned(TimeZone::UTC).day_of_year() as u32
}

/// What is missing, with the options that give it.
impl From<DaylightError> for Failure {
    fn from(error: DaylightError) -> Failure {
        match error {
            DaylightError::NoSun(kind) => Failure::misuse(format_args!(
                "--sky cie:{kind}: is brightest around the sun: give --sun AZ,EL, or --place LAT,LON \
                 and --time"
            )),
            DaylightError::NoBrightness(kind) => Failure::misuse(format_args!(
                "--sky cie:{kind}: how bright it is in solar W/m² is not known: give it, as in \
                 cie:{kind},150"
            )),
            other => Failure::misuse(other),
        }
    }
}
