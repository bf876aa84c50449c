//! Texture records as RTRACE's textures, with their colour maps and images.

use super::document::{SffSources, TextureRecord};
use super::pictures;
use crate::reading::files::{beside, open_beside};
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::{Files, ReadError};
use azulejo_scene::rtrace::{ColorMap, RtraceTexture, RtraceTextureKind};
use azulejo_scene::{Image, Rgb};
use glam::{DMat4, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Colour maps and images, each read once; `None` for those that cannot be read.
#[derive(Default)]
pub(super) struct TextureFiles {
    maps: HashMap<String, Option<ColorMap>>,
    images: HashMap<String, Option<Arc<Image>>>,
}

/// What reading a texture requires besides its record.
pub(super) struct TextureContext<'r, 's> {
    pub files: &'r dyn Files,
    pub sources: &'r SffSources<'s>,
    pub warnings: &'r mut Warnings,
    pub surfaces: u32,
}

impl TextureFiles {
    /// The texture of a record; `None`, with a warning, if its image cannot be read.
    ///
    /// # Errors
    /// A singular matrix, a surface that does not exist, invalid axes.
    pub fn texture(
        &mut self,
        record: &TextureRecord,
        around: &mut TextureContext,
    ) -> Result<Option<RtraceTexture>, ReadError> {
        let fail = |found: String, expected: &str| {
            Err(around.sources.error(record.place, found, expected))
        };
        let Some(texture_from_point) = inverse(&record.matrix) else {
            let expected = "a matrix whose determinant is not zero, or all zeros for none";
            return fail("a singular texture matrix".into(), expected);
        };
        let v = &record.kind.values;
        let number = record.kind.number;
        if matches!(number, 1 | 2) {
            let surface = v[v.len() - 1].round();
            if !(1.0..=f64::from(around.surfaces)).contains(&surface) {
                let expected = format!("one of the surfaces, 1 to {}", around.surfaces);
                return fail(format!("surface {surface}"), &expected);
            }
        }
        let axes = (number == 18).then(|| [v[2], v[3]].map(f64::round));
        if axes.is_some_and(|[u, v]| u == v || [u, v].iter().any(|a| !(1.0..=3.0).contains(a))) {
            let expected = "two different axes, 1 for x, 2 for y, 3 for z";
            return fail(format!("axes {} and {}", v[2], v[3]), expected);
        }
        let Some(kind) = self.kind(record, around) else {
            return Ok(None);
        };
        Ok(Some(RtraceTexture {
            texture_from_point,
            matrix: record.matrix,
            file: record.file.clone(),
            kind,
        }))
    }

    fn kind(
        &mut self,
        record: &TextureRecord,
        around: &mut TextureContext,
    ) -> Option<RtraceTextureKind> {
        use RtraceTextureKind::*;
        let v = record.kind.values.as_slice();
        let surface = |k: usize| v[k].round() as u32 - 1;
        let mut map = || self.map(record, around);
        Some(match record.kind.number {
            0 => Null,
            1 => Checker {
                surface: surface(0),
            },
            2 => Blotch {
                k: v[0],
                surface: surface(1),
            },
            3 => Bump { k: v[0] },
            4 => Marble { map: map() },
            5 => Fbm {
                offset: v[0],
                k: v[1],
                omega: v[2],
                lambda: v[3],
                threshold: v[4],
                octaves: v[5],
                map: map(),
            },
            6 => FbmBump {
                offset: v[0],
                k: v[1],
                omega: v[2],
                lambda: v[3],
                octaves: v[4],
            },
            7 => Wood {
                color: Rgb::new(v[0], v[1], v[2]),
            },
            8 => Round { k: v[0] },
            9 => Bozo {
                turbulence: v[0],
                map: map(),
            },
            10 => Ripples {
                frequency: v[0],
                phase: v[1],
                k: v[2],
            },
            11 => Waves {
                frequency: v[0],
                phase: v[1],
                k: v[2],
            },
            12 => Spotted { map: map() },
            13 => Dents { k: v[0] },
            14 => Agate { map: map() },
            15 => Wrinkles { k: v[0] },
            16 => Granite { map: map() },
            17 => Gradient {
                turbulence: v[0],
                direction: DVec3::new(v[1], v[2], v[3]),
                map: map(),
            },
            18 => ImageMap {
                turbulence: v[0],
                tiles: v[1] == 0.0,
                axes: [v[2], v[3]].map(|axis| axis.round() as u8 - 1),
                image: self.image(record, around)?,
            },
            19 => Gloss { k: v[0] },
            _ => Bump3 {
                k: v[0],
                size: v[1],
            },
        })
    }

    fn map(&mut self, record: &TextureRecord, around: &mut TextureContext) -> Option<ColorMap> {
        if record.file.is_empty() {
            return None;
        }
        read_once(&mut self.maps, record, around, pictures::color_map)
    }

    fn image(&mut self, record: &TextureRecord, around: &mut TextureContext) -> Option<Arc<Image>> {
        read_once(&mut self.images, record, around, pictures::decode)
    }
}

fn read_once<T>(
    known: &mut HashMap<String, Option<Arc<T>>>,
    record: &TextureRecord,
    around: &mut TextureContext,
    decode: fn(&[u8]) -> Result<T, String>,
) -> Option<Arc<T>> {
    let key = beside(around.sources.name(record.place.file), &record.file);
    let known = known.entry(key);
    known
        .or_insert_with(|| read(record, around, decode).map(Arc::new))
        .clone()
}

/// Reads the file of a texture; `None`, with a warning, if it cannot be read.
fn read<T>(
    record: &TextureRecord,
    around: &mut TextureContext,
    decode: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Option<T> {
    let of = around.sources.name(record.place.file);
    let bytes = open_beside(around.files, of, &record.file).map_err(|e| e.to_string());
    let decoded = bytes.and_then(|(_, bytes)| decode(&bytes));
    let why = match decoded {
        Ok(decoded) => return Some(decoded),
        Err(why) => why,
    };
    let message = format!(
        "texture file \"{}\" skipped: {why}",
        shortened(&record.file)
    );
    let position = || around.sources.position(record.place);
    around.warnings.add(of, message, position);
    None
}

/// The inverse of a texture's matrix; all zeros mean none.
fn inverse(matrix: &DMat4) -> Option<DMat4> {
    if *matrix == DMat4::ZERO {
        return Some(DMat4::IDENTITY);
    }
    let size = matrix.determinant();
    let inverse = matrix.inverse();
    (size != 0.0 && inverse.is_finite()).then_some(inverse)
}
/// The type of a texture, and the numbers after its matrix.
pub(super) fn numbers(kind: &RtraceTextureKind) -> (u32, Vec<f64>) {
    use RtraceTextureKind::*;
    let surface = |s: &u32| f64::from(*s + 1);
    match kind {
        Null => (0, vec![]),
        Checker { surface: s } => (1, vec![surface(s)]),
        Blotch { k, surface: s } => (2, vec![*k, surface(s)]),
        Bump { k } => (3, vec![*k]),
        Marble { .. } => (4, vec![]),
        Fbm {
            offset,
            k,
            omega,
            lambda,
            threshold,
            octaves,
            ..
        } => (5, vec![*offset, *k, *omega, *lambda, *threshold, *octaves]),
        FbmBump {
            offset,
            k,
            omega,
            lambda,
            octaves,
        } => (6, vec![*offset, *k, *omega, *lambda, *octaves]),
        Wood { color } => (7, color.to_array().to_vec()),
        Round { k } => (8, vec![*k]),
        Bozo { turbulence, .. } => (9, vec![*turbulence]),
        Ripples {
            frequency,
            phase,
            k,
        } => (10, vec![*frequency, *phase, *k]),
        Waves {
            frequency,
            phase,
            k,
        } => (11, vec![*frequency, *phase, *k]),
        Spotted { .. } => (12, vec![]),
        Dents { k } => (13, vec![*k]),
        Agate { .. } => (14, vec![]),
        Wrinkles { k } => (15, vec![*k]),
        Granite { .. } => (16, vec![]),
        Gradient {
            turbulence,
            direction,
            ..
        } => (17, vec![*turbulence, direction.x, direction.y, direction.z]),
        ImageMap {
            turbulence,
            tiles,
            axes,
            ..
        } => {
            let mode = if *tiles { 0.0 } else { 1.0 };
            let [u, v] = axes.map(|a| f64::from(a) + 1.0);
            (18, vec![*turbulence, mode, u, v])
        }
        Gloss { k } => (19, vec![*k]),
        Bump3 { k, size } => (20, vec![*k, *size]),
    }
}
