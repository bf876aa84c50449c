//! Skies against integrals that are known, and against a table of reference values.

use super::*;
use crate::quadrature::gauss_legendre;

/// ∫ relative cos Z dω by a plain rule that knows nothing of the sun but the cut: slow and sure.
fn by_plain_rule(distribution: SkyDistribution, sun: DVec3) -> f64 {
    let rule = gauss_legendre(300);
    let sun_zenith = angle_between(DVec3::Z, sun).min(FRAC_PI_2);
    let mut sum = 0.0;
    for (from, to) in [(0.0, sun_zenith), (sun_zenith, FRAC_PI_2)] {
        for &(x, w) in &rule {
            let z: f64 = from + 0.5 * (to - from) * (1.0 + x);
            for &(y, v) in &rule {
                // Half a turn, azimuths crowded towards the sun's.
                let t = 0.5 * (1.0 + y);
                let azimuth = sun.x.atan2(sun.y) + PI * t.powi(3);
                let direction = direction_from(azimuth, FRAC_PI_2 - z);
                let weight = 0.5 * w * (to - from) * 0.5 * v * 3.0 * PI * t * t;
                sum += weight * z.sin() * z.cos() * distribution.relative(direction, sun);
            }
        }
    }
    2.0 * sum
}

#[test]
fn irradiances_that_are_known() {
    let sky = Sky::uniform(3.0);
    assert!((sky.diffuse_horizontal() - 3.0 * PI).abs() < 1e-14);
    assert_eq!(sky.radiance(DVec3::X), 3.0);
    assert_eq!(sky.radiance(DVec3::new(0.6, 0.0, -0.8)), 0.0);
    let overcast = CieSky::new(16).unwrap();
    let exact = 7.0 * PI / 9.0;
    let integral = quadrature::horizontal_irradiance(0.5, None, |d| overcast.relative(d, DVec3::Z));
    assert!((integral / exact - 1.0).abs() < 1e-12, "{integral}");
    // L = cos Z: 2 π / 3.
    let integral = quadrature::horizontal_irradiance(1.2, None, |d| d.z);
    assert!(
        (integral / (2.0 * PI / 3.0) - 1.0).abs() < 1e-12,
        "{integral}"
    );
    let uniform = Sky::cie(5, DVec3::Y, PI).unwrap();
    assert!((uniform.radiance(DVec3::X) - 1.0).abs() < 1e-12);
}

#[test]
fn integrals_agree_with_a_plain_rule() {
    let check = |distribution, altitude: f64, tolerance: f64| {
        let sun = direction_from(2.0, altitude.to_radians());
        let integral = SkyDistribution::horizontal(&distribution, sun);
        let plain = by_plain_rule(distribution, sun);
        assert!(
            (integral / plain - 1.0).abs() < tolerance,
            "{distribution:?} {altitude}: {integral} {plain}"
        );
    };
    for altitude in [-8.0, 0.0, 0.3, 11.0, 52.0, 89.5, 90.0] {
        for number in [2, 8, 12, 14, 15] {
            check(
                SkyDistribution::Cie(CieSky::new(number).unwrap()),
                altitude,
                1e-8,
            );
        }
    }
    for weather in all_weathers().step_by(37) {
        let coefficients = weather.coefficients();
        let altitude = weather.sun_altitude.to_degrees().clamp(0.0, 87.0);
        if (PerezSky { coefficients }).dark_from().is_none() {
            check(
                SkyDistribution::Perez(PerezSky { coefficients }),
                altitude,
                1e-8,
            );
        }
    }
}

/// Weathers of all bins, brightnesses and altitudes, possible and not.
fn all_weathers() -> impl Iterator<Item = PerezWeather> {
    let altitudes = [-5.0, 0.5, 3.0, 10.0, 25.0, 45.0, 70.0, 90.0];
    let dhis = [0.0, 5.0, 30.0, 90.0, 200.0, 400.0, 1000.0];
    let dnis = [0.0, 10.0, 40.0, 80.0, 150.0, 300.0, 600.0, 1000.0];
    let pairs = dhis
        .into_iter()
        .flat_map(move |dhi| dnis.map(|dni| (dhi, dni)));
    pairs.flat_map(move |(dhi, dni)| {
        altitudes.map(|altitude: f64| PerezWeather {
            dni,
            dhi,
            sun_altitude: altitude.to_radians(),
            day_of_year: 172,
            dew_point: TYPICAL_DEW_POINT,
        })
    })
}

#[test]
fn no_weather_makes_a_sky_negative_or_boundless() {
    for weather in all_weathers() {
        assert!((1.0..=11.9).contains(&weather.clearness()), "{weather:?}");
        assert!((0.01..=0.6).contains(&weather.brightness()), "{weather:?}");
        let sky = weather.sky_in_lux(1.0);
        let given = weather.diffuse_illuminance();
        let expected = if weather.is_night() { 0.0 } else { given };
        assert!(
            (sky.diffuse_horizontal() - expected).abs() <= 1e-9 * expected,
            "{weather:?}"
        );
        for i in 0..90 {
            let direction = direction_from(f64::from(i * 17), f64::from(i).to_radians());
            let radiance = sky.radiance(direction);
            assert!(radiance >= 0.0 && radiance.is_finite(), "{weather:?} {i}");
        }
        assert!(weather.direct_normal_illuminance() >= 0.0);
    }
}

#[test]
fn black_skies() {
    let mut weather = all_weathers().nth(5).unwrap();
    (weather.dhi, weather.dni) = (0.0, 800.0);
    let sun_alone = weather.sky_in_lux(0.0).with_ground(0.2, 500.0);
    assert_eq!(sun_alone.radiance(DVec3::Z), 0.0);
    assert!((sun_alone.ground - 100.0 / PI).abs() < 1e-12);
    weather.dni = 0.0;
    assert!(weather.is_night());
    assert_eq!(weather.sky_in_lux(0.0).with_ground(0.2, 0.0).ground, 0.0);
}

#[test]
fn typical_skies_are_limited_near_the_zenith() {
    let high = Sky::cie_typical(12, DVec3::new(1e-9, 0.0, 1.0), 2.45).unwrap();
    assert!((high.toward_sun.z - 87f64.to_radians().sin()).abs() < 1e-12);
    // gensky -ang 89 20 -s of Radiance 6.0a, times its 203 lm/W.
    assert!((high.radiance(DVec3::Z) / (148.6 * 203.0) - 1.0).abs() < 1e-3);
    let overcast = Sky::cie_typical(16, DVec3::Z, 2.45).unwrap();
    assert!((overcast.radiance(DVec3::Z) - 8723.0).abs() < 1e-9);
}

#[test]
fn what_is_no_sky() {
    let check = |sky: Result<Sky, SkyError>, error: SkyError| assert_eq!(sky, Err(error));
    check(Sky::cie(17, DVec3::Z, 1.0), SkyError::UnknownType(17));
    check(Sky::cie(1, DVec3::ZERO, 1.0), SkyError::Direction([0.0; 3]));
    check(Sky::cie(1, DVec3::Z, -1.0), SkyError::Quantity(-1.0));
    assert!(Sky::cie(1, DVec3::Z, f64::NAN).is_err());
    assert!(Sky::cie_typical(12, DVec3::Z, f64::INFINITY).is_err());
    assert!(SkyError::UnknownType(17).to_string().contains("type 17"));
}

/// A row of the table of reference values.
struct ReferenceRow {
    id: String,
    group: String,
    parameters: String,
    values: Vec<f64>,
    tolerance: String,
}

impl ReferenceRow {
    fn parse(line: &str) -> Option<ReferenceRow> {
        let mut cells = line.split('\t').map(str::to_owned);
        let (id, group, parameters) = (cells.next()?, cells.next()?, cells.next()?);
        let values = cells.next()?;
        let values = values.split(',').map_while(|v| v.parse().ok()).collect();
        Some(ReferenceRow {
            id,
            group,
            parameters,
            values,
            tolerance: cells.nth(1)?,
        })
    }

    fn text(&self, name: &str) -> &str {
        let mut pairs = self.parameters.split(';').filter_map(|p| p.split_once('='));
        let pair = pairs.find(|(n, _)| *n == name);
        pair.unwrap_or_else(|| panic!("{}: no {name}", self.id)).1
    }

    fn number(&self, name: &str) -> f64 {
        self.text(name).parse().unwrap()
    }

    fn sun(&self) -> DVec3 {
        direction_from(0.0, self.number("sun_alt").to_radians())
    }

    fn direction(&self) -> DVec3 {
        direction_from(
            self.number("azimuth_from_sun").to_radians(),
            self.number("alt").to_radians(),
        )
    }

    fn cie(&self) -> CieSky {
        CieSky::new(self.text("type").parse().unwrap()).unwrap()
    }

    fn weather(&self) -> PerezWeather {
        PerezWeather {
            dni: self.number("dni"),
            dhi: self.number("dhi"),
            sun_altitude: self.number("sun_alt").to_radians(),
            day_of_year: self.text("day").parse().unwrap(),
            dew_point: self.number("dew_point"),
        }
    }

    /// What we find, if it is a row for this module.
    fn computed(&self) -> Option<Vec<f64>> {
        Some(match self.group.as_str() {
            "cie_relative_luminance" => {
                vec![self.cie().relative_to_zenith(self.direction(), self.sun())]
            }
            "cie_horizontal" => {
                let sky = self.cie();
                let integral = SkyDistribution::Cie(sky).horizontal(self.sun());
                vec![integral / sky.relative(DVec3::Z, self.sun())]
            }
            "perez_clearness" => vec![self.weather().clearness()],
            "perez_brightness" => vec![self.weather().brightness()],
            "perez_diffuse_illuminance" => vec![self.weather().diffuse_illuminance()],
            "perez_direct_normal_illuminance" => vec![self.weather().direct_normal_illuminance()],
            "perez_abcde" => self.weather().coefficients().to_vec(),
            "perez_luminance" => vec![self.weather().sky_in_lux(0.0).radiance(self.direction())],
            "sky_component" => vec![self.sky_component()],
            _ => return None,
        })
    }

    /// The share of the sky's irradiance, in percent, that comes to the origin through a window in
    /// a plane of constant y.
    fn sky_component(&self) -> f64 {
        let window = self.text("window y");
        let words: Vec<&str> = window.split([' ', '=']).collect();
        let [y, _, x, _, z] = words[..] else {
            panic!("{}: {window}", self.id)
        };
        let ends = |range: &str| -> [f64; 2] {
            let (from, to) = range.split_once("..").unwrap();
            [from.parse().unwrap(), to.parse().unwrap()]
        };
        let (y, [x0, x1], [z0, z1]): (f64, _, _) = (y.parse().unwrap(), ends(x), ends(z));
        let azimuth = self.text("sun_azimuth").split(' ').next().unwrap();
        let azimuth: f64 = azimuth.parse().unwrap();
        let sun = direction_from(azimuth.to_radians(), self.number("sun_alt").to_radians());
        let sky = Sky::cie(self.cie().number(), sun, 100.0).unwrap();
        let rule = gauss_legendre(40);
        let mut sum = 0.0;
        for &(s, w) in &rule {
            for &(t, v) in &rule {
                let x = x0 + 0.5 * (1.0 + s) * (x1 - x0);
                let z = z0 + 0.5 * (1.0 + t) * (z1 - z0);
                let point = DVec3::new(x, y, z);
                let form = z * y / point.length().powi(4);
                sum += w * v * form * sky.radiance(point.normalize());
            }
        }
        0.25 * (x1 - x0) * (z1 - z0) * sum
    }

    fn check(&self, values: &[f64]) {
        let tolerance: f64 = self.tolerance.parse().unwrap();
        assert_eq!(values.len(), self.values.len(), "{}", self.id);
        for (value, expected) in values.iter().zip(&self.values) {
            assert!(
                (value - expected).abs() <= tolerance * expected.abs(),
                "{}: {value} instead of {expected}",
                self.id
            );
        }
    }

    fn check_sun(&self) {
        let (latitude, longitude) = (self.number("latitude"), self.number("longitude_east"));
        let sun = sun_position(unix_seconds(self.text("time")), latitude, longitude).unwrap();
        let [altitude, azimuth] = self.values[..] else {
            panic!("{}: two angles", self.id)
        };
        let expected = direction_from(azimuth.to_radians(), altitude.to_radians());
        let off = angle_between(sun.toward(), expected).to_degrees();
        assert!(off < 0.02, "{}: {sun:?}, off by {off} degrees", self.id);
    }
}

/// Of a time as in 2003-10-17 12:30:30-07:00.
fn unix_seconds(time: &str) -> f64 {
    let number = |range: std::ops::Range<usize>| -> i64 { time[range].parse().unwrap() };
    let (year, month, day) = (number(0..4), number(5..7), number(8..10));
    // Years from March, so that the leap day is the last one.
    let (y, m) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 719_468;
    let seconds = days * 86_400 + number(11..13) * 3600 + number(14..16) * 60 + number(17..19);
    let offset = number(20..22) * 3600 + number(23..25) * 60;
    let sign = if &time[19..20] == "-" { -1 } else { 1 };
    (seconds - sign * offset) as f64
}

#[test]
fn the_table_of_skies_and_suns_is_kept() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let path = data.join("reference/daylight.tsv");
    let table = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let lines = table.lines().filter(|l| !l.starts_with('#')).skip(1);
    let mut checked = 0;
    for row in lines.filter_map(ReferenceRow::parse) {
        if row.group == "sun" {
            row.check_sun();
        } else if let Some(values) = row.computed() {
            row.check(&values);
        } else {
            continue;
        }
        checked += 1;
    }
    assert!(checked >= 80, "only {checked} rows are about skies");
}

#[test]
fn positions_of_the_sun_and_directions_are_inverse() {
    for (azimuth, altitude) in [(0.0, 0.3), (2.0, -0.4), (4.5, 1.5)] {
        let at = SunPosition { altitude, azimuth };
        let again = SunPosition::of(at.toward());
        assert!((again.azimuth - azimuth).abs() < 1e-12, "{again:?}");
        assert!((again.altitude - altitude).abs() < 1e-12, "{again:?}");
    }
    assert_eq!(SunPosition::of(DVec3::Z).azimuth, 0.0);
}

#[test]
fn a_sky_of_another_sun_or_brightness_keeps_the_rest() {
    let sky = Sky::cie(12, direction_from(1.0, 0.5), 300.0).unwrap();
    let moved = sky.with_sun(direction_from(3.0, 1.0));
    assert!((moved.diffuse_horizontal() - 300.0).abs() < 1e-6);
    assert_eq!(moved.toward_sun, direction_from(3.0, 1.0));
    let dim = sky.with_ground(0.2, 0.0).with_diffuse_horizontal(30.0);
    assert!((dim.diffuse_horizontal() - 30.0).abs() < 1e-6);
    assert!(dim.ground > 0.0 && dim.distribution == sky.distribution);
    let lit = Sky::uniform(0.0).with_diffuse_horizontal(PI);
    assert!((lit.scale - 1.0).abs() < 1e-12);
}

#[test]
fn every_cie_type_has_a_name_of_its_own() {
    let names: std::collections::BTreeSet<_> = CieSky::all().map(CieSky::name).collect();
    assert_eq!(names.len(), 16);
    assert_eq!(CieSky::new(12).unwrap().name(), "clear");
}
