//! The CIE standard general sky.

use super::{SkyError, angle_between, gradation};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Gradation a, b and indicatrix c, d, e of the types 1 to 15. ISO 15469:2004 / CIE S 011, table 1.
const TYPES: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.0],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// The type of the traditional overcast sky, which has a formula of its own.
pub(super) const TRADITIONAL_OVERCAST: u8 = 16;

/// Descriptions of the types in the standard, shortened.
const NAMES: [&str; 16] = [
    "overcast",
    "overcast, brighter toward the sun",
    "overcast, moderate gradation",
    "overcast, moderate gradation, brighter toward the sun",
    "uniform",
    "partly cloudy, no gradation, brighter toward the sun",
    "partly cloudy, no gradation, bright around the sun",
    "partly cloudy, no gradation, solar corona",
    "partly cloudy, sun obscured",
    "partly cloudy, bright around the sun",
    "white-blue, solar corona",
    "clear",
    "clear, polluted air",
    "cloudless, turbid, broad solar corona",
    "white-blue, turbid, broad solar corona",
    "overcast of 1955",
];

/// One of the 16 types of the CIE standard general sky, ISO 15469:2004 / CIE S 011/E:2003.
///
/// 1 to 5 are overcast (5 uniform), 6 to 10 partly cloudy, 11 to 15 clear (12 the usual one), and
/// 16 is the overcast sky of 1955 (Moon and Spencer).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CieSky {
    /// 1..=16.
    number: u8,
}

impl CieSky {
    /// The sky of a type.
    ///
    /// # Errors
    /// [`SkyError::UnknownType`] if `number` is not in 1..=16.
    pub fn new(number: u8) -> Result<CieSky, SkyError> {
        if (1..=TRADITIONAL_OVERCAST).contains(&number) {
            Ok(CieSky { number })
        } else {
            Err(SkyError::UnknownType(number))
        }
    }

    /// The number of the type, 1..=16.
    pub const fn number(self) -> u8 {
        self.number
    }

    /// What the standard calls the type, in short; 16 is "overcast of 1955".
    pub const fn name(self) -> &'static str {
        NAMES[self.number as usize - 1]
    }

    /// All types in the order of their numbers.
    pub fn all() -> impl Iterator<Item = CieSky> {
        (1..=TRADITIONAL_OVERCAST).map(|number| CieSky { number })
    }

    /// f(χ) φ(Z), for 16 (1 + 2 cos Z)/3: what luminance is proportional to. Positive.
    ///
    /// `direction`, `toward_sun`: unit, z up; `direction` at or above the horizon.
    pub fn relative(self, direction: DVec3, toward_sun: DVec3) -> f64 {
        let Some(&[a, b, c, d, e]) = TYPES.get(usize::from(self.number) - 1) else {
            return (1.0 + 2.0 * direction.z.max(0.0)) / 3.0;
        };
        let mut indicatrix = 1.0;
        if c != 0.0 {
            let chi = angle_between(direction, toward_sun);
            let cos_chi = direction.dot(toward_sun);
            indicatrix += c * ((d * chi).exp() - (d * FRAC_PI_2).exp()) + e * cos_chi * cos_chi;
        }
        indicatrix * gradation(a, b, direction.z)
    }

    /// Luminance of a direction over that of the zenith. Arguments as for [`Self::relative`].
    pub fn relative_to_zenith(self, direction: DVec3, toward_sun: DVec3) -> f64 {
        self.relative(direction, toward_sun) / self.relative(DVec3::Z, toward_sun)
    }

    /// Luminance of the zenith in cd/m² as Radiance's `gensky` assumes it where none is given.
    ///
    /// `altitude`: of the sun, radians; `turbidity`: Linke's, 2.45 by default in `gensky`. With
    /// overcast types it depends on the altitude alone, with clear ones on both; partly cloudy
    /// types take the mean. At least 0.
    pub fn typical_zenith_luminance(self, altitude: f64, turbidity: f64) -> f64 {
        let overcast = 8.6 * altitude.sin() + 0.123;
        let clear = (1.376 * turbidity - 1.81) * altitude.tan() + 0.38;
        let kilocandelas = match self.cloudiness() {
            Cloudiness::Overcast => overcast,
            Cloudiness::Partly => 0.5 * (overcast + clear),
            Cloudiness::Clear => clear,
        };
        1e3 * kilocandelas.max(0.0)
    }

    pub(super) const fn cloudiness(self) -> Cloudiness {
        match self.number {
            6..=10 => Cloudiness::Partly,
            11..=15 => Cloudiness::Clear,
            _ => Cloudiness::Overcast,
        }
    }
}

/// How much of the sky is behind clouds, as far as the luminance of the zenith asks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cloudiness {
    Overcast,
    Partly,
    Clear,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::direction_from;

    #[test]
    fn values_that_others_publish() {
        // The documentation of Python's colour-science: Z 45°, the sun at Z 30°, opposite sides.
        let direction = direction_from(180f64.to_radians(), 45f64.to_radians());
        let sun = direction_from(0.0, 60f64.to_radians());
        let check = |number, expected: f64| {
            let sky = CieSky::new(number).unwrap();
            let value = sky.relative_to_zenith(direction, sun);
            assert!((value - expected).abs() < 1e-7, "type {number}: {value}");
        };
        check(1, 0.832_584_6);
        check(12, 0.454_452_4);
    }

    #[test]
    fn no_type_is_dark_anywhere_or_jumps_at_the_horizon() {
        for number in 1..=16 {
            let sky = CieSky::new(number).unwrap();
            for sun in [-20f64, 0.0, 45.0, 90.0].map(|a| direction_from(1.0, a.to_radians())) {
                for degrees in 0..360 {
                    let azimuth = f64::from(degrees).to_radians();
                    let horizon = sky.relative(direction_from(azimuth, 0.0), sun);
                    let above = sky.relative(direction_from(azimuth, 1e-7), sun);
                    assert!(horizon > 0.0 && horizon.is_finite(), "type {number}");
                    assert!((above / horizon - 1.0).abs() < 1e-5, "type {number}");
                    let middle = sky.relative(direction_from(azimuth, 0.7), sun);
                    assert!(middle > 0.0, "type {number}");
                }
            }
        }
    }

    #[test]
    fn zenith_of_gensky() {
        // gensky -ang 40 0 of Radiance 6.0a with -c, -s and -i, times the 203 lm/W it divides by.
        let altitude = 40f64.to_radians();
        let check = |number, expected: f64| {
            let sky = CieSky::new(number).unwrap();
            let luminance = sky.typical_zenith_luminance(altitude, 2.45) / 203.0;
            assert!(
                (luminance / expected - 1.0).abs() < 2e-4,
                "type {number}: {luminance}"
            );
        };
        check(16, 27.84);
        check(12, 8.325);
        check(7, 18.08);
        let night = CieSky::new(16).unwrap();
        assert!(night.typical_zenith_luminance(-0.5, 2.45).abs() < 1e-300);
    }

    #[test]
    fn there_are_sixteen_types() {
        assert_eq!(CieSky::new(0), Err(SkyError::UnknownType(0)));
        assert_eq!(CieSky::new(17), Err(SkyError::UnknownType(17)));
        assert!((1..=16).all(|n| CieSky::new(n).map(CieSky::number) == Ok(n)));
    }
}
