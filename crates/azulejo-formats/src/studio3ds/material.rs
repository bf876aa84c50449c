//! Materials: chunk AFFF.

use super::chunk::{Chunk, ChunkWalker, name, vector};
use crate::reading::bytes::Bytes;
use crate::reading::text::shortened;
use crate::surface::phong::Highlight;
use azulejo_scene::{Material, Opacity, Rgb, Sidedness};
use glam::{DAffine2, DMat2, DVec2};

/// Reflectance of faces without a material, or with one without a colour.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// The content of a material chunk; `None` for what is absent.
#[derive(Debug, Default)]
pub(super) struct MaterialDefinition {
    pub name: String,
    pub at: u64,
    diffuse: Option<Rgb>,
    specular: Option<Rgb>,
    shininess: Option<f64>,
    strength: Option<f64>,
    transparency: Option<f64>,
    self_illumination: Option<f64>,
    is_two_sided: bool,
    /// Whether faces are flat-shaded, whatever their smoothing groups.
    pub is_flat: bool,
    /// The texture that replaces the diffuse colour.
    pub map: Option<TextureMap>,
    /// The texture whose brightness is the opacity.
    pub opacity_map: Option<TextureMap>,
}

/// A texture map.
#[derive(Debug)]
pub(super) struct TextureMap {
    pub file: String,
    scale: DVec2,
    offset: DVec2,
    /// Degrees.
    rotation: f64,
}

impl MaterialDefinition {
    /// Reads a material chunk.
    pub fn read<'a>(walker: &mut ChunkWalker<'_>, chunk: &Chunk<'a>) -> MaterialDefinition {
        let mut definition = MaterialDefinition {
            at: chunk.at,
            ..MaterialDefinition::default()
        };
        let mut body = chunk.body;
        while let Some(child) = walker.next(&mut body) {
            definition.entry(walker, child);
        }
        definition
    }

    fn entry<'a>(&mut self, walker: &mut ChunkWalker<'_>, mut chunk: Chunk<'a>) {
        match chunk.id {
            0xa000 => self.name = name(&mut chunk.body),
            // The ambient colour approximates light that azulejo computes; soft highlights and wire
            // sizes do not affect what is kept.
            0xa010 | 0xa087 | 0xa08a | 0xa08c => {}
            0xa020 => self.diffuse = walker.color(&chunk),
            0xa030 => self.specular = walker.color(&chunk),
            0xa040 => self.shininess = walker.percent(&chunk),
            0xa041 => self.strength = walker.percent(&chunk),
            0xa050 => self.transparency = walker.percent(&chunk),
            0xa080 => self.self_illumination = self.self_illumination.or(Some(1.0)),
            0xa081 => self.is_two_sided = true,
            0xa084 => self.self_illumination = walker.percent(&chunk),
            0xa085 => walker.skipped(&chunk, "wireframe material"),
            0xa100 => self.is_flat = walker.data(&mut chunk, Bytes::i16_le) == Some(1),
            0xa200 => self.map = TextureMap::read(walker, &chunk),
            0xa210 => self.opacity_map = TextureMap::read(walker, &chunk),
            0xa052 | 0xa053 | 0xa083 => walker.see_through_detail(&chunk),
            _ => walker.skipped(&chunk, what(chunk.id)),
        }
    }

    /// The material without its texture.
    pub fn material(&self, walker: &mut ChunkWalker<'_>) -> Material {
        let diffuse = self.diffuse.unwrap_or(DEFAULT_REFLECTANCE);
        let mut material = Material {
            emission: self.self_illumination.unwrap_or(0.0) * diffuse,
            emits_back: self.is_two_sided,
            // Without the chunk backs are culled by default, which few programs do with 3DS files.
            sidedness: if self.is_two_sided {
                Sidedness::Two
            } else {
                Sidedness::Unsaid
            },
            ..Material::diffuse(self.name.clone(), diffuse)
        };
        material.emits_back &= material.is_emitter();
        if !material.limit_reflectance() {
            let shown = shortened(&self.name);
            let message = format!("material \"{shown}\" with a colour above 1: clamped");
            walker.warn(self.at, message);
        }
        let opacity = Opacity::constant(1.0 - self.transparency.unwrap_or(0.0).clamp(0.0, 1.0));
        material.opacity = (!opacity.is_opaque()).then_some(opacity);
        self.highlight(&mut material, walker);
        material
    }

    /// The specular highlight, with the exponent 2^(10 × shininess).
    fn highlight(&self, material: &mut Material, walker: &mut ChunkWalker<'_>) {
        let strength = self.strength.unwrap_or(1.0);
        let Some(shininess) = self.shininess.or(self.strength) else {
            return;
        };
        let specular = strength * self.specular.unwrap_or_default().map(|x| x.min(1.0));
        let highlight = Highlight::mirrored((10.0 * shininess).exp2(), specular);
        if let Err(message) = walker.gloss.highlight(material, highlight) {
            walker.warn(self.at, message);
        }
    }
}

impl ChunkWalker<'_> {
    /// Transparency falloff and the like are present in every material; only non-zero values
    /// matter.
    fn see_through_detail(&mut self, chunk: &Chunk<'_>) {
        if self.percent(chunk) != Some(0.0) {
            self.skipped(chunk, what(chunk.id));
        }
    }
}

impl TextureMap {
    fn read<'a>(walker: &mut ChunkWalker<'_>, chunk: &Chunk<'a>) -> Option<TextureMap> {
        let mut map = TextureMap {
            file: String::new(),
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            rotation: 0.0,
        };
        let mut body = chunk.body;
        while let Some(child) = walker.next(&mut body) {
            map.entry(walker, child);
        }
        if map.file.is_empty() {
            walker.skipped(chunk, "texture map without a file");
            return None;
        }
        Some(map)
    }

    fn entry<'a>(&mut self, walker: &mut ChunkWalker<'_>, mut chunk: Chunk<'a>) {
        match chunk.id {
            0x0030 | 0x0031 => self.strength(walker, chunk),
            0xa300 => self.file = name(&mut chunk.body),
            0xa351 => {
                // Bits 0, 1, 3 and 4: decal, mirrored, negative, not repeated.
                if walker.data(&mut chunk, Bytes::u16_le).unwrap_or(0) & 0b1_1011 != 0 {
                    walker.skipped(
                        &chunk,
                        "texture map as decal, mirrored, negative or not repeated",
                    );
                }
            }
            0xa353 => {}
            0xa354 => self.scale.y = number(walker, chunk, 1.0),
            0xa356 => self.scale.x = number(walker, chunk, 1.0),
            0xa358 => self.offset.x = number(walker, chunk, 0.0),
            0xa35a => self.offset.y = number(walker, chunk, 0.0),
            0xa35c => self.rotation = number(walker, chunk, 0.0),
            0xa360 | 0xa362 | 0xa364 | 0xa366 | 0xa368 => {
                walker.skipped(&chunk, "tint of a texture map")
            }
            _ => walker.skipped(&chunk, what(chunk.id)),
        }
    }

    fn strength(&mut self, walker: &mut ChunkWalker<'_>, chunk: Chunk<'_>) {
        let mut bytes = chunk.body;
        let full = match chunk.id {
            0x0030 => bytes.i16_le().map(f32::from) == Some(100.0),
            _ => bytes.f32_le() == Some(1.0),
        };
        if !full {
            walker.warn(
                chunk.at,
                "texture map with a strength below 100 %: taken as 100 %",
            );
        }
    }

    /// The map of texture coordinates by the texture's scale, offset and rotation about its centre;
    /// `None` for the identity.
    pub fn transform(&self) -> Option<DAffine2> {
        let middle = DVec2::splat(0.5);
        // 3D Studio's angles are clockwise.
        let matrix =
            DMat2::from_diagonal(self.scale) * DMat2::from_angle(-self.rotation.to_radians());
        let map = DAffine2::from_mat2_translation(matrix, middle - matrix * (middle + self.offset));
        let is_plain =
            self.scale == DVec2::ONE && self.offset == DVec2::ZERO && self.rotation == 0.0;
        (!is_plain && map.is_finite()).then_some(map)
    }
}

fn number(walker: &mut ChunkWalker<'_>, mut chunk: Chunk<'_>, default: f64) -> f64 {
    let [value] = walker.data(&mut chunk, vector).unwrap_or([default]);
    if value.is_finite() { value } else { default }
}

/// Description of a skipped chunk of a material; empty for an unknown one.
fn what(id: u16) -> &'static str {
    match id {
        0xa052 => "transparency falloff",
        0xa053 => "reflection blur",
        0xa083 => "additive transparency",
        0xa088 => "decal",
        0xa204 => "specular map",
        0xa220 | 0xa310 => "reflection map",
        0xa230 => "bump map",
        0xa240 => "alpha of a map",
        0xa250 | 0xa252 => "height of a bump map",
        0xa33a => "second texture",
        0xa33c => "shininess map",
        0xa33d => "self-illumination map",
        0xa33e | 0xa340 | 0xa342 | 0xa344 | 0xa346 | 0xa348 | 0xa34a | 0xa34c => "mask of a map",
        0xa320 => "procedural map",
        _ => "",
    }
}
