//! Appearance of faces: their attributes, and the resulting materials.

use super::document::FltDocument;
use super::fields::RecordFields;
use super::palettes::{PaletteMaterial, Palettes};
use super::warn::RecordWarnings;
use crate::Files;
use crate::surface::gloss::Gloss;
use crate::surface::materials::Materials;
use crate::surface::phong::Highlight;
use crate::surface::textures::Textures;
use azulejo_scene::{Material, MaterialId, Opacity, Rgb, Sidedness};
use std::collections::HashMap;

/// Appearance attributes of faces and meshes, in record order.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceAttributes {
    /// The draw type: 0 one-sided, 1 two-sided, more for what is not a plain surface.
    draw: u8,
    texture_white: bool,
    pub billboard: bool,
    /// Whether the alpha channel of the texture is an opacity.
    is_blended: bool,
    texture: i32,
    material: i32,
    /// 0 opaque to 65535 transparent.
    transparency: u16,
    flags: u32,
    light_mode: u8,
    packed_color: Option<Rgb>,
    color: Option<u32>,
}

impl FaceAttributes {
    const NO_COLOR: u32 = 1 << 30;
    const PACKED: u32 = 1 << 28;
    const HIDDEN: u32 = 1 << 26;

    /// The attributes of a face, or of a mesh, whose fields are four bytes further on.
    pub fn new(record: RecordFields, is_mesh: bool, document: &FltDocument) -> FaceAttributes {
        let shift = if is_mesh { 4 } else { 0 };
        let index = |at: usize| record.i16(at + shift).map_or(-1, i32::from);
        let flags = record.u32(44 + shift).unwrap_or_default();
        // Before revision 15.1, index and intensity were stored in place of the colour name index.
        let color = match document.revision {
            ..1510 => record.u16(20 + shift).map(u32::from),
            _ => record.u32(68 + shift),
        };
        let is_packed = flags & FaceAttributes::PACKED != 0 || document.packed_colors;
        let packed = is_packed.then(|| record.packed_color(56 + shift));
        FaceAttributes {
            draw: record.u8(18 + shift).unwrap_or_default(),
            texture_white: record.u8(19 + shift).is_some_and(|white| white != 0),
            billboard: matches!(record.u8(25 + shift), Some(2 | 4)),
            is_blended: matches!(record.u8(25 + shift), Some(1 | 2 | 4)),
            texture: index(28),
            material: index(30),
            transparency: record.u16(40 + shift).unwrap_or_default(),
            flags,
            light_mode: record.u8(48 + shift).unwrap_or_default(),
            packed_color: packed.flatten(),
            color,
        }
    }

    /// Whether vertex colours replace the face colour.
    pub fn is_gouraud(&self) -> bool {
        matches!(self.light_mode, 1 | 3)
    }

    /// Whether the face is lit, so that its material applies.
    fn is_lit(&self) -> bool {
        matches!(self.light_mode, 2 | 3)
    }

    /// The sides that the draw type shows.
    fn sidedness(&self) -> Sidedness {
        match self.draw {
            // Type 4 is type 0 with an outline.
            0 | 4 => Sidedness::One,
            1 => Sidedness::Two,
            _ => Sidedness::Unsaid,
        }
    }

    pub fn has_texture(&self) -> bool {
        self.texture >= 0
    }

    /// Why faces with these attributes are skipped, if they are.
    pub fn skipped(&self) -> Option<&'static str> {
        match self.draw {
            _ if self.flags & FaceAttributes::HIDDEN != 0 => Some("hidden face: skipped"),
            2 | 3 => Some("face drawn as a wireframe: skipped"),
            8..=10 => Some("face drawn as light points: skipped"),
            _ if self.transparency == u16::MAX => Some("fully transparent face: skipped"),
            _ => None,
        }
    }

    /// The opacity of a face, below objects with a given opacity.
    pub fn opacity(&self, above: f64, palettes: &Palettes) -> f64 {
        let lit = self.is_lit().then_some(self.material);
        let entry = lit.and_then(|index| palettes.materials.get(&index));
        let own = 1.0 - f64::from(self.transparency) / f64::from(u16::MAX);
        above * own * entry.map_or(1.0, |entry| entry.alpha)
    }

    /// The colour of the face itself.
    pub fn color(&self, palettes: &Palettes, notes: &mut RecordWarnings) -> Rgb {
        if (self.texture_white && self.has_texture()) || self.flags & FaceAttributes::NO_COLOR != 0
        {
            return Rgb::WHITE;
        }
        let index = match (self.packed_color, self.color) {
            (Some(color), _) => return color,
            (None, None | Some(u32::MAX)) => return Rgb::WHITE,
            (None, Some(index)) => index,
        };
        palettes.color(index).unwrap_or_else(|| {
            notes.add("face with a colour index beyond the palette: white");
            Rgb::WHITE
        })
    }
}

/// The materials of the scene, with a cache by face attributes.
pub(super) struct FltMaterials<'f> {
    files: &'f dyn Files,
    pub materials: Materials,
    gloss: Gloss,
    pub textures: Textures,
    known: HashMap<FltMaterialKey, MaterialId>,
}

/// Everything on which the material of a face depends; palettes are represented by their set
/// number.
#[derive(Debug, PartialEq, Eq, Hash)]
struct FltMaterialKey {
    palettes: u32,
    material: Option<i32>,
    texture: i32,
    color: [u64; 3],
    sidedness: Sidedness,
    opacity: u64,
    is_blended: bool,
}

impl<'f> FltMaterials<'f> {
    pub fn new(files: &'f dyn Files) -> FltMaterials<'f> {
        FltMaterials {
            files,
            materials: Materials::default(),
            gloss: Gloss::default(),
            textures: Textures::default(),
            known: HashMap::new(),
        }
    }

    /// The material of a face with colour `color` and an opacity. `set` is the number of the set of
    /// palettes.
    pub fn material(
        &mut self,
        style: &FaceAttributes,
        (color, opacity): (Rgb, f64),
        (set, palettes): (u32, &Palettes),
        notes: &mut RecordWarnings,
    ) -> MaterialId {
        let request = FltMaterialKey {
            palettes: set,
            material: style.is_lit().then_some(style.material),
            texture: style.texture,
            color: color.to_array().map(f64::to_bits),
            sidedness: style.sidedness(),
            opacity: opacity.to_bits(),
            is_blended: style.is_blended,
        };
        if let Some(&known) = self.known.get(&request) {
            return known;
        }
        let id = self.build(&request, color, palettes, notes);
        self.known.insert(request, id);
        id
    }

    fn build(
        &mut self,
        request: &FltMaterialKey,
        color: Rgb,
        palettes: &Palettes,
        notes: &mut RecordWarnings,
    ) -> MaterialId {
        let mut material = Material::diffuse("", color);
        if let Some(index) = request.material.filter(|index| *index >= 0) {
            match palettes.materials.get(&index) {
                Some(entry) => apply(entry, &mut material, notes),
                None => notes.add("material index that is not in the palette: white"),
            }
        }
        material.emits_back = material.is_emitter() && request.sidedness == Sidedness::Two;
        material.sidedness = request.sidedness;
        if !material.limit_reflectance() {
            notes.add("material with a reflectance outside 0..1: clamped");
        }
        let entry = request
            .material
            .and_then(|index| palettes.materials.get(&index));
        if let Some(entry) = entry {
            let highlight = Highlight::half(entry.shininess, entry.specular);
            if let Err(message) = self.gloss.highlight(&mut material, highlight) {
                notes.add(message);
            }
        }
        if request.texture >= 0 {
            match palettes.textures.get(&request.texture) {
                Some(file) => {
                    let (of, name) = (&file.named_by, &file.name);
                    let (id, problem) = self.textures.index(of, name, self.files);
                    problem.into_iter().for_each(|p| notes.add(p));
                    material.textures.push(id);
                }
                None => notes.add("texture index that is not in the palette: ignored"),
            }
        }
        let alpha = self.textures.alpha_of(&material.textures);
        let opacity = Opacity {
            picture: alpha.filter(|_| request.is_blended),
            ..Opacity::constant(f64::from_bits(request.opacity).clamp(0.0, 1.0))
        };
        material.opacity = (!opacity.is_opaque()).then_some(opacity);
        self.materials.index(material)
    }
}

/// Multiplies a face's colour by an entry of the material palette.
fn apply(entry: &PaletteMaterial, material: &mut Material, notes: &mut RecordWarnings) {
    material.name.clone_from(&entry.name);
    material.diffuse *= entry.diffuse;
    material.emission = entry.emissive.map(|e| e.max(0.0));
    if entry.emissive != material.emission {
        notes.add("material with negative emission: clamped to 0");
    }
}
