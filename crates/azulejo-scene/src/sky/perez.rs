//! The all-weather sky of Perez, Seals and Michalsky.

use super::{Sky, angle_between, direction_from, gradation};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Upper ends of the bins of clearness but the last. Perez et al. 1990, table 1.
const BINS: [f64; 7] = [1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200];

/// x1 to x4 of A, B, C, D and E for each bin of clearness. Perez, Seals and Michalsky 1993, table
/// 1, with the erratum.
const COEFFICIENTS: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];

/// a, b, c, d of the luminous efficacy of the diffuse irradiance. Perez et al. 1990, table 4.
const DIFFUSE_EFFICACY: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];

/// The same of the direct irradiance.
const DIRECT_EFFICACY: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];

/// Irradiance of a surface facing the sun outside of the atmosphere, W/m², mean over the year.
const SOLAR_CONSTANT: f64 = 1367.0;

/// An irradiance in W/m² up to which it is night, as in `gendaymtx`.
const NIGHT: f64 = 1e-4;

/// Dew point in °C where weather data have none, as in `gendaymtx`.
pub const TYPICAL_DEW_POINT: f64 = 11.0;

/// The relative luminances of an all-weather sky. Perez, Seals and Michalsky, *All-weather model
/// for sky luminance distribution*, Solar Energy 50(3), 1993, eq. (1), with the erratum in 51(5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerezSky {
    /// A, B of the gradation from zenith to horizon, C, D, E of the indicatrix around the sun.
    pub coefficients: [f64; 5],
}

impl PerezSky {
    /// (1 + A exp(B / cos Z)) (1 + C exp(D χ) + E cos² χ), 0 where a factor is negative.
    ///
    /// `direction`, `toward_sun`: unit, z up; `direction` at or above the horizon. Where A and B
    /// are both positive, B counts as 0, as the irradiance would be infinite. Only weather with
    /// direct light from a sun on the horizon leads to that; `gendaylit` makes no sky of it.
    pub fn relative(&self, direction: DVec3, toward_sun: DVec3) -> f64 {
        let [a, b, ..] = self.coefficients;
        let b = if a > 0.0 { b.min(0.0) } else { b };
        gradation(a, b, direction.z).max(0.0) * self.indicatrix(direction, toward_sun)
    }

    /// 1 + C exp(D χ) + E cos² χ, at least 0.
    fn indicatrix(&self, direction: DVec3, toward_sun: DVec3) -> f64 {
        let [_, _, c, d, e] = self.coefficients;
        let chi = angle_between(direction, toward_sun);
        let cos_chi = direction.dot(toward_sun);
        (1.0 + c * (d * chi).exp() + e * cos_chi * cos_chi).max(0.0)
    }

    /// The zenith angle at which the gradation is 0, and luminance has an edge.
    pub(super) fn dark_from(&self) -> Option<f64> {
        let [a, b, ..] = self.coefficients;
        let cos_z = b / (-1.0 / a).ln();
        (cos_z > 0.0 && cos_z < 1.0).then(|| cos_z.acos())
    }
}

/// Weather as its files give it for an hour, from which the sky's distribution and efficacies
/// follow.
///
/// Perez et al., *Modeling daylight availability and irradiance components from direct and global
/// irradiance*, Solar Energy 44(5), 1990; limits of the quantities as in Radiance's `gendaymtx`.
/// Irradiances below 0 count as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerezWeather {
    /// Direct normal irradiance, W/m², at least 0.
    pub dni: f64,
    /// Diffuse horizontal irradiance, W/m², at least 0.
    pub dhi: f64,
    /// Altitude of the sun, radians; negative below the horizon.
    pub sun_altitude: f64,
    /// 1 for the first of January, to 366.
    pub day_of_year: u32,
    /// Dew point, °C; [`TYPICAL_DEW_POINT`] where it is not known.
    pub dew_point: f64,
}

impl PerezWeather {
    /// Whether there is no light worth a sky: [`Self::sky`] is black then.
    pub fn is_night(&self) -> bool {
        self.dni.max(0.0) + self.dhi.max(0.0) <= NIGHT
    }

    /// Sky clearness ε, 1..=11.9. Perez et al. 1990, eq. (1).
    pub fn clearness(&self) -> f64 {
        let (dni, dhi) = (self.dni.max(0.0), self.dhi.max(0.0));
        if dni == 0.0 {
            return 1.0;
        }
        let cubed = 1.041 * self.zenith_angle().powi(3);
        // Without diffuse light this is infinite, and the limit holds.
        (((dhi + dni) / dhi + cubed) / (1.0 + cubed)).clamp(1.0, 11.9)
    }

    /// Sky brightness Δ, 0.01..=0.6. Perez et al. 1990, eq. (2).
    pub fn brightness(&self) -> f64 {
        let outside = SOLAR_CONSTANT * eccentricity_correction(self.day_of_year);
        (self.dhi.max(0.0) * self.air_mass() / outside).clamp(0.01, 0.6)
    }

    /// Diffuse horizontal illuminance, lx. Perez et al. 1990, eq. (7).
    pub fn diffuse_illuminance(&self) -> f64 {
        self.dhi.max(0.0) * self.diffuse_efficacy()
    }

    /// Direct normal illuminance, lx. Perez et al. 1990, eq. (8).
    pub fn direct_normal_illuminance(&self) -> f64 {
        self.dni.max(0.0) * self.direct_efficacy()
    }

    /// A, B, C, D, E. Perez, Seals and Michalsky 1993, eqs. (6) to (8).
    pub fn coefficients(&self) -> [f64; 5] {
        let (z, bin, clearness) = (self.zenith_angle(), self.bin(), self.clearness());
        let mut delta = self.brightness();
        if clearness > BINS[0] && clearness < BINS[4] {
            delta = delta.max(0.2);
        }
        let rows = &COEFFICIENTS[bin];
        let linear = |x: &[f64; 4]| x[0] + x[1] * z + delta * (x[2] + x[3] * z);
        let mut coefficients = [0, 1, 2, 3, 4].map(|i| linear(&rows[i]));
        if bin == 0 {
            let (c, d) = (rows[2], rows[3]);
            coefficients[2] = (delta * (c[0] + c[1] * z)).powf(c[2]).exp() - c[3];
            coefficients[3] = -(delta * (d[0] + d[1] * z)).exp() + d[2] + delta * d[3];
        }
        coefficients
    }

    /// The sky of this weather with the given diffuse horizontal irradiance or illuminance.
    ///
    /// `sun_azimuth`: radians clockwise from north. The sky's `toward_sun` is that of the model,
    /// which keeps the sun at altitudes of 0 to 87°. Its ground is black. At night the sky is
    /// black; where the model is 0 everywhere, it is uniform.
    pub fn sky(&self, sun_azimuth: f64, diffuse_horizontal: f64) -> Sky {
        let toward_sun = direction_from(sun_azimuth, FRAC_PI_2 - self.zenith_angle());
        if self.is_night() {
            return Sky {
                toward_sun,
                ..Sky::uniform(0.0)
            };
        }
        let coefficients = self.coefficients();
        Sky::perez(PerezSky { coefficients }, toward_sun, diffuse_horizontal)
    }

    /// The sky of this weather in cd/m², through [`Self::diffuse_illuminance`]. See [`Self::sky`].
    pub fn sky_in_lux(&self, sun_azimuth: f64) -> Sky {
        self.sky(sun_azimuth, self.diffuse_illuminance())
    }

    /// The sky of this weather in W/(sr m²) of all solar radiation, whose diffuse horizontal
    /// irradiance is `dhi`. See [`Self::sky`].
    pub fn sky_in_solar_watts(&self, sun_azimuth: f64) -> Sky {
        self.sky(sun_azimuth, self.dhi.max(0.0))
    }

    /// Zenith angle of the sun in the model, radians: 3° to 90°.
    fn zenith_angle(&self) -> f64 {
        (FRAC_PI_2 - self.sun_altitude).clamp(3f64.to_radians(), FRAC_PI_2)
    }

    /// Relative optical air mass. Kasten 1966.
    fn air_mass(&self) -> f64 {
        let z = self.zenith_angle();
        1.0 / (z.cos() + 0.15 * (93.885 - z.to_degrees()).powf(-1.253))
    }

    /// The bin of clearness, 0..8.
    fn bin(&self) -> usize {
        let clearness = self.clearness();
        BINS.iter().filter(|&&upper| clearness >= upper).count()
    }

    /// Precipitable water, cm. Perez et al. 1990, eq. (3).
    fn precipitable_water(&self) -> f64 {
        (0.07 * self.dew_point - 0.075).exp()
    }

    /// lm/W, at least 0.
    fn diffuse_efficacy(&self) -> f64 {
        let [a, b, c, d] = DIFFUSE_EFFICACY[self.bin()];
        let cos_z = self.zenith_angle().cos();
        (a + b * self.precipitable_water() + c * cos_z + d * self.brightness().ln()).max(0.0)
    }

    /// lm/W, at least 0.
    fn direct_efficacy(&self) -> f64 {
        let [a, b, c, d] = DIRECT_EFFICACY[self.bin()];
        let low_sun = (5.73 * self.zenith_angle() - 5.0).exp();
        (a + b * self.precipitable_water() + c * low_sun + d * self.brightness()).max(0.0)
    }
}

/// (mean distance of the sun / its distance on a day)², Spencer 1971.
fn eccentricity_correction(day_of_year: u32) -> f64 {
    let g = TAU * (f64::from(day_of_year) - 1.0) / 365.0;
    1.00011
        + 0.034_221 * g.cos()
        + 0.001_28 * g.sin()
        + 0.000_719 * (2.0 * g).cos()
        + 0.000_077 * (2.0 * g).sin()
}
