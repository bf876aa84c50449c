//! Luminaires of photometric files at their places in a scene.
//!
//! ```no_run
//! use azulejo::luminaire::PlacedLuminaire;
//! use azulejo::scene::{Scene, Units};
//! use glam::DVec3;
//!
//! let downlight = PlacedLuminaire {
//!     position: DVec3::new(2.0, 1.5, 2.8),
//!     lumens: Some(1200.0),
//!     ..PlacedLuminaire::of("downlight.ies")
//! };
//! let mut scene = Scene::default();
//! scene.lights.extend(downlight.lights(Units::default())?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod kinds;

use crate::models::{ReadFailure, read_bytes};
use azulejo_formats::mgf::black_body_color;
use azulejo_formats::photometry::PhotometricFile;
use azulejo_formats::{Folder, ReadError};
use azulejo_scene::environment::upright;
use azulejo_scene::{Light, Rgb, Units};
use glam::{DAffine3, DMat3, DVec3};
use std::fmt;
use std::path::{Path, PathBuf};

/// Luminous efficacy of white light, lm/W, as Radiance and MGF have it.
const EFFICACY: f64 = 179.0;

/// A luminaire, and where it hangs.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLuminaire {
    /// The photometric file: IES LM-63 or EULUMDAT.
    pub file: PathBuf,
    /// The middle of its luminous opening, scene units.
    pub position: DVec3,
    /// By how many degrees it is tilted from straight down toward its plane of 0 degrees.
    pub tilt: f64,
    /// Where that plane points, degrees counter-clockwise as seen from above, from +x.
    pub rotation: f64,
    /// By how many degrees it is turned about its own axis before that, counter-clockwise as seen from above.
    pub spin: f64,
    /// Luminous flux, lumens, in place of the file's.
    pub lumens: Option<f64>,
    /// Colour temperature, K; white without it.
    pub temperature: Option<f64>,
    /// The lamp set of a file in EULUMDAT, from 1.
    pub lamp_set: Option<usize>,
}

/// Why a luminaire gives no light.
#[derive(Debug)]
#[non_exhaustive]
pub enum LuminaireError {
    /// The file cannot be read.
    File(ReadFailure),
    /// It is not a photometric file.
    Content(ReadError),
    /// The flux, the temperature or an angle is none.
    Value(String),
}

impl fmt::Display for LuminaireError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LuminaireError::File(e) => e.fmt(f),
            LuminaireError::Content(e) => e.fmt(f),
            LuminaireError::Value(words) => f.write_str(words),
        }
    }
}

impl std::error::Error for LuminaireError {}

impl PlacedLuminaire {
    /// As the file has it, at the origin, aiming down.
    pub fn of(file: impl AsRef<Path>) -> PlacedLuminaire {
        PlacedLuminaire {
            file: file.as_ref().to_owned(),
            position: DVec3::ZERO,
            tilt: 0.0,
            rotation: 0.0,
            spin: 0.0,
            lumens: None,
            temperature: None,
            lamp_set: None,
        }
    }

    /// Its lights in a scene of these units: several, of equal power, where its opening is large.
    ///
    /// # Errors
    /// [`LuminaireError`].
    pub fn lights(&self, units: Units) -> Result<Vec<Light>, LuminaireError> {
        let bytes = read_bytes(&self.file).map_err(LuminaireError::File)?;
        let shown = self.file.to_string_lossy();
        let file = PhotometricFile::read(&bytes, &shown, self.lamp_set);
        let mut file = file.map_err(LuminaireError::Content)?;
        // As it was made to hang it has all of its light.
        if self.tilt != 0.0 {
            let beside = Folder::of_model(&self.file);
            file.read_tilt(&beside).map_err(LuminaireError::Content)?;
        }
        let wrong = |words: &str| LuminaireError::Value(format!("{shown}: {words}"));
        let numbers = [self.tilt, self.rotation, self.spin];
        if !(self.position.is_finite() && numbers.iter().all(|x| x.is_finite())) {
            return Err(wrong("its place is not finite"));
        }
        let given = file.lumens();
        let wanted = self.lumens.unwrap_or(given);
        if given <= 0.0 {
            return Err(wrong("it has no light in any direction"));
        }
        let flux = flux(wanted, self.temperature, units.photometric);
        let flux = flux.ok_or_else(|| wrong("lumens and colour temperature must be above 0"))?;
        // Candelas are per square metre at a metre.
        let metres = units.metres();
        let scale = flux / given * (file.tilt_factor(self.tilt) / (metres * metres));
        let name = match &*file.name {
            "" => self
                .file
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            name => name.to_owned(),
        };
        let lights = file.lights(&self.world_from_luminaire(units), scale);
        let named = |kind| Light {
            name: name.clone(),
            kind,
        };
        Ok(lights.into_iter().map(named).collect())
    }

    fn world_from_luminaire(&self, units: Units) -> DAffine3 {
        let [tilt, rotation, spin] = [self.tilt, self.rotation, self.spin].map(f64::to_radians);
        // Its aim, −z, goes toward +x, the plane of 0 degrees.
        let turned = DMat3::from_rotation_z(rotation)
            * DMat3::from_rotation_y(-tilt)
            * DMat3::from_rotation_z(spin);
        let world = DMat3::from_quat(upright(units.up, 0.0)) * turned;
        DAffine3::from_mat3_translation(world / units.metres(), self.position)
    }
}

/// A luminous flux of a colour temperature per channel, in W, or lm in photometric scenes; white without a temperature.
/// `None` if it is not light.
pub(crate) fn flux(lumens: f64, temperature: Option<f64>, photometric: bool) -> Option<Rgb> {
    let color = match temperature {
        None => Rgb::WHITE,
        Some(kelvin) => black_body_color(kelvin)?,
    };
    let unit = if photometric { 1.0 } else { EFFICACY };
    (lumens > 0.0 && lumens.is_finite()).then_some(color * (lumens / unit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{LightKind, Up};

    /// 100 cd to the side of 0 degrees, straight down nothing.
    const SIDEWAYS: &str = "IESNA:LM-63-2002\nTILT=INCLUDE\n1\n2\n0 90\n1 0.5\n\
        1 1000 1 3 3 1 2 0 0 0\n1 1 30\n0 90 180\n0 90 180\n0 100 0\n0 50 0\n0 0 0\n";

    fn placed(change: impl FnOnce(&mut PlacedLuminaire), units: Units) -> Vec<LightKind> {
        let path = std::env::temp_dir().join(format!(
            "azulejo-{}-{:?}.ies",
            std::process::id(),
            std::thread::current().id()
        ));
        std::fs::write(&path, SIDEWAYS).unwrap();
        let mut lamp = PlacedLuminaire::of(&path);
        change(&mut lamp);
        let lights = lamp.lights(units);
        std::fs::remove_file(&path).unwrap();
        lights
            .unwrap()
            .into_iter()
            .map(|light| light.kind)
            .collect()
    }

    const LUX: Units = Units {
        metres_per_unit: Some(1.0),
        up: Up::Z,
        photometric: true,
    };

    fn toward(lights: &[LightKind], w: DVec3) -> f64 {
        lights.iter().map(|light| light.intensity_toward(w).r).sum()
    }

    #[test]
    fn angles_turn_it_as_they_say() {
        let check = |[tilt, rotation, spin]: [f64; 3], up: Up, bright: DVec3, factor: f64| {
            let lights = placed(
                |lamp| {
                    lamp.tilt = tilt;
                    lamp.rotation = rotation;
                    lamp.spin = spin;
                },
                Units { up, ..LUX },
            );
            let found = toward(&lights, bright);
            assert!(
                (found - 100.0 * factor).abs() < 1e-9,
                "{tilt} {rotation} {spin}: {found}"
            );
        };
        check([0.0, 0.0, 0.0], Up::Z, DVec3::X, 1.0);
        check([0.0, 90.0, 0.0], Up::Z, DVec3::Y, 1.0);
        check([0.0, 0.0, 90.0], Up::Z, DVec3::Y, 1.0);
        check([0.0, 90.0, 90.0], Up::Z, DVec3::NEG_X, 1.0);
        // Tilted by a right angle it aims at +x, and what was bright is above; of its lamps half of the light is left.
        check([90.0, 0.0, 0.0], Up::Z, DVec3::Z, 0.5);
        check([0.0, 0.0, 0.0], Up::Y, DVec3::X, 1.0);
        check([0.0, 90.0, 0.0], Up::Y, DVec3::NEG_Z, 1.0);
    }

    #[test]
    fn units_are_those_of_the_scene() {
        let flux = |units: Units, lumens: Option<f64>| {
            let lights = placed(|lamp| lamp.lumens = lumens, units);
            let of = |light: &LightKind| match light {
                LightKind::Luminaire { scale, web, .. } => scale.r * web.sphere_integral(),
                _ => 0.0,
            };
            lights.iter().map(of).sum::<f64>()
        };
        let given = flux(LUX, None);
        assert!((flux(LUX, Some(500.0)) - 500.0).abs() < 1e-9);
        let watts = Units {
            photometric: false,
            ..LUX
        };
        assert!((flux(watts, None) * EFFICACY / given - 1.0).abs() < 1e-12);
        let millimetres = Units {
            metres_per_unit: Some(1e-3),
            ..LUX
        };
        assert!((flux(millimetres, None) * 1e-6 / given - 1.0).abs() < 1e-12);
    }
}
