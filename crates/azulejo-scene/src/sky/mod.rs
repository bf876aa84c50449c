//! Skies as functions of direction: the CIE standard general sky, the all-weather sky of Perez, and
//! where the sun stands.
//!
//! Formulas alone: nothing here knows a scene. The sky's frame has x east, y north and z up;
//! azimuths are clockwise from north as seen from above, altitudes are above the horizon, both in
//! radians except where a name ends with `deg`. A [`Sky`] is in whatever unit its `scale` has:
//! W/(sr m²) or cd/m².
//!
//! ```
//! use azulejo_scene::sky::{Sky, direction_from};
//!
//! // A clear sky that gives 12,000 lx on level ground, the sun in the south at 40 degrees.
//! let sun = direction_from(std::f64::consts::PI, 40f64.to_radians());
//! let sky = Sky::cie(12, sun, 12_000.0).unwrap();
//! assert!((sky.diffuse_horizontal() - 12_000.0).abs() < 1e-6);
//! assert!(sky.radiance(sun) > sky.radiance(glam::DVec3::Z));
//! ```

mod cie;
mod patches;
mod perez;
mod quadrature;
mod sun_position;

#[cfg(test)]
mod tests;

pub use cie::CieSky;
pub use patches::SkyDivision;
pub use perez::{PerezSky, PerezWeather, TYPICAL_DEW_POINT};
pub use sun_position::{
    SUN_HALF_ANGLE, SUN_SOLID_ANGLE, SunPosition, radiance_sun_position, sun_position,
};

use cie::Cloudiness;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

/// How the luminance of a sky is distributed over the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkyDistribution {
    /// The same everywhere; its relative luminance is 1.
    Uniform,
    /// A type of the CIE standard general sky.
    Cie(CieSky),
    /// The all-weather sky of Perez, Seals and Michalsky.
    Perez(PerezSky),
}

impl SkyDistribution {
    /// What radiance is proportional to; never negative.
    ///
    /// `direction`, `toward_sun`: unit, in the sky's frame; `direction` at or above the horizon.
    pub fn relative(&self, direction: DVec3, toward_sun: DVec3) -> f64 {
        match self {
            SkyDistribution::Uniform => 1.0,
            SkyDistribution::Cie(sky) => sky.relative(direction, toward_sun),
            SkyDistribution::Perez(sky) => sky.relative(direction, toward_sun),
        }
    }

    /// ∫ [`Self::relative`] cos Z dω over the upper hemisphere, for the unit direction
    /// `toward_sun`.
    ///
    /// Exact if uniform and for CIE type 16; otherwise by quadrature, relative error below 1e-8.
    /// Only where Perez's indicatrix turns negative, with irradiances that no weather has, it may
    /// reach 1e-3.
    pub fn horizontal(&self, toward_sun: DVec3) -> f64 {
        let edge = match self {
            SkyDistribution::Uniform => return PI,
            SkyDistribution::Cie(sky) if sky.number() == cie::TRADITIONAL_OVERCAST => {
                return 7.0 * PI / 9.0;
            }
            SkyDistribution::Cie(_) => None,
            SkyDistribution::Perez(sky) => sky.dark_from(),
        };
        let sun_zenith = angle_between(DVec3::Z, toward_sun);
        let sun = DVec3::new(sun_zenith.sin(), 0.0, sun_zenith.cos());
        quadrature::horizontal_irradiance(sun_zenith, edge, |direction| {
            self.relative(direction, sun)
        })
    }
}

/// The sky as a light at infinity, without the sun's disc, and the ground below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// How its radiance is distributed.
    pub distribution: SkyDistribution,
    /// Unit direction to the sun in the sky's frame, x east, y north, z up; may be below the
    /// horizon.
    pub toward_sun: DVec3,
    /// Radiance or luminance per unit of the distribution's relative luminance, at least 0.
    pub scale: f64,
    /// Radiance or luminance of what lies below the horizon, same unit, at least 0.
    pub ground: f64,
}

impl Sky {
    /// The same radiance everywhere above the horizon, black below; irradiance of level ground is π
    /// times it.
    pub const fn uniform(radiance: f64) -> Sky {
        Sky {
            distribution: SkyDistribution::Uniform,
            toward_sun: DVec3::Z,
            scale: radiance,
            ground: 0.0,
        }
    }

    /// A CIE standard general sky that gives level ground the irradiance or illuminance
    /// `diffuse_horizontal`, without the sun; black below the horizon.
    ///
    /// `number`: type 1..=16, see [`CieSky`]. `toward_sun`: any length but 0; types 1, 3, 5 and 16
    /// do not depend on it. A sun below the horizon is allowed with all types.
    ///
    /// # Errors
    /// [`SkyError::UnknownType`], [`SkyError::Direction`], [`SkyError::Quantity`] if
    /// `diffuse_horizontal` is negative or not finite.
    pub fn cie(number: u8, toward_sun: DVec3, diffuse_horizontal: f64) -> Result<Sky, SkyError> {
        let sky = Sky::cie_of_scale(number, toward_sun, 1.0)?;
        let scale = checked_quantity(diffuse_horizontal)? / sky.diffuse_horizontal();
        Ok(Sky { scale, ..sky })
    }

    /// A CIE standard general sky in cd/m² as bright as Radiance's `gensky` assumes where it is not
    /// told; black below the horizon.
    ///
    /// `number` and `toward_sun` as for [`Self::cie`]; `turbidity`: Linke's, 2.45 in `gensky`. A
    /// zenith luminance that grows with the tangent of the sun's altitude has no limit, so with
    /// types 6 to 15 the sun is kept at 87° at most, in the distribution too. `gensky` itself
    /// divides by 203 lm/W.
    ///
    /// # Errors
    /// [`SkyError::UnknownType`], [`SkyError::Direction`], [`SkyError::Quantity`] if `turbidity` is
    /// negative or not finite.
    pub fn cie_typical(number: u8, toward_sun: DVec3, turbidity: f64) -> Result<Sky, SkyError> {
        let kind = CieSky::new(number)?;
        let mut toward_sun = checked_direction(toward_sun)?;
        let turbidity = checked_quantity(turbidity)?;
        let mut altitude = FRAC_PI_2 - angle_between(DVec3::Z, toward_sun);
        let highest = 87f64.to_radians();
        if altitude > highest && kind.cloudiness() != Cloudiness::Overcast {
            altitude = highest;
            toward_sun = direction_from(toward_sun.x.atan2(toward_sun.y), altitude);
        }
        let zenith = kind.typical_zenith_luminance(altitude, turbidity);
        let scale = zenith / kind.relative(DVec3::Z, toward_sun);
        Sky::cie_of_scale(number, toward_sun, scale)
    }

    /// An all-weather sky that gives level ground the irradiance or illuminance
    /// `diffuse_horizontal`; black below the horizon. Uniform if the distribution is 0 everywhere.
    ///
    /// `toward_sun`: unit. [`PerezWeather::sky`] has it from weather.
    pub fn perez(sky: PerezSky, toward_sun: DVec3, diffuse_horizontal: f64) -> Sky {
        let distribution = SkyDistribution::Perez(sky);
        let relative = distribution.horizontal(toward_sun);
        if relative > 1e-6 && relative.is_finite() {
            let scale = diffuse_horizontal / relative;
            return Sky {
                distribution,
                toward_sun,
                scale,
                ground: 0.0,
            };
        }
        Sky {
            toward_sun,
            ..Sky::uniform(diffuse_horizontal / PI)
        }
    }

    /// This sky above diffuse ground of a `reflectance` in 0..=1, which is lit by all of the sky
    /// and by a sun whose irradiance of level ground is `beam_horizontal`: its radiance is ρ E / π.
    #[must_use]
    pub fn with_ground(self, reflectance: f64, beam_horizontal: f64) -> Sky {
        let ground = reflectance * (self.diffuse_horizontal() + beam_horizontal) / PI;
        Sky { ground, ..self }
    }

    /// A sky of this distribution around another sun, as bright on level ground as before; its
    /// ground stays. `toward_sun`: unit.
    #[must_use]
    pub fn with_sun(self, toward_sun: DVec3) -> Sky {
        Sky { toward_sun, ..self }.with_diffuse_horizontal(self.diffuse_horizontal())
    }

    /// This sky, scaled to give level ground this irradiance, at least 0; its ground stays. A
    /// distribution that is 0 everywhere becomes uniform.
    #[must_use]
    pub fn with_diffuse_horizontal(self, irradiance: f64) -> Sky {
        let relative = self.distribution.horizontal(self.toward_sun);
        if relative > 0.0 {
            let scale = irradiance / relative;
            return Sky { scale, ..self };
        }
        Sky {
            distribution: SkyDistribution::Uniform,
            scale: irradiance / PI,
            ..self
        }
    }

    /// Radiance from a direction, unit, in the sky's frame; `ground` below the horizon.
    pub fn radiance(&self, direction: DVec3) -> f64 {
        if direction.z < 0.0 {
            self.ground
        } else {
            self.scale * self.distribution.relative(direction, self.toward_sun)
        }
    }

    /// Irradiance of level ground by the sky alone: ∫ L cos Z dω over the upper hemisphere. For
    /// accuracy see [`SkyDistribution::horizontal`]; takes some thousand evaluations of the
    /// distribution.
    pub fn diffuse_horizontal(&self) -> f64 {
        self.scale * self.distribution.horizontal(self.toward_sun)
    }

    fn cie_of_scale(number: u8, toward_sun: DVec3, scale: f64) -> Result<Sky, SkyError> {
        Ok(Sky {
            distribution: SkyDistribution::Cie(CieSky::new(number)?),
            toward_sun: checked_direction(toward_sun)?,
            scale,
            ground: 0.0,
        })
    }
}

/// The unit direction of an azimuth, clockwise from north, and an altitude, both radians, in the
/// sky's frame: x east, y north, z up.
pub fn direction_from(azimuth: f64, altitude: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
    let (sin_altitude, cos_altitude) = altitude.sin_cos();
    DVec3::new(
        sin_azimuth * cos_altitude,
        cos_azimuth * cos_altitude,
        sin_altitude,
    )
}

/// The angle between two unit vectors, 0..=π, exact where an arc cosine loses half of its digits.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    if a.dot(b) > 0.0 {
        2.0 * (0.5 * (a - b).length()).min(1.0).asin()
    } else {
        PI - 2.0 * (0.5 * (a + b).length()).min(1.0).asin()
    }
}

/// φ(Z) = 1 + a exp(b / cos Z); at the horizon its limit, 1 for negative b.
fn gradation(a: f64, b: f64, cos_z: f64) -> f64 {
    if a == 0.0 {
        return 1.0;
    }
    1.0 + a * (b / cos_z.max(f64::MIN_POSITIVE)).exp()
}

fn checked_direction(direction: DVec3) -> Result<DVec3, SkyError> {
    (direction.try_normalize()).ok_or(SkyError::Direction(direction.to_array()))
}

fn checked_quantity(value: f64) -> Result<f64, SkyError> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(SkyError::Quantity(value))
    }
}

/// Why there is no such sky or sun.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SkyError {
    /// The CIE standard has the types 1 to 15, and 16 is the overcast sky of 1955.
    UnknownType(u8),
    /// The direction to the sun is zero or not finite.
    Direction([f64; 3]),
    /// An irradiance, illuminance or turbidity that is negative or not finite.
    Quantity(f64),
    /// A latitude beyond 90 degrees.
    Latitude(f64),
    /// A longitude beyond 180 degrees.
    Longitude(f64),
    /// A time that is not finite or farther than 30,000 years from 1970, or a zone that is not finite.
    Time(f64),
}

impl fmt::Display for SkyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SkyError::UnknownType(number) => write!(
                f,
                "no CIE sky has the type {number}: there are 1 to 15, and 16, the overcast of 1955"
            ),
            SkyError::Direction([x, y, z]) => {
                write!(f, "{x} {y} {z} is not a direction to the sun")
            }
            SkyError::Quantity(value) => write!(
                f,
                "{value} is not an irradiance, illuminance or turbidity: these are finite and not negative"
            ),
            SkyError::Latitude(degrees) => {
                write!(f, "the latitude {degrees} is not within -90 to 90 degrees")
            }
            SkyError::Longitude(degrees) => write!(
                f,
                "the longitude {degrees} is not within -180 to 180 degrees"
            ),
            SkyError::Time(value) => write!(
                f,
                "the time {value} is not finite, or farther than 30,000 years from 1970"
            ),
        }
    }
}

impl std::error::Error for SkyError {}
