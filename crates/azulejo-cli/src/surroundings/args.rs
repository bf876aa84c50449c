//! Options of light from outside, as typed.

use crate::values::{instant, not_negative, number, numbers};
use azulejo_scene::sky::{SunPosition, direction_from, sun_position};
use clap::{Args, ValueHint};
use glam::DVec3;
use jiff::Timestamp;
use std::path::PathBuf;

/// Light from outside, added to that of the scene.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Light from outside")]
pub struct SurroundingsArgs {
    /// The sun, as AZ,EL[,E]: azimuth clockwise from north and elevation in degrees, and irradiance;
    /// or dir:X,Y,Z[,E], a date and time, E alone, or off
    ///
    /// It is a disc of 0.533°. E is the irradiance of a surface that faces it, in W/m², or lx in
    /// photometric scenes; without it, that of a clear sky. dir:X,Y,Z is the direction toward the sun. A
    /// date and time, as in 2025-06-21T14:00+02:00, need --place; E alone needs --place and --time.
    #[arg(long, value_name = "SUN", value_parser = sun, allow_hyphen_values = true)]
    pub sun: Option<SunArg>,
    /// The sky: a uniform radiance; cie:1 to cie:16, a CIE standard general sky (1 and 16 overcast, 5
    /// uniform, 12 clear); or perez:DNI,DHI[,DEWPOINT] from weather data, in W/m² and °C
    ///
    /// cie:TYPE,E also gives its horizontal irradiance.
    #[arg(long, value_name = "SKY", value_parser = sky, allow_hyphen_values = true)]
    pub sky: Option<SkyArg>,
    /// The sun and the sky (perez) of the instant of --time in a weather file of EnergyPlus (.epw), at its place unless
    /// --place gives another
    ///
    /// Records are means over an hour, which the sun of the instant is taken to give; years do not matter.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "sky")]
    pub weather: Option<PathBuf>,
    /// Reflectance of the ground below the horizon, or none [default with --sky: 0.2]
    #[arg(long, value_name = "SHARE|none", value_parser = ground)]
    pub ground: Option<GroundArg>,
    /// Environment map that lights the scene: .hdr or .exr, twice as wide as high (equirectangular)
    /// or square (angular map); its centre is toward +x
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub environment: Option<PathBuf>,
    /// Rotate --environment clockwise, seen from above, in degrees
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_hyphen_values = true,
          requires = "environment", default_value_t = 0.0)]
    pub environment_rotate: f64,
    /// Factor by which the radiance of --environment is multiplied
    #[arg(long, value_name = "FACTOR", value_parser = not_negative,
          requires = "environment", default_value_t = 1.0)]
    pub environment_strength: f64,
    /// Extract the sun from --environment, as a separate light with sharp shadows: its brightest
    /// part, at most 3 degrees wide
    #[arg(long, requires = "environment")]
    pub extract_sun: bool,
    /// Visible background that does not light the scene: an image as for --environment, or a
    /// radiance R,G,B
    #[arg(long, value_name = "FILE|R,G,B")]
    pub background: Option<String>,
    /// Direction of north, in degrees clockwise, seen from above, from +y (if z is up) or -z (if y
    /// is up)
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_hyphen_values = true,
          default_value_t = 0.0)]
    pub north: f64,
    /// Take weather data and clear skies as total solar radiation in W/m², not as visible light
    #[arg(long)]
    pub solar: bool,
    /// Add studio lighting, besides light sources of the scene: a floor and three lamps around the
    /// model, or a lamp under the ceiling of a room
    ///
    /// A model is a room if the fronts of its walls are seen all around from within. Walls with two sides, whose
    /// fronts mean nothing, are none if the camera of the file sees them from outside, or if nothing is in them.
    #[arg(long)]
    pub studio: bool,
}

impl SurroundingsArgs {
    /// Whether anything of the sky or the sun is asked for.
    pub fn has_sky(&self) -> bool {
        self.sky.is_some() || self.sun.is_some() || self.weather.is_some()
    }
}

/// `--sun`
#[derive(Clone, Debug, PartialEq)]
pub enum SunArg {
    /// In a direction, with its irradiance if that is given.
    Toward(SunPlace, Option<f64>),
    /// Where it stands at an instant.
    At(Timestamp, Option<f64>),
    /// Where it stands at the instant of `--time`.
    Irradiance(f64),
    /// It does not shine.
    Off,
}

/// A direction toward the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunPlace {
    /// By its angles.
    Angles(SunPosition),
    /// In the scene's axes; unit.
    Scene(DVec3),
}

/// `--sky`
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkyArg {
    /// The same radiance everywhere above the horizon.
    Uniform(f64),
    /// A CIE standard general sky, and what it gives level ground.
    Cie(u8, Option<f64>),
    /// By weather: direct normal and diffuse horizontal irradiance, W/m², and the dew point, °C.
    Perez {
        /// Direct normal.
        dni: f64,
        /// Diffuse horizontal.
        dhi: f64,
        /// Of the air.
        dew_point: Option<f64>,
    },
}

/// `--ground`
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroundArg {
    /// Black.
    None,
    /// A diffuse reflectance.
    Reflectance(f64),
}

/// A place on the Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Degrees north.
    latitude: f64,
    /// Degrees east.
    longitude: f64,
}

impl Site {
    /// By degrees north and east.
    pub fn new(latitude: f64, longitude: f64) -> Site {
        Site {
            latitude,
            longitude,
        }
    }

    /// Where the sun stands at an instant.
    pub fn sun(self, instant: Timestamp) -> Result<SunPosition, String> {
        let seconds = instant.as_millisecond() as f64 / 1000.0;
        sun_position(seconds, self.latitude, self.longitude).map_err(|e| e.to_string())
    }
}

/// `LAT,LON` in degrees, north and east positive; `None` if the text is not a pair of numbers.
pub fn site(text: &str) -> Option<Result<Site, String>> {
    let (latitude, longitude) = text.split_once(',')?;
    let (latitude, longitude) = (number(latitude).ok()?, number(longitude).ok()?);
    let is_there = latitude.abs() <= 90.0 && longitude.abs() <= 180.0;
    Some(if is_there {
        Ok(Site::new(latitude, longitude))
    } else {
        Err(format!(
            "{latitude},{longitude} is not a place on Earth: expected a latitude from -90 to 90 and a \
             longitude from -180 to 180, north and east positive"
        ))
    })
}

fn not_below_0(value: f64) -> Result<f64, String> {
    if value >= 0.0 {
        Ok(value)
    } else {
        Err(format!("{value} is below 0"))
    }
}

fn sun(text: &str) -> Result<SunArg, String> {
    if text == "off" {
        return Ok(SunArg::Off);
    }
    let (when, irradiance) = match text.split_once(',') {
        Some((when, rest)) => (when, Some(rest)),
        None => (text, None),
    };
    if let Some(instant) = instant(when) {
        let irradiance = irradiance.map(not_negative).transpose()?;
        return Ok(SunArg::At(instant?, irradiance));
    }
    if let Some(direction) = text.strip_prefix("dir:") {
        let (toward, irradiance) = match numbers(direction)?[..] {
            [x, y, z] => (DVec3::new(x, y, z), None),
            [x, y, z, e] => (DVec3::new(x, y, z), Some(not_below_0(e)?)),
            _ => return Err("expected dir:X,Y,Z or dir:X,Y,Z,E".into()),
        };
        let toward = toward.try_normalize();
        let toward = toward.ok_or("the direction has no length")?;
        return Ok(SunArg::Toward(SunPlace::Scene(toward), irradiance));
    }
    let at = |azimuth: f64, elevation: f64| {
        if elevation.abs() > 90.0 {
            return Err(format!("{elevation} degrees is above the zenith"));
        }
        Ok(SunPlace::Angles(SunPosition {
            azimuth: azimuth.to_radians(),
            altitude: elevation.to_radians(),
        }))
    };
    match numbers(text)?[..] {
        [irradiance] => Ok(SunArg::Irradiance(not_below_0(irradiance)?)),
        [az, el] => Ok(SunArg::Toward(at(az, el)?, None)),
        [az, el, e] => Ok(SunArg::Toward(at(az, el)?, Some(not_below_0(e)?))),
        _ => Err("expected AZ,EL or AZ,EL,E, as in 135,40".into()),
    }
}

fn sky(text: &str) -> Result<SkyArg, String> {
    if let Some(kind) = text.strip_prefix("cie:") {
        let (kind, irradiance) = match kind.split_once(',') {
            Some((kind, irradiance)) => (kind, Some(not_negative(irradiance)?)),
            None => (kind, None),
        };
        return match kind.trim().parse() {
            Ok(kind @ 1..=16) => Ok(SkyArg::Cie(kind, irradiance)),
            _ => Err(format!("\"{kind}\" is not a type of sky, expected 1 to 16")),
        };
    }
    if let Some(weather) = text.strip_prefix("perez:") {
        let (dni, dhi, dew_point) = match numbers(weather)?[..] {
            [dni, dhi] => (dni, dhi, None),
            [dni, dhi, dew_point] => (dni, dhi, Some(dew_point)),
            _ => return Err("expected perez:DNI,DHI, as in perez:600,150".into()),
        };
        let (dni, dhi) = (not_below_0(dni)?, not_below_0(dhi)?);
        return Ok(SkyArg::Perez {
            dni,
            dhi,
            dew_point,
        });
    }
    let radiance = not_negative(text);
    radiance.map(SkyArg::Uniform).map_err(|_| {
        "expected a radiance, cie:TYPE or perez:DNI,DHI, as in cie:12 or perez:600,150".into()
    })
}

fn ground(text: &str) -> Result<GroundArg, String> {
    match text {
        "none" => Ok(GroundArg::None),
        _ => match number(text)? {
            share @ 0.0..=1.0 => Ok(GroundArg::Reflectance(share)),
            share => Err(format!(
                "{share} is not a reflectance, expected 0 to 1 or none"
            )),
        },
    }
}

impl SunPlace {
    /// Unit, toward the sun, in the sky's frame; `to_sky` turns the scene's axes into it.
    pub fn toward(self, to_sky: impl Fn(DVec3) -> DVec3) -> DVec3 {
        match self {
            SunPlace::Angles(at) => direction_from(at.azimuth, at.altitude),
            SunPlace::Scene(toward) => to_sky(toward),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suns() {
        let angles = |text: &str| match sun(text) {
            Ok(SunArg::Toward(SunPlace::Angles(at), e)) => {
                (at.azimuth.to_degrees(), at.altitude.to_degrees(), e)
            }
            other => panic!("{other:?}"),
        };
        let (azimuth, altitude, e) = angles("135,40");
        assert!((azimuth - 135.0).abs() < 1e-9 && (altitude - 40.0).abs() < 1e-9 && e.is_none());
        assert_eq!(angles("-90,5,800").2, Some(800.0));
        assert_eq!(sun("off"), Ok(SunArg::Off));
        assert_eq!(sun("900"), Ok(SunArg::Irradiance(900.0)));
        assert!(matches!(
            sun("dir:0,3,4,7"),
            Ok(SunArg::Toward(SunPlace::Scene(_), Some(7.0)))
        ));
        assert!(matches!(
            sun("2025-06-21T14:00+02:00,5"),
            Ok(SunArg::At(_, Some(5.0)))
        ));
        for wrong in [
            "1,91",
            "dir:0,0,0",
            "1,2,-3",
            "x",
            "1,2,3,4",
            "2025-06-21T14:00",
        ] {
            assert!(sun(wrong).is_err(), "{wrong}");
        }
        assert!(sun("2025-06-21T14:00").unwrap_err().contains("+02:00"));
    }

    #[test]
    fn skies() {
        assert_eq!(sky("2.5"), Ok(SkyArg::Uniform(2.5)));
        assert_eq!(sky("cie:12"), Ok(SkyArg::Cie(12, None)));
        assert_eq!(sky("cie:1,9000"), Ok(SkyArg::Cie(1, Some(9000.0))));
        assert!(matches!(
            sky("perez:600,150"),
            Ok(SkyArg::Perez {
                dew_point: None,
                ..
            })
        ));
        for wrong in [
            "cie:0",
            "cie:17",
            "cie:x",
            "perez:1",
            "perez:-1,2",
            "-1",
            "blue",
        ] {
            assert!(sky(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn places_and_instants() {
        assert!(site("48.14,11.58").unwrap().is_ok());
        assert!(site("91,0").unwrap().is_err());
        assert!(site("chair.obj:scale=1,2,3").is_none());
        let at = instant("2025-06-21T14:00+02:00").unwrap().unwrap();
        assert_eq!(at, instant("2025-06-21T12:00Z").unwrap().unwrap());
        assert!(instant("60s").is_none() && instant("1.5h").is_none());
        // Munich, at noon of midsummer: about 65 degrees high.
        let munich = site("48.14,11.58").unwrap().unwrap();
        let noon = munich.sun("2025-06-21T11:15Z".parse().unwrap()).unwrap();
        assert!((noon.altitude.to_degrees() - 65.3).abs() < 0.2, "{noon:?}");
    }
}
