//! How bright the sun and the sky are, in the unit of a scene.

use azulejo_scene::environment::upright;
use azulejo_scene::sky::{PerezWeather, SUN_HALF_ANGLE, Sky, SkyError};
use azulejo_scene::{LightKind, Rgb, Up};
use glam::DVec3;
use std::fmt;

/// Luminous efficacy of equal-energy white as Radiance has it, lm/W: between photometric skies and
/// radiometric scenes.
const WHITE_EFFICACY: f64 = 179.0;

/// Luminous efficacy of direct sunlight of a clear sky, lm/W of solar radiation: what the model of
/// Perez et al. (*Modeling daylight availability and irradiance components*, Solar Energy 44(5), 1990)
/// gives for clear skies, 100 to 105.
const SUNLIGHT_EFFICACY: f64 = 103.0;

/// The solar constant, W/m².
const SOLAR_CONSTANT: f64 = 1367.0;

/// Illuminance of level ground under an overcast sky of which nothing else is known, lx.
const OVERCAST_ILLUMINANCE: f64 = 10_000.0;

/// Turbidity of a clear sky, as in `gensky`.
const TURBIDITY: f64 = 2.45;

/// Reflectance of the ground below a sky, if none is given.
pub const GROUND_REFLECTANCE: f64 = 0.2;

/// What the light of suns and skies is measured in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DaylightUnits {
    /// Lux, as in photometric scenes; otherwise W/m².
    pub photometric: bool,
    /// All of the sun's radiation in W/m², not only its light.
    pub solar: bool,
}

impl DaylightUnits {
    /// A photometric quantity in the scene's unit.
    fn scene_units(self, lux: f64) -> f64 {
        if self.photometric {
            lux
        } else {
            lux / WHITE_EFFICACY
        }
    }

    /// Irradiance of what faces the sun under a clear sky: 1367 · 0.7^(m^0.678), with the air mass m
    /// of Kasten and Young (Meinel and Meinel, *Applied Solar Energy*, 1976). 0 below the horizon.
    ///
    /// `altitude`: of the sun, radians.
    pub fn clear_sun(self, altitude: f64) -> f64 {
        if altitude <= 0.0 {
            return 0.0;
        }
        let degrees = altitude.to_degrees();
        let air_mass = 1.0 / (altitude.sin() + 0.50572 * (degrees + 6.07995).powf(-1.6364));
        let watts = SOLAR_CONSTANT * 0.7f64.powf(air_mass.powf(0.678));
        if self.solar {
            watts
        } else {
            self.scene_units(watts * SUNLIGHT_EFFICACY)
        }
    }

    /// A CIE standard general sky of a type in 1..=16, black below the horizon.
    ///
    /// `toward_sun`: unit, in the sky's frame; only overcast types do without. `irradiance`: of
    /// level ground by the sky alone; without it the sky is as bright as Radiance's `gensky` has it
    /// for a turbidity of 2.45, or gives 10,000 lx if there is no sun either.
    ///
    /// # Errors
    /// [`DaylightError`].
    pub fn cie_sky(
        self,
        number: u8,
        toward_sun: Option<DVec3>,
        irradiance: Option<f64>,
    ) -> Result<Sky, DaylightError> {
        let is_overcast = matches!(number, 1 | 3 | 5 | 16);
        let Some(sun) = toward_sun.or(is_overcast.then_some(DVec3::Z)) else {
            return Err(DaylightError::NoSun(number));
        };
        let sky = match (irradiance, toward_sun) {
            (Some(irradiance), _) => Sky::cie(number, sun, irradiance),
            (None, _) if self.solar => return Err(DaylightError::NoBrightness(number)),
            (None, None) => Sky::cie(number, sun, self.scene_units(OVERCAST_ILLUMINANCE)),
            (None, Some(sun)) => Sky::cie_typical(number, sun, TURBIDITY).map(|sky| Sky {
                scale: self.scene_units(sky.scale),
                ..sky
            }),
        };
        sky.map_err(DaylightError::Sky)
    }

    /// The sky of weather, black below the horizon, and the irradiance of what faces the sun.
    ///
    /// `toward_sun`: unit, in the sky's frame; its altitude is that of the weather.
    pub fn perez_sky(self, weather: &PerezWeather, toward_sun: DVec3) -> (Sky, f64) {
        let azimuth = toward_sun.x.atan2(toward_sun.y);
        if self.solar {
            (weather.sky_in_solar_watts(azimuth), weather.dni)
        } else {
            let sky = weather.sky_in_lux(azimuth);
            let scale = self.scene_units(sky.scale);
            let direct = self.scene_units(weather.direct_normal_illuminance());
            (Sky { scale, ..sky }, direct)
        }
    }
}

/// The sun as a light, a disc of 0.533°.
///
/// `toward`: unit, toward it in the sky's frame; `north` as for
/// [`Environment::sky`](azulejo_scene::Environment::sky), radians; `irradiance`: of what faces it.
pub fn sun_light(toward: DVec3, up: Up, north: f64, irradiance: f64) -> LightKind {
    LightKind::Directional {
        direction: -(upright(up, north) * toward),
        irradiance: Rgb::grey(irradiance),
        half_angle: SUN_HALF_ANGLE,
    }
}

/// Why there is no such sky.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DaylightError {
    /// This CIE type is brightest around the sun, whose place is not known.
    NoSun(u8),
    /// How bright this CIE type is in solar W/m² is not known.
    NoBrightness(u8),
    /// A type or a quantity out of range.
    Sky(SkyError),
}

impl fmt::Display for DaylightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DaylightError::NoSun(number) => write!(
                f,
                "the CIE sky {number} is brightest around the sun, whose place is not known"
            ),
            DaylightError::NoBrightness(number) => write!(
                f,
                "how bright the CIE sky {number} is in solar W/m² is not known"
            ),
            DaylightError::Sky(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for DaylightError {}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::sky::direction_from;

    const LUX: DaylightUnits = DaylightUnits {
        photometric: true,
        solar: false,
    };
    const WATTS: DaylightUnits = DaylightUnits {
        photometric: false,
        solar: false,
    };

    #[test]
    fn suns_and_skies_of_watts_are_those_of_lux_by_the_efficacy_of_white() {
        let sun = direction_from(1.0, 0.6);
        assert!((LUX.clear_sun(0.6) / WATTS.clear_sun(0.6) - WHITE_EFFICACY).abs() < 1e-9);
        let [lux, watts] = [LUX, WATTS].map(|units| {
            let sky = units.cie_sky(12, Some(sun), None).unwrap();
            sky.diffuse_horizontal()
        });
        assert!((lux / watts - WHITE_EFFICACY).abs() < 1e-6, "{lux} {watts}");
        assert_eq!(WATTS.clear_sun(-0.1), 0.0);
    }

    #[test]
    fn an_overcast_sky_needs_no_sun_and_a_clear_one_does() {
        let overcast = LUX.cie_sky(1, None, None).unwrap();
        assert!((overcast.diffuse_horizontal() - OVERCAST_ILLUMINANCE).abs() < 1e-6);
        assert_eq!(LUX.cie_sky(12, None, None), Err(DaylightError::NoSun(12)));
        let solar = DaylightUnits {
            solar: true,
            ..WATTS
        };
        let unknown = solar.cie_sky(12, Some(DVec3::Z), None);
        assert_eq!(unknown, Err(DaylightError::NoBrightness(12)));
        let wrong = LUX.cie_sky(17, Some(DVec3::Z), None);
        assert!(wrong.unwrap_err().to_string().contains("17"));
    }

    #[test]
    fn the_sun_shines_away_from_where_it_stands() {
        let west = direction_from(270f64.to_radians(), 0.0);
        let LightKind::Directional { direction, .. } = sun_light(west, Up::Y, 0.0, 1.0) else {
            panic!("the sun is a directional light")
        };
        assert!(direction.distance(DVec3::X) < 1e-12, "{direction}");
    }
}
