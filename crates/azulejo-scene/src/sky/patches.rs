//! The sky in patches, numbered as Radiance's `gendaymtx` numbers them.

use super::direction_from;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;
use std::str::FromStr;

/// Patches of each band of Tregenza's division, from the horizon to the zenith, without that of the zenith.
const BANDS: [usize; 7] = [30, 30, 24, 24, 18, 12, 6];

/// Most subdivisions, which make 9,217 patches: a matrix has a column for each.
const FINEST: usize = 8;

/// The sky in patches of about equal solid angle, after Tregenza (*Subdivision of the sky hemisphere for luminance
/// measurements*, Lighting Research and Technology 19, 1987), each divided further after Reinhart.
///
/// Patch 0 is all that is below the horizon. The others follow in bands from the horizon to the zenith, each from north
/// clockwise as seen from above; the first of a band is centred on north, and the last of all is the zenith. Radiance's
/// `gendaymtx -m` has the same order (compared with that of pyradiance 1.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkyDivision {
    subdivisions: usize,
}

impl SkyDivision {
    /// Tregenza's 145 patches and the ground.
    pub const TREGENZA: SkyDivision = SkyDivision { subdivisions: 1 };

    /// Reinhart's division of each of Tregenza's patches in this many along each side, 1 to 8; 4 makes 2,305 patches.
    pub fn reinhart(subdivisions: usize) -> Option<SkyDivision> {
        (1..=FINEST)
            .contains(&subdivisions)
            .then_some(SkyDivision { subdivisions })
    }

    /// Number of patches, the ground included.
    pub fn count(self) -> usize {
        let bands: usize = (0..self.bands()).map(|band| self.in_band(band)).sum();
        bands + 2
    }

    /// The patch in a unit direction of the sky's frame, x east, y north, z up.
    pub fn patch(self, direction: DVec3) -> usize {
        if direction.z < 0.0 {
            return 0;
        }
        let altitude = direction.z.min(1.0).asin();
        let band = (altitude / self.height()) as usize;
        if band >= self.bands() {
            return self.count() - 1;
        }
        let azimuth = direction.x.atan2(direction.y) / TAU;
        let count = self.in_band(band);
        let place = (azimuth * count as f64).round().rem_euclid(count as f64);
        self.first_of(band) + place as usize
    }

    /// The middle of a patch, a unit direction of the sky's frame; straight down of the ground.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn direction(self, patch: usize) -> DVec3 {
        match self.place(patch) {
            None if patch == 0 => DVec3::NEG_Z,
            None => DVec3::Z,
            Some((band, place)) => {
                let azimuth = TAU * place as f64 / self.in_band(band) as f64;
                direction_from(azimuth, (band as f64 + 0.5) * self.height())
            }
        }
    }

    /// A unit direction within a patch, evenly by solid angle for two numbers in 0..1.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn direction_in(self, patch: usize, [u, v]: [f64; 2]) -> DVec3 {
        let (low, high, from, width) = match self.place(patch) {
            None if patch == 0 => (-FRAC_PI_2, 0.0, 0.0, TAU),
            None => (self.bands() as f64 * self.height(), FRAC_PI_2, 0.0, TAU),
            Some((band, place)) => {
                let width = TAU / self.in_band(band) as f64;
                let [low, high] = [band, band + 1].map(|k| k as f64 * self.height());
                (low, high, (place as f64 - 0.5) * width, width)
            }
        };
        let sine = low.sin() + v * (high.sin() - low.sin());
        direction_from(from + u * width, sine.clamp(-1.0, 1.0).asin())
    }

    /// The solid angle of a patch, sr.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn solid_angle(self, patch: usize) -> f64 {
        match self.place(patch) {
            None if patch == 0 => TAU,
            None => TAU * (1.0 - (self.bands() as f64 * self.height()).sin()),
            Some((band, _)) => {
                let [low, high] = [band, band + 1].map(|k| (k as f64 * self.height()).sin());
                TAU * (high - low) / self.in_band(band) as f64
            }
        }
    }

    /// Band, and number within it; `None` of the ground and the zenith.
    fn place(self, patch: usize) -> Option<(usize, usize)> {
        let count = self.count();
        assert!(patch < count, "patch {patch} of {count}");
        let band = (0..self.bands()).find(|&b| patch < self.first_of(b + 1))?;
        Some((band, patch.checked_sub(self.first_of(band))?))
    }

    fn bands(self) -> usize {
        BANDS.len() * self.subdivisions
    }

    /// Height of a band, radians: the zenith has half of one on every side.
    fn height(self) -> f64 {
        FRAC_PI_2 / (self.bands() as f64 + 0.5)
    }

    fn in_band(self, band: usize) -> usize {
        BANDS[band / self.subdivisions] * self.subdivisions
    }

    fn first_of(self, band: usize) -> usize {
        1 + (0..band).map(|b| self.in_band(b)).sum::<usize>()
    }
}

impl fmt::Display for SkyDivision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.subdivisions {
            1 => f.write_str("tregenza"),
            n => write!(f, "reinhart:{n}"),
        }
    }
}

impl FromStr for SkyDivision {
    type Err = String;

    fn from_str(word: &str) -> Result<SkyDivision, String> {
        let reinhart = || {
            let subdivisions = word.strip_prefix("reinhart:")?.parse().ok()?;
            SkyDivision::reinhart(subdivisions)
        };
        match word {
            "tregenza" => Ok(SkyDivision::TREGENZA),
            _ => reinhart().ok_or_else(|| {
                format!("expected tregenza, or reinhart:N with N from 1 to {FINEST}: reinhart:2, reinhart:4")
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_patches_as_their_authors_have() {
        let counts = ["tregenza", "reinhart:1", "reinhart:2", "reinhart:4"]
            .map(|word| word.parse::<SkyDivision>().unwrap().count());
        assert_eq!(counts, [146, 146, 578, 2306]);
        for word in ["", "reinhart", "reinhart:0", "reinhart:9", "klems"] {
            assert!(word.parse::<SkyDivision>().is_err(), "{word}");
        }
    }

    #[test]
    fn each_middle_is_in_its_patch_and_all_are_the_sphere() {
        for division in [1, 2, 4].map(|n| SkyDivision::reinhart(n).unwrap()) {
            let patches = 0..division.count();
            for patch in patches.clone() {
                assert_eq!(division.patch(division.direction(patch)), patch);
                for u in [0.01, 0.5, 0.99] {
                    let within = division.direction_in(patch, [u, 1.0 - u]);
                    assert_eq!(division.patch(within), patch);
                }
            }
            let all: f64 = patches.map(|patch| division.solid_angle(patch)).sum();
            assert!((all - 2.0 * TAU).abs() < 1e-12, "{all}");
        }
    }

    /// Where `gendaymtx -5 0.533 -d` of pyradiance 1.3.1 puts the sun at 40° north, by its altitude and azimuth.
    #[test]
    fn the_order_is_that_of_radiance() {
        let suns = [
            (37.12, 89.06, 91, 301),
            (73.45, 178.87, 142, 541),
            (37.65, 270.5, 103, 373),
            (26.56, 180.7, 73, 265),
        ];
        for (altitude, azimuth, of_146, of_578) in suns {
            let sun = direction_from(f64::to_radians(azimuth), f64::to_radians(altitude));
            let patches = [1, 2].map(|n| SkyDivision::reinhart(n).unwrap().patch(sun));
            assert_eq!(patches, [of_146, of_578]);
        }
    }
}
