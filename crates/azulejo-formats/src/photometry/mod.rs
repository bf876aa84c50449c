//! Photometric files of luminaires: IES LM-63 and EULUMDAT.
//!
//! `docs/formats/photometry.md` has the details.

mod eulumdat;
pub(crate) mod ies;
#[cfg(test)]
mod tests;

use crate::reading::cursor::TextCursor;
use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{Light, LightKind, PhotometricWeb, Rgb, Scene, Units, Up};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// A luminaire in its own frame: metres, aiming at −z, the plane of 0 degrees toward +x, the origin in the middle of
/// the luminous opening.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotometricFile {
    /// Its name; may be empty.
    pub name: String,
    /// Intensities, candela, with all factors of the file.
    pub web: Arc<PhotometricWeb>,
    /// The luminous opening.
    pub opening: LuminousOpening,
    /// The product of the file's factors, which also scales the emittance of a body.
    pub factor: f64,
    /// Angles in degrees by which it may be tilted, ascending, and what is then left of its light.
    pub tilt: Vec<[f64; 2]>,
    /// The file beside it that has that table, if it has not been read ([`PhotometricFile::read_tilt`]).
    pub tilt_file: Option<String>,
    /// MGF file of its geometry, whose surfaces emit.
    pub body: Option<String>,
    /// The sets of lamps of which it holds one, by their type, number and lumens; empty of IES.
    pub sets: Vec<String>,
}

/// The shape of a luminous opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LuminousOpening {
    /// A point source.
    Point,
    /// A rectangle across the aim.
    Rectangle {
        /// Along x, m.
        length: f64,
        /// Along y, m.
        width: f64,
    },
    /// A disc across the aim.
    Disc {
        /// m.
        diameter: f64,
    },
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PhotometryError {
    /// Offset of what was found.
    pub at: usize,
    pub found: String,
    pub expected: &'static str,
}

/// Largest distance between the points that stand for an opening, m: about a tenth of the height from which luminaires
/// usually shine, so that a point has the error of one that is seen from ten times its size.
const SPACING: f64 = 0.3;

/// Most points along a side of an opening.
const MOST_POINTS: usize = 8;

impl LuminousOpening {
    /// The points that stand for it, each with the same share of the light.
    pub fn points(self) -> Vec<DVec3> {
        let (sides, is_round) = match self {
            LuminousOpening::Point => return vec![DVec3::ZERO],
            LuminousOpening::Rectangle { length, width } => ([length, width], false),
            LuminousOpening::Disc { diameter } => ([diameter; 2], true),
        };
        let counts = sides.map(|side| ((side / SPACING).ceil() as usize).clamp(1, MOST_POINTS));
        let place =
            |side: f64, k: usize, count: usize| side * ((k as f64 + 0.5) / count as f64 - 0.5);
        let mut points = Vec::new();
        for i in 0..counts[0] {
            for j in 0..counts[1] {
                let point = DVec3::new(
                    place(sides[0], i, counts[0]),
                    place(sides[1], j, counts[1]),
                    0.0,
                );
                if !is_round || point.length() <= sides[0] / 2.0 {
                    points.push(point);
                }
            }
        }
        points
    }
}

impl PhotometricFile {
    /// Reads a file of either format, whose name is used in messages; `set` is the lamp set of EULUMDAT, from 1.
    ///
    /// # Errors
    /// What is not as the format has it, with its line; a set that the file does not have.
    pub fn read(
        bytes: &[u8],
        name: &str,
        set: Option<usize>,
    ) -> Result<PhotometricFile, ReadError> {
        let bytes = &*decoded(bytes);
        check_length(bytes, name)?;
        let parsed = match is_eulumdat(bytes, name) {
            true => eulumdat::parse(bytes, set.unwrap_or(1)),
            false if set.is_some_and(|set| set != 1) => {
                let found = "a lamp set other than the first of a file that has one";
                return Err(ReadError::whole(
                    name,
                    found,
                    "set 1, or a file in EULUMDAT",
                ));
            }
            false => ies::parse(bytes),
        };
        parsed.map_err(|e| TextCursor::new(bytes).error(name, e.at, e.found, e.expected))
    }

    /// Reads the table of its [`tilt_file`](PhotometricFile::tilt_file), if it has one.
    ///
    /// # Errors
    /// A file that is not there, and what is not as the format has it, with its line.
    pub fn read_tilt(&mut self, files: &dyn Files) -> Result<(), ReadError> {
        let Some(name) = &self.tilt_file else {
            return Ok(());
        };
        let expected = "the tilt table of the luminaire beside it";
        let bytes = files.read(name);
        let bytes = bytes.map_err(|fault| ReadError::whole(name, fault.to_string(), expected))?;
        let bytes = &*decoded(&bytes);
        check_length(bytes, name)?;
        let table = ies::tilt_table(bytes);
        self.tilt =
            table.map_err(|e| TextCursor::new(bytes).error(name, e.at, e.found, e.expected))?;
        self.tilt_file = None;
        Ok(())
    }

    /// Luminous flux, lumens: the integral of the intensity.
    pub fn lumens(&self) -> f64 {
        self.web.sphere_integral()
    }

    /// What is left of its light if it is tilted by this angle in degrees from the position that it was made for.
    pub fn tilt_factor(&self, degrees: f64) -> f64 {
        let Some(first) = self.tilt.first() else {
            return 1.0;
        };
        let degrees = degrees.abs();
        let behind = self.tilt.partition_point(|[angle, _]| *angle <= degrees);
        match (behind.checked_sub(1), self.tilt.get(behind)) {
            (None, _) => first[1],
            (Some(before), None) => self.tilt[before][1],
            (Some(before), Some([next, factor])) => {
                let [angle, value] = self.tilt[before];
                value + (factor - value) * (degrees - angle) / (next - angle)
            }
        }
    }

    /// The lights that stand for it: one, or several of equal power where its opening is large. `scale` is the radiant
    /// intensity of a candela, W/sr, in the scene's units; the map takes its frame to the world, in which it is not
    /// stretched.
    pub fn lights(&self, world_from_luminaire: &DAffine3, scale: Rgb) -> Vec<LightKind> {
        let points = self.opening.points();
        let share = scale / points.len() as f64;
        let lamp = |point: DVec3| {
            let mut light = Light {
                name: String::new(),
                kind: LightKind::Luminaire {
                    position: point,
                    world_from_web: DMat3::IDENTITY,
                    scale: share,
                    web: self.web.clone(),
                },
            };
            light.move_by(world_from_luminaire);
            light.kind
        };
        points.into_iter().map(lamp).collect()
    }
}

/// Whether a text is EULUMDAT rather than IES, by its name or by what its first lines hold.
fn is_eulumdat(bytes: &[u8], name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.ends_with(".ldt") || (!name.ends_with(".ies") && !has_tilt(bytes))
}

fn has_tilt(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|b| matches!(b, b'\n' | b'\r'));
    lines.any(|line| {
        let line = line.trim_ascii();
        line.len() >= 5 && line[..5].eq_ignore_ascii_case(b"TILT=")
    })
}

/// Reads a luminaire as a scene of lights. `name` is used in messages.
///
/// # Errors
/// As [`PhotometricFile::read`].
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let file = PhotometricFile::read(bytes, name, options.lamp_set)?;
    let mut warnings = Warnings::default();
    if file.sets.len() > 1 && options.lamp_set.is_none() {
        let sets = file.sets.join("; ");
        let message =
            format!("one of several sets of lamps is taken, the first (--lamp-set): {sets}");
        warnings.add_whole(name, message);
    }
    if file.lumens() == 0.0 {
        warnings.add_whole(name, "no light in any direction");
    }
    let mut scene = Scene {
        units: Units {
            metres_per_unit: Some(1.0),
            up: Up::Z,
            photometric: true,
        },
        ..Scene::default()
    };
    let title = match file.name.as_str() {
        "" => name.rsplit(['/', '\\']).next().unwrap_or(name),
        title => title,
    };
    for kind in file.lights(&DAffine3::IDENTITY, Rgb::WHITE) {
        scene.lights.push(Light {
            name: title.to_owned(),
            kind,
        });
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
