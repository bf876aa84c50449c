//! Light as spherical harmonics: radiance from all directions at a point in nine coefficients, or from those above a
//! surface in four.

use crate::Rgb;
use glam::DVec3;
use std::f64::consts::PI;

/// Real spherical harmonics of bands 0 to 2.
pub const HARMONICS: usize = 9;

/// The constant harmonic Y₀₀ = 1/√(4π).
pub const Y00: f64 = 0.282_094_791_773_878_14;

/// √(3/(4π)): the harmonics of band 1 are this times y, z and x.
pub const Y1: f64 = 0.488_602_511_902_919_9;

/// Factors of bands 0 to 2 by which radiance becomes irradiance (Ramamoorthi and Hanrahan, *An
/// efficient representation for irradiance environment maps*, SIGGRAPH 2001).
const COSINE_BANDS: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];

/// The real spherical harmonics Y_lm of a unit direction, in the order (0,0), (1,−1), (1,0), (1,1), (2,−2) ... (2,2):
/// orthonormal over the sphere, without the phase (−1)^m.
pub fn real_harmonics(d: DVec3) -> [f64; HARMONICS] {
    const Y20: f64 = 0.315_391_565_252_520_05;
    const Y21: f64 = 1.092_548_430_592_079_2;
    const Y22: f64 = 0.546_274_215_296_039_6;
    [
        Y00,
        Y1 * d.y,
        Y1 * d.z,
        Y1 * d.x,
        Y21 * d.x * d.y,
        Y21 * d.y * d.z,
        Y20 * (3.0 * d.z * d.z - 1.0),
        Y21 * d.x * d.z,
        Y22 * (d.x * d.x - d.y * d.y),
    ]
}

/// The band of a coefficient, 0 to 2.
pub fn band(coefficient: usize) -> usize {
    usize::from(coefficient > 0) + usize::from(coefficient > 3)
}

/// The factor by which a coefficient of radiance becomes one of irradiance: that of its band.
pub fn cosine_factor(coefficient: usize) -> f64 {
    COSINE_BANDS[band(coefficient)]
}

/// Irradiance (W/m²) of a surface with a unit normal by the coefficients of the radiance around it (W/(sr·m²)). Bands
/// above 2, which are left out, hold about 1% of it on average (ibid.); light from one direction makes it negative behind.
pub fn harmonic_irradiance(radiance: &[Rgb; HARMONICS], normal: DVec3) -> Rgb {
    let terms = radiance.iter().zip(real_harmonics(normal)).enumerate();
    terms.map(|(k, (c, y))| *c * (y * cosine_factor(k))).sum()
}

/// Light above a surface, of one channel, as that of one direction and that of an even sky: the only mixture of these two
/// that has the scalar irradiance φ = ∫ L dω and the vector irradiance G = ∫ L ω dω that are given.
///
/// So four numbers, the harmonics of bands 0 and 1, give the irradiance of normals that a normal map tilts: exactly
/// where the light is from one direction, or is even, and for any light where the tilt is small, because
/// its derivative at the surface's normal is that of G.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SunAndSky {
    /// Unit direction of the first, or zero if there is none of it.
    pub direction: DVec3,
    /// Its part of φ, 0..=1.
    pub share: f64,
}

impl SunAndSky {
    /// From G/φ, no longer than 1, and the unit normal.
    ///
    /// With s as the share of the sun and d as its direction, G/φ = s d + (1 − s)/2 n, because an even sky
    /// has G = φ/2 n. That |d| = 1 makes s the positive root of ¾ s² − (c − ½) s − |G/φ − n/2|² = 0, c = G·n/φ.
    pub fn new(vector: DVec3, normal: DVec3) -> SunAndSky {
        let linear = vector.dot(normal) - 0.5;
        let beside_sky = vector - 0.5 * normal;
        let root = (linear * linear + 3.0 * beside_sky.length_squared()).sqrt();
        let share = ((linear + root) / 1.5).clamp(0.0, 1.0);
        SunAndSky {
            direction: (vector - 0.5 * (1.0 - share) * normal).normalize_or_zero(),
            share,
        }
    }

    /// Irradiance of a unit normal that is tilted from that of the surface, relative to φ.
    pub fn irradiance(&self, tilted: DVec3, normal: DVec3) -> f64 {
        let sun = self.direction.dot(tilted).max(0.0);
        let sky = 0.25 * (1.0 + tilted.dot(normal));
        self.share * sun + (1.0 - self.share) * sky
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions all over the sphere.
    fn sphere() -> impl Iterator<Item = DVec3> {
        const COUNT: u32 = 40_000;
        (0..COUNT).map(|k| {
            let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(COUNT);
            let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * cos, r * sin, z)
        })
    }

    #[test]
    fn harmonics_are_orthonormal() {
        let count = sphere().count() as f64;
        for i in 0..HARMONICS {
            for j in 0..HARMONICS {
                let product = |d| real_harmonics(d)[i] * real_harmonics(d)[j];
                let integral = sphere().map(product).sum::<f64>() * 4.0 * PI / count;
                let expected = f64::from(u8::from(i == j));
                assert!((integral - expected).abs() < 1e-4, "{i} {j} {integral}");
            }
        }
    }

    #[test]
    fn even_light_has_the_irradiance_pi() {
        let mut radiance = [Rgb::BLACK; HARMONICS];
        radiance[0] = Rgb::WHITE / Y00;
        for d in sphere().step_by(4000) {
            assert!((harmonic_irradiance(&radiance, d).g - PI).abs() < 1e-12);
        }
    }

    /// φ and G of radiance over the hemisphere about z, and the irradiance of another normal.
    fn integrals(radiance: impl Fn(DVec3) -> f64, tilted: DVec3) -> (f64, DVec3, f64) {
        let (mut phi, mut vector, mut tilted_irradiance) = (0.0, DVec3::ZERO, 0.0);
        let weight = 4.0 * PI / sphere().count() as f64;
        for d in sphere().filter(|d| d.z > 0.0) {
            let light = weight * radiance(d);
            phi += light;
            vector += light * d;
            tilted_irradiance += light * d.dot(tilted).max(0.0);
        }
        (phi, vector, tilted_irradiance)
    }

    #[test]
    fn sun_and_sky_are_told_apart() {
        let sun = DVec3::new(0.6, 0.0, 0.8);
        for share in [0.0, 0.3, 1.0] {
            let vector = share * sun + 0.5 * (1.0 - share) * DVec3::Z;
            let both = SunAndSky::new(vector, DVec3::Z);
            assert!((both.share - share).abs() < 1e-12, "{both:?}");
            assert!(share == 0.0 || both.direction.distance(sun) < 1e-12);
        }
    }

    #[test]
    fn tilted_irradiance_is_that_of_the_light() {
        // Even light; light that grows to one side; a bright quarter. Turned away from wide light it is too dark.
        let even = |_: DVec3| 1.0;
        let sided = |d: DVec3| 1.0 + d.x;
        let quarter = |d: DVec3| if d.x > 0.0 && d.y > 0.0 { 3.0 } else { 0.5 };
        let lights: [(&dyn Fn(DVec3) -> f64, f64); 3] =
            [(&even, 1e-3), (&sided, 0.07), (&quarter, 0.12)];
        for (light, tolerance) in lights {
            for turn in [0.0, 1.0, 2.5, 4.0] {
                let (sin, cos) = f64::sin_cos(turn);
                let tilt = 25_f64.to_radians();
                let tilted = DVec3::new(tilt.sin() * cos, tilt.sin() * sin, tilt.cos());
                let (phi, vector, truth) = integrals(light, tilted);
                let both = SunAndSky::new(vector / phi, DVec3::Z);
                let found = phi * both.irradiance(tilted, DVec3::Z);
                assert!((found / truth - 1.0).abs() < tolerance, "{found} {truth}");
                // Without a tilt it is the irradiance itself.
                let flat = phi * both.irradiance(DVec3::Z, DVec3::Z);
                assert!((flat / vector.z - 1.0).abs() < 1e-9);
            }
        }
    }
}
