//! Palettes: colours, materials, textures and light sources that faces and nodes refer to.

use super::fields::RecordFields;
use azulejo_scene::Rgb;
use std::collections::HashMap;
use std::rc::Rc;

/// The palettes that apply to a file: its own, or those of the file that refers to it.
#[derive(Clone, Debug, Default)]
pub(super) struct Palettes {
    pub colors: Rc<Vec<Rgb>>,
    pub materials: Rc<HashMap<i32, PaletteMaterial>>,
    pub textures: Rc<HashMap<i32, TextureFile>>,
    pub lights: Rc<HashMap<i32, PaletteLight>>,
}

/// A material as defined in the file.
#[derive(Clone, Debug)]
pub(super) struct PaletteMaterial {
    pub name: String,
    pub diffuse: Rgb,
    pub specular: Rgb,
    pub emissive: Rgb,
    pub shininess: f64,
    pub alpha: f64,
}

/// A texture's name, and the file that refers to it.
#[derive(Clone, Debug)]
pub(super) struct TextureFile {
    pub name: String,
    /// Path of the referring file relative to the root model; the texture is looked up beside it.
    pub named_by: Rc<str>,
}

/// A light source as defined in the file.
#[derive(Clone, Debug)]
pub(super) struct PaletteLight {
    pub name: String,
    pub diffuse: Rgb,
    pub kind: i32,
    pub spot_exponent: f64,
    /// Half angle of a spot, degrees.
    pub spot_cutoff: f64,
    /// Constant, linear and quadratic attenuation coefficients.
    pub attenuation: [f64; 3],
}

/// Bits of an external reference, from the highest, by which it keeps its own palettes.
const OWN_COLORS: u32 = 1 << 31;
const OWN_MATERIALS: u32 = 1 << 30;
const OWN_TEXTURES: u32 = 1 << 29;
const OWN_LIGHTS: u32 = 1 << 26;

impl Palettes {
    /// The palettes of a file referred to with `flags` from a file with the palettes `parent`.
    ///
    /// The file's own palette replaces one that the parent lacks.
    pub fn under(&self, parent: &Palettes, flags: u32) -> Palettes {
        fn choose<T>(own: &Rc<T>, parent: &Rc<T>, keeps_own: bool, empty: bool) -> Rc<T> {
            Rc::clone(if keeps_own || empty { own } else { parent })
        }
        let own = |bit| flags & bit != 0;
        Palettes {
            colors: choose(
                &self.colors,
                &parent.colors,
                own(OWN_COLORS),
                parent.colors.is_empty(),
            ),
            materials: choose(
                &self.materials,
                &parent.materials,
                own(OWN_MATERIALS),
                parent.materials.is_empty(),
            ),
            textures: choose(
                &self.textures,
                &parent.textures,
                own(OWN_TEXTURES),
                parent.textures.is_empty(),
            ),
            lights: choose(
                &self.lights,
                &parent.lights,
                own(OWN_LIGHTS),
                parent.lights.is_empty(),
            ),
        }
    }

    /// The colour with an index, or `None` if the palette is too short.
    ///
    /// The low seven bits are an intensity, the others the number of the colour.
    pub fn color(&self, index: u32) -> Option<Rgb> {
        let color = *self.colors.get((index >> 7) as usize)?;
        Some(color * (f64::from(index & 127) / 127.0))
    }
}

/// A number, or 0 if it is not finite.
fn finite(x: Option<f64>) -> f64 {
    x.filter(|x| x.is_finite()).unwrap_or(0.0)
}

/// A colour at `at`, with 0 for components that are not finite.
fn color(fields: RecordFields, at: usize) -> Rgb {
    let given = fields.color(at).unwrap_or_default();
    given.map(|x| finite(Some(x)))
}

/// The colours of record 32.
pub(super) fn colors(record: RecordFields, revision: u32) -> Vec<Rgb> {
    const FIRST: usize = 132;
    let most = if revision >= 1510 { 1024 } else { 512 };
    (0..most)
        .map_while(|k| record.packed_color(FIRST + 4 * k))
        .collect()
}

/// The material of record 113 and its index; `None` if the record is too short.
pub(super) fn material(record: RecordFields) -> Option<(i32, PaletteMaterial)> {
    let name = record.text(8, 12);
    Some((record.i32(4)?, material_numbers(record, 24, name)?))
}

/// The materials of record 66 with their indices.
pub(super) fn old_materials(record: RecordFields) -> impl Iterator<Item = (i32, PaletteMaterial)> {
    const SIZE: usize = 184;
    (0..64).map_while(move |k| {
        let at = 4 + SIZE * k as usize;
        let name = record.text(at + 60, 12);
        Some((k, material_numbers(record, at, name)?))
    })
}

/// Ambient, diffuse, specular and emissive colour, shininess and alpha, which are consecutive.
fn material_numbers(record: RecordFields, at: usize, name: String) -> Option<PaletteMaterial> {
    let alpha = record.single(at + 52)?;
    Some(PaletteMaterial {
        name,
        diffuse: color(record, at + 12),
        specular: color(record, at + 24),
        emissive: color(record, at + 36),
        shininess: finite(record.single(at + 48)),
        alpha: finite(Some(alpha)).clamp(0.0, 1.0),
    })
}

/// The texture of record 64 and its index.
pub(super) fn texture(
    record: RecordFields,
    revision: u32,
    named_by: &Rc<str>,
) -> Option<(i32, TextureFile)> {
    let length = if revision < 1400 { 80 } else { 200 };
    let texture = TextureFile {
        name: record.text(4, length),
        named_by: Rc::clone(named_by),
    };
    Some((record.i32(4 + length)?, texture))
}

/// The light source of record 102 and its index.
pub(super) fn light(record: RecordFields) -> Option<(i32, PaletteLight)> {
    let light = PaletteLight {
        name: record.text(16, 20),
        diffuse: color(record, 56),
        kind: record.i32(88)?,
        spot_exponent: finite(record.single(132)),
        spot_cutoff: finite(record.single(136)),
        attenuation: [148, 152, 156].map(|at| finite(record.single(at))),
    };
    Some((record.i32(4)?, light))
}
