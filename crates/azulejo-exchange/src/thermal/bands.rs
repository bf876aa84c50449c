//! Bands of wavelengths.

use std::fmt;

/// Second radiation constant, µm·K, CODATA 2018.
const C2: f64 = 14_387.768_77;

/// z = c₂/(λT) below which the power series is used.
const SMALL: f64 = 0.5;

/// Share of a black body's emission at `temperature` (K) that has wavelengths below `micrometres`, 0..1.
/// Its error is below 1e-13.
///
/// The series in e^−nz, z = c₂/(λT), of Chang and Rhee, *Blackbody radiation functions*, Int. Comm. Heat
/// Mass Transfer 11, 1984, and for small z the power series of z³/(e^z − 1), integrated.
pub fn band_fraction(micrometres: f64, temperature: f64) -> f64 {
    let product = micrometres * temperature;
    if product.is_nan() || product <= 0.0 {
        return 0.0;
    }
    let z = C2 / product;
    let scale = 15.0 / std::f64::consts::PI.powi(4);
    if z < SMALL {
        let z2 = z * z;
        let series = 1.0 / 3.0 - z / 8.0 + z2 / 60.0 - z2 * z2 / 5_040.0 + z2.powi(3) / 272_160.0
            - z2.powi(4) / 13_305_600.0;
        return 1.0 - scale * z * z2 * series;
    }
    let mut sum = 0.0;
    for n in 1..200 {
        let n = f64::from(n);
        let terms = z.powi(3) + 3.0 * z * z / n + 6.0 * z / (n * n) + 6.0 / n.powi(3);
        let term = (-n * z).exp() / n * terms;
        sum += term;
        if term < 1e-17 {
            break;
        }
    }
    scale * sum
}

/// The wavelengths of a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectralRange {
    /// All that surfaces emit by their temperature: grey surfaces.
    Thermal,
    /// From one wavelength to another, micrometres; 0 and infinity are allowed.
    Between(f64, f64),
    /// What the sun emits and no surface of the scene.
    Solar,
}

impl SpectralRange {
    /// Black emission in this band at a temperature in kelvin, W/m².
    pub fn emission(self, temperature: f64) -> f64 {
        self.share(temperature) * super::network::STEFAN_BOLTZMANN * temperature.powi(4)
    }

    /// Share of a black body's emission in this band, 0..1.
    pub fn share(self, temperature: f64) -> f64 {
        match self {
            SpectralRange::Thermal => 1.0,
            SpectralRange::Solar => 0.0,
            SpectralRange::Between(low, high) => {
                let below = |micrometres: f64| {
                    if micrometres.is_infinite() {
                        1.0
                    } else {
                        band_fraction(micrometres, temperature)
                    }
                };
                below(high) - below(low)
            }
        }
    }

    /// Derivative of [`emission`](SpectralRange::emission) by the temperature, W/(m²K): by
    /// differences of 1e-4 of the temperature, good to 1e-7.
    pub fn slope(self, temperature: f64) -> f64 {
        let step = 1e-4 * temperature.max(1e-6);
        let (above, below) = (temperature + step, temperature - step);
        (self.emission(above) - self.emission(below)) / (2.0 * step)
    }
}

impl fmt::Display for SpectralRange {
    /// As in the columns of tables of materials: nothing, `solar`, `8-14`, `4-inf`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            SpectralRange::Thermal => Ok(()),
            SpectralRange::Solar => write!(f, "solar"),
            SpectralRange::Between(low, high) => write!(f, "{low}-{high}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_those_of_tables() {
        // Howell, Mengüç, Daun, Siegel, Thermal Radiation Heat Transfer, appendix A, by λT in µm·K; and
        // the share below the maximum of emission, a quarter.
        for (product, expected, digits) in [
            (1_000.0, 0.000_321, 1e-6),
            (2_897.771_955, 0.250_054_547_010_999, 1e-13),
            (5_000.0, 0.633_75, 3e-5),
            (20_000.0, 0.985_55, 1e-5),
        ] {
            let share = band_fraction(product / 300.0, 300.0);
            assert!((share - expected).abs() < digits, "{product}: {share}");
        }
    }

    #[test]
    fn both_series_agree_where_they_meet() {
        let at = |z: f64| band_fraction(C2 / z / 300.0, 300.0);
        let (below, above) = (at(SMALL - 1e-9), at(SMALL + 1e-9));
        assert!((below - above).abs() < 1e-9 && below > above);
        assert_eq!(
            (band_fraction(0.0, 300.0), band_fraction(8.0, 0.0)),
            (0.0, 0.0)
        );
        assert!((band_fraction(1e9, 300.0) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn bands_add_up_and_slopes_are_derivatives() {
        let bands = [(0.0, 4.0), (4.0, 12.0), (12.0, f64::INFINITY)];
        let bands = bands.map(|(low, high)| SpectralRange::Between(low, high));
        let whole: f64 = bands.iter().map(|b| b.emission(800.0)).sum();
        let grey = SpectralRange::Thermal;
        assert!((whole - grey.emission(800.0)).abs() < 1e-10 * whole);
        let slope = 4.0 * crate::thermal::network::STEFAN_BOLTZMANN * 800.0f64.powi(3);
        assert!((grey.slope(800.0) - slope).abs() < 1e-7 * slope);
        assert_eq!(SpectralRange::Solar.emission(800.0), 0.0);
        assert_eq!(bands[2].to_string(), "12-inf");
    }
}
