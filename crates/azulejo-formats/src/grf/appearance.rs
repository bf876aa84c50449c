//! Appearances of faces, and the materials derived from them.

use super::brdf::GrfReflection;
use super::document::{
    AppearanceChange, DefinitionBody, GrfName, NameKind, ObjectNotes, SourcePosition,
};
use super::materials::{DEFAULT_REFLECTANCE, DefinedMaterial, REFLECTS_TOO_MUCH, surface};
use super::resolve::{GrfResolver, ResolveResult};
use azulejo_scene::{Material, MaterialId, Rgb, TextureId};
use std::sync::Arc;

/// Maximum number of textures on one face: every change of an appearance copies them.
pub(super) const MOST_TEXTURES: usize = 64;

/// The appearance of faces at one point of a list.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceAppearance<'d> {
    color: Option<Rgb>,
    color_name: &'d str,
    brdf: Option<AppearanceBase<'d>>,
    textures: Vec<TextureId>,
}

#[derive(Clone, Copy, Debug)]
enum AppearanceBase<'d> {
    /// A `def brdf`.
    Named(MaterialId),
    /// One given before a face.
    InPlace(&'d Arc<GrfReflection>),
}

/// Everything that distinguishes a derived material. Numbers are compared bit by bit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct DerivedMaterialKey {
    named: Option<MaterialId>,
    /// The address of the brdf in the document, where equal ones are stored once.
    in_place: Option<usize>,
    color: Option<[u64; 3]>,
    color_name: String,
    textures: Vec<TextureId>,
    emission: Option<[u64; 3]>,
    is_colored: bool,
}

fn bits(rgb: Rgb) -> [u64; 3] {
    rgb.to_array().map(f64::to_bits)
}

impl<'d> GrfResolver<'d> {
    pub fn change(
        &mut self,
        appearance: &mut FaceAppearance<'d>,
        change: &'d AppearanceChange,
        is_stacking: &mut bool,
        place: SourcePosition,
    ) -> ResolveResult<()> {
        match change {
            AppearanceChange::Set(DefinitionBody::Color(rgb)) => {
                (appearance.color, appearance.color_name) = (Some(*rgb), "")
            }
            AppearanceChange::Use(NameKind::Color, name) => {
                (appearance.color, appearance.color_name) =
                    (Some(self.color_named(name, place)?), name);
            }
            AppearanceChange::Set(DefinitionBody::Brdf(brdf)) => {
                appearance.brdf = Some(AppearanceBase::InPlace(brdf));
            }
            AppearanceChange::Use(NameKind::Brdf, name) => {
                let id = self.brdf_named(name, place)?;
                appearance.brdf = Some(AppearanceBase::Named(id));
                if self.surfaces.get(&id).is_some_and(|s| s.sets_textures) {
                    appearance
                        .textures
                        .clone_from(&self.scene.materials[id as usize].textures);
                    *is_stacking = false;
                }
            }
            AppearanceChange::Set(DefinitionBody::Texture(path)) => {
                let id = self.texture_in_place(path, place);
                appearance.texture(id, is_stacking);
            }
            AppearanceChange::Use(NameKind::Texture, name) => {
                let id = self.texture_named(name, place)?;
                appearance.texture(id, is_stacking);
            }
            // The parser accepts `use` for the three other types only.
            AppearanceChange::Use(NameKind::Figure | NameKind::Solid, _) => {}
        }
        Ok(())
    }

    /// The material of an appearance. `emission` is the radiance of the mesh or light; `is_colored`
    /// holds for a mesh with vertex colours.
    pub fn material(
        &mut self,
        appearance: &FaceAppearance<'d>,
        emission: Option<Rgb>,
        is_colored: bool,
        place: SourcePosition,
    ) -> MaterialId {
        let key = DerivedMaterialKey {
            named: match appearance.brdf {
                Some(AppearanceBase::Named(id)) => Some(id),
                _ => None,
            },
            in_place: match appearance.brdf {
                Some(AppearanceBase::InPlace(brdf)) => Some(Arc::as_ptr(brdf) as usize),
                _ => None,
            },
            color: appearance.color.map(bits),
            color_name: appearance.color_name.to_owned(),
            textures: appearance.textures.clone(),
            emission: emission.map(bits),
            is_colored,
        };
        if let Some(&known) = self.derived.get(&key) {
            return known;
        }
        let material = self.derive(appearance, emission, is_colored, place);
        let id = match key.named {
            Some(base) if self.scene.materials[base as usize] == material => base,
            _ => {
                let material = self.within_budget(material, place);
                self.scene.add_material(material)
            }
        };
        self.derived.insert(key, id);
        id
    }

    /// Limits the memory for derived materials: each face may create one from a few bytes, with a
    /// copy of a long name.
    fn within_budget(&mut self, mut material: Material, place: SourcePosition) -> Material {
        match self.budget.checked_sub(material.name.len()) {
            Some(left) => self.budget = left,
            None => {
                self.warn(
                    place,
                    "too many materials: the names of further ones are dropped",
                    1,
                );
                material.name.clear();
            }
        }
        material
    }

    fn derive(
        &mut self,
        appearance: &FaceAppearance<'d>,
        emission: Option<Rgb>,
        is_colored: bool,
        place: SourcePosition,
    ) -> Material {
        let mut made = match appearance.brdf {
            Some(AppearanceBase::Named(id)) => match self.surfaces.get(&id) {
                Some(known) => known.surface.clone(),
                None => DefinedMaterial::default(),
            },
            Some(AppearanceBase::InPlace(brdf)) => surface("", brdf),
            None => DefinedMaterial {
                material: Material::diffuse("", silent_reflectance(emission, is_colored)),
                ..DefinedMaterial::default()
            },
        };
        let material = &mut made.material;
        if let Some(color) = appearance.color {
            material.diffuse = if made.says_diffuse {
                material.diffuse * color
            } else {
                color
            };
        }
        if material.name.is_empty() {
            material.name = appearance.color_name.to_owned();
        }
        material.textures.clone_from(&appearance.textures);
        if let Some(radiance) = emission {
            material.emission = radiance;
        }
        if !material.limit_reflectance() {
            self.warn(place, REFLECTS_TOO_MUCH, 1);
        }
        made.material
    }

    /// The material of a light or primitive, whose brdf an extension may name.
    pub fn noted_material(
        &mut self,
        notes: &'d ObjectNotes,
        emission: Option<Rgb>,
        place: SourcePosition,
    ) -> ResolveResult<MaterialId> {
        self.named_material(notes.material.as_ref(), emission, place)
    }

    /// The material of a named brdf; grey without a name.
    pub fn named_material(
        &mut self,
        name: Option<&'d GrfName>,
        emission: Option<Rgb>,
        place: SourcePosition,
    ) -> ResolveResult<MaterialId> {
        let mut appearance = FaceAppearance::default();
        if let Some(name) = name {
            let id = self.brdf_named(name, place)?;
            appearance.brdf = Some(AppearanceBase::Named(id));
            appearance
                .textures
                .clone_from(&self.scene.materials[id as usize].textures);
        }
        Ok(self.material(&appearance, emission, false, place))
    }
}

/// Reflectance of a surface for which the file defines none: black for a light source, white if
/// vertex colours are the reflectance.
fn silent_reflectance(emission: Option<Rgb>, is_colored: bool) -> Rgb {
    match (emission, is_colored) {
        (Some(_), _) => Rgb::BLACK,
        (None, true) => Rgb::WHITE,
        (None, false) => DEFAULT_REFLECTANCE,
    }
}

impl FaceAppearance<'_> {
    /// The first texture of a face replaces the previous ones, further ones are added to it.
    fn texture(&mut self, id: TextureId, is_stacking: &mut bool) {
        if !*is_stacking {
            self.textures.clear();
        }
        if self.textures.len() < MOST_TEXTURES {
            self.textures.push(id);
        }
        *is_stacking = true;
    }
}
