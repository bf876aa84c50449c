//! Where the sun stands, and how large it is.

use super::{SkyError, direction_from};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Half of the angle under which the disc of the sun appears: 0.2665°, in radians; the mean over
/// the year.
pub const SUN_HALF_ANGLE: f64 = 0.2665 * PI / 180.0;

/// Solid angle of the disc of the sun, 2π (1 − cos [`SUN_HALF_ANGLE`]), in steradians. Its radiance
/// is the irradiance of the beam on a surface facing it, divided by this.
pub const SUN_SOLID_ANGLE: f64 = 6.796_702_357_296_812e-5;

/// Times from here on either side of 1970 are refused, seconds: 30,000 years, while the series are
/// meant for centuries.
const FARTHEST_SECONDS: f64 = 1e12;

/// Where the sun's centre stands, without refraction by the air, which lifts a sun at the horizon
/// by 0.5°.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Angle above the horizon, radians, −π/2..=π/2.
    pub altitude: f64,
    /// Angle clockwise from north as seen from above, radians, 0..2π: east is π/2.
    pub azimuth: f64,
}

impl SunPosition {
    /// The position in a unit direction of the sky's frame: the inverse of [`Self::toward`]. The
    /// azimuth of the zenith and the nadir is 0.
    pub fn of(toward: DVec3) -> SunPosition {
        SunPosition {
            // An arc sine would lose half of the digits near the zenith.
            altitude: toward.z.atan2(toward.x.hypot(toward.y)),
            azimuth: toward.x.atan2(toward.y).rem_euclid(TAU),
        }
    }

    /// The unit direction towards the sun in the sky's frame: x east, y north, z up.
    pub fn toward(self) -> DVec3 {
        direction_from(self.azimuth, self.altitude)
    }

    /// Whether the sun's centre is above the horizon.
    pub fn is_up(self) -> bool {
        self.altitude > 0.0
    }
}

/// Where the sun stands at an instant, seen from a place on the earth.
///
/// `unix_seconds`: seconds since 1970-01-01T00:00Z without leap seconds; `latitude_deg`: −90..=90,
/// north positive; `longitude_east_deg`: −180..=180, east positive. Within 0.02° of NREL's SPA in
/// the years 1950 to 2100. Meeus, *Astronomical Algorithms*, the series of low precision, as NOAA's
/// solar calculator uses it.
///
/// # Errors
/// [`SkyError::Latitude`], [`SkyError::Longitude`] beyond their ranges, [`SkyError::Time`] if it is
/// not finite or farther than 30,000 years.
///
/// ```
/// use azulejo_scene::sky::sun_position;
///
/// // Greenwich at noon of the summer solstice, 2024-06-20T12:00Z.
/// let sun = sun_position(1_718_884_800.0, 51.48, 0.0).unwrap();
/// assert!((sun.altitude.to_degrees() - 61.95).abs() < 0.02);
/// assert!((sun.azimuth.to_degrees() - 179.17).abs() < 0.02);
/// ```
pub fn sun_position(
    unix_seconds: f64,
    latitude_deg: f64,
    longitude_east_deg: f64,
) -> Result<SunPosition, SkyError> {
    checked_place(latitude_deg, longitude_east_deg)?;
    if !unix_seconds.is_finite() || unix_seconds.abs() > FARTHEST_SECONDS {
        return Err(SkyError::Time(unix_seconds));
    }
    let julian_date = 2_440_587.5 + unix_seconds / 86_400.0;
    let (declination, equation_of_time) = sun_of_date((julian_date - 2_451_545.0) / 36_525.0);
    let utc_minutes = unix_seconds.rem_euclid(86_400.0) / 60.0;
    let solar_hours = (utc_minutes + equation_of_time + 4.0 * longitude_east_deg) / 60.0;
    Ok(horizontal_position(declination, solar_hours, latitude_deg))
}

/// The sun's declination in radians and the equation of time in minutes, `t` Julian centuries after
/// the epoch J2000.
fn sun_of_date(t: f64) -> (f64, f64) {
    let sin = |degrees: f64| degrees.to_radians().sin();
    let cos = |degrees: f64| degrees.to_radians().cos();
    let mean_longitude = 280.46646 + t * (36_000.769_83 + 0.000_303_2 * t);
    let anomaly = 357.52911 + t * (35_999.050_29 - 0.000_153_7 * t);
    let eccentricity = 0.016_708_634 - t * (0.000_042_037 + 0.000_000_126_7 * t);
    let centre = sin(anomaly) * (1.914_602 - t * (0.004_817 + 0.000_014 * t))
        + sin(2.0 * anomaly) * (0.019_993 - 0.000_101 * t)
        + 0.000_289 * sin(3.0 * anomaly);
    let node = 125.04 - 1_934.136 * t;
    let longitude = mean_longitude + centre - 0.005_69 - 0.004_78 * sin(node);
    let arc_seconds = 21.448 - t * (46.815 + t * (0.000_59 - 0.001_813 * t));
    let obliquity = 23.0 + (26.0 + arc_seconds / 60.0) / 60.0 + 0.002_56 * cos(node);
    let declination = (sin(obliquity) * sin(longitude)).clamp(-1.0, 1.0).asin();

    let y = (0.5 * obliquity).to_radians().tan().powi(2);
    let angle = y * sin(2.0 * mean_longitude) - 2.0 * eccentricity * sin(anomaly)
        + 4.0 * eccentricity * y * sin(anomaly) * cos(2.0 * mean_longitude)
        - 0.5 * y * y * sin(4.0 * mean_longitude)
        - 1.25 * eccentricity * eccentricity * sin(2.0 * anomaly);
    // The earth turns by a degree in four minutes.
    (declination, 4.0 * angle.to_degrees())
}

/// Where Radiance's `gensky` (without a year) and `gendaymtx` put the sun: up to 1° from where it
/// is, but without it no sky compares with theirs.
///
/// `day_of_year`: 1 for the first of January, as Radiance counts it; `local_hour`: standard time of
/// the zone `zone_hours_east`, 0..=24; places as for [`sun_position`]. The formulas of the IES
/// lighting handbook.
///
/// # Errors
/// [`SkyError::Latitude`], [`SkyError::Longitude`] beyond their ranges, [`SkyError::Time`] if hour
/// or zone is not finite.
pub fn radiance_sun_position(
    day_of_year: u32,
    local_hour: f64,
    latitude_deg: f64,
    longitude_east_deg: f64,
    zone_hours_east: f64,
) -> Result<SunPosition, SkyError> {
    checked_place(latitude_deg, longitude_east_deg)?;
    if !(local_hour + zone_hours_east).is_finite() {
        return Err(SkyError::Time(local_hour + zone_hours_east));
    }
    let day = f64::from(day_of_year);
    let declination = 0.4093 * (TAU * (day - 81.0) / 365.0).sin();
    let equation_of_time = 0.170 * (2.0 * TAU * (day - 80.0) / 373.0).sin()
        - 0.129 * (TAU * (day - 8.0) / 355.0).sin();
    let solar_hours = local_hour + equation_of_time + longitude_east_deg / 15.0 - zone_hours_east;
    Ok(horizontal_position(declination, solar_hours, latitude_deg))
}

fn checked_place(latitude_deg: f64, longitude_east_deg: f64) -> Result<(), SkyError> {
    if !(-90.0..=90.0).contains(&latitude_deg) {
        return Err(SkyError::Latitude(latitude_deg));
    }
    if !(-180.0..=180.0).contains(&longitude_east_deg) {
        return Err(SkyError::Longitude(longitude_east_deg));
    }
    Ok(())
}

/// The position above the horizon of what has this declination (radians) at this true solar time
/// (hours, 12 when it is in the meridian; any multiple of a day may be added).
fn horizontal_position(declination: f64, solar_hours: f64, latitude_deg: f64) -> SunPosition {
    let (sin_h, cos_h) = (PI * (solar_hours.rem_euclid(24.0) - 12.0) / 12.0).sin_cos();
    let (sin_latitude, cos_latitude) = latitude_deg.to_radians().sin_cos();
    let (sin_dec, cos_dec) = declination.sin_cos();
    let east = -sin_h * cos_dec;
    let north = cos_latitude * sin_dec - sin_latitude * cos_dec * cos_h;
    let up = sin_latitude * sin_dec + cos_latitude * cos_dec * cos_h;
    let azimuth = east.atan2(north);
    SunPosition {
        // As exact near the zenith as elsewhere, unlike an arc sine.
        altitude: up.atan2(east.hypot(north)).clamp(-FRAC_PI_2, FRAC_PI_2),
        // Just west of north, a full turn added may round to a full turn.
        azimuth: if azimuth < 0.0 {
            (azimuth + TAU) % TAU
        } else {
            azimuth
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_is_as_large_as_its_angle() {
        // 2π (1 − cos a) without the cancellation.
        let exact = 4.0 * PI * (0.5 * SUN_HALF_ANGLE).sin().powi(2);
        assert!((SUN_SOLID_ANGLE / exact - 1.0).abs() < 1e-12, "{exact:e}");
    }

    #[test]
    fn solstices_and_poles() {
        let check = |unix_seconds, latitude, altitude: f64, tolerance: f64| {
            let sun = sun_position(unix_seconds, latitude, 0.0).unwrap();
            assert!(
                (sun.altitude.to_degrees() - altitude).abs() < tolerance,
                "{latitude}: {sun:?}"
            );
        };
        // 2024-06-20T20:51Z and 2024-12-21T09:21Z: the poles see the obliquity of the ecliptic.
        let (june, december) = (1_718_916_660.0, 1_734_772_860.0);
        check(june, 90.0, 23.436, 0.01);
        check(june, -90.0, -23.436, 0.01);
        check(december, 90.0, -23.436, 0.01);
        check(december, -90.0, 23.436, 0.01);
        // 2025-03-20T12:07Z, three hours past the equinox, the sun nearly in the meridian of
        // Greenwich.
        check(1_742_472_420.0, 0.0, 90.0, 0.15);
    }

    #[test]
    fn east_in_the_morning_west_in_the_evening() {
        let morning = sun_position(1_718_884_800.0 - 5.0 * 3600.0, 48.0, 0.0).unwrap();
        let evening = sun_position(1_718_884_800.0 + 5.0 * 3600.0, 48.0, 0.0).unwrap();
        assert!(morning.azimuth < PI && morning.toward().x > 0.0);
        assert!(evening.azimuth > PI && evening.toward().x < 0.0);
        assert!(morning.is_up() && (morning.toward().length() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_sun_of_radiance() {
        // Directions that gensky of Radiance 6.0a prints for these days and hours.
        let check = |day, hour, expected: [f64; 3]| {
            let sun = radiance_sun_position(day, hour, 37.42, -122.05, -8.0).unwrap();
            let off = (sun.toward() - DVec3::from_array(expected)).length();
            assert!(off < 1e-6, "day {day}: {:?}", sun.toward());
        };
        check(80, 9.5, [0.661_303, -0.461_387, 0.591_439]);
        check(172, 12.5, [-0.081_542, -0.239_191, 0.967_542]);
        check(273, 7.75, [0.891_479, -0.325_199, 0.315_454]);
        check(355, 15.5, [-0.714_257, -0.665_907, 0.215_420]);
    }

    #[test]
    fn places_and_times_that_are_none() {
        let at = sun_position;
        assert_eq!(at(0.0, 90.5, 0.0), Err(SkyError::Latitude(90.5)));
        assert_eq!(at(0.0, 0.0, -180.5), Err(SkyError::Longitude(-180.5)));
        assert!(matches!(at(0.0, f64::NAN, 0.0), Err(SkyError::Latitude(_))));
        assert!(matches!(
            at(f64::INFINITY, 0.0, 0.0),
            Err(SkyError::Time(_))
        ));
        assert!(radiance_sun_position(1, f64::NAN, 0.0, 0.0, 0.0).is_err());
        // Absurd but finite: no panic, and numbers.
        assert!(matches!(at(1e300, 45.0, 180.0), Err(SkyError::Time(_))));
        assert!(at(-1e12, -90.0, -180.0).unwrap().toward().is_finite());
    }
}
