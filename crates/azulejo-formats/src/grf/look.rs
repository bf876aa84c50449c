//! Looks of faces, and the materials that they make.

use super::brdf::Reflection;
use super::document::{Body, Change, Kind, Name, ObjectNotes, Place};
use super::materials::{DEFAULT_REFLECTANCE, REFLECTS_TOO_MUCH, Surface, surface};
use super::resolve::{Resolved, Resolver};
use azulejo_scene::{Material, MaterialId, Rgb, TextureId};
use std::sync::Arc;

/// Textures on one face: every change of a look copies them.
pub(super) const MOST_TEXTURES: usize = 64;

/// How faces look at some point of a list.
#[derive(Clone, Debug, Default)]
pub(super) struct Look<'d> {
    color: Option<Rgb>,
    color_name: &'d str,
    brdf: Option<Base<'d>>,
    textures: Vec<TextureId>,
}

#[derive(Clone, Copy, Debug)]
enum Base<'d> {
    /// A `def brdf`.
    Named(MaterialId),
    /// One that stands before a face.
    InPlace(&'d Arc<Reflection>),
}

/// What makes a derived material distinct. Numbers are compared by their bits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    named: Option<MaterialId>,
    /// The address of the brdf in the document: of equal ones there is one.
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

/// Looks of faces.
impl<'d> Resolver<'d> {
    pub fn change(
        &mut self,
        look: &mut Look<'d>,
        change: &'d Change,
        is_stacking: &mut bool,
        place: Place,
    ) -> Resolved<()> {
        match change {
            Change::Set(Body::Color(rgb)) => (look.color, look.color_name) = (Some(*rgb), ""),
            Change::Use(Kind::Color, name) => {
                (look.color, look.color_name) = (Some(self.color_named(name, place)?), name);
            }
            Change::Set(Body::Brdf(brdf)) => {
                look.brdf = Some(Base::InPlace(brdf));
            }
            Change::Use(Kind::Brdf, name) => {
                let id = self.brdf_named(name, place)?;
                look.brdf = Some(Base::Named(id));
                if self.surfaces.get(&id).is_some_and(|s| s.sets_textures) {
                    look.textures
                        .clone_from(&self.scene.materials[id as usize].textures);
                    *is_stacking = false;
                }
            }
            Change::Set(Body::Texture(path)) => {
                let id = self.texture_in_place(path, place);
                look.texture(id, is_stacking);
            }
            Change::Use(Kind::Texture, name) => {
                let id = self.texture_named(name, place)?;
                look.texture(id, is_stacking);
            }
            // The parser lets `use` have the three others alone.
            Change::Use(Kind::Figure | Kind::Solid, _) => {}
        }
        Ok(())
    }

    /// The material of a look. `emission` is the radiance of the mesh or light; a mesh with
    /// colours at its vertices `is_colored`.
    pub fn material(
        &mut self,
        look: &Look<'d>,
        emission: Option<Rgb>,
        is_colored: bool,
        place: Place,
    ) -> MaterialId {
        let key = Key {
            named: match look.brdf {
                Some(Base::Named(id)) => Some(id),
                _ => None,
            },
            in_place: match look.brdf {
                Some(Base::InPlace(brdf)) => Some(Arc::as_ptr(brdf) as usize),
                _ => None,
            },
            color: look.color.map(bits),
            color_name: look.color_name.to_owned(),
            textures: look.textures.clone(),
            emission: emission.map(bits),
            is_colored,
        };
        if let Some(&known) = self.derived.get(&key) {
            return known;
        }
        let material = self.derive(look, emission, is_colored, place);
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

    /// Each face may make a material of its own out of a few bytes, with a copy of a long name;
    /// that ends somewhere.
    fn within_budget(&mut self, mut material: Material, place: Place) -> Material {
        match self.budget.checked_sub(material.name.len()) {
            Some(left) => self.budget = left,
            None => {
                self.warn(place, "there are too many materials to keep all names", 1);
                material.name.clear();
            }
        }
        material
    }

    fn derive(
        &mut self,
        look: &Look<'d>,
        emission: Option<Rgb>,
        is_colored: bool,
        place: Place,
    ) -> Material {
        let mut made = match look.brdf {
            Some(Base::Named(id)) => match self.surfaces.get(&id) {
                Some(known) => known.surface.clone(),
                None => Surface::default(),
            },
            Some(Base::InPlace(brdf)) => surface("", brdf),
            None => Surface {
                material: Material::diffuse("", silent_reflectance(emission, is_colored)),
                ..Surface::default()
            },
        };
        let material = &mut made.material;
        if let Some(color) = look.color {
            material.diffuse = match made.says_diffuse {
                true => material.diffuse * color,
                false => color,
            };
        }
        if material.name.is_empty() {
            material.name = look.color_name.to_owned();
        }
        material.textures.clone_from(&look.textures);
        if let Some(radiance) = emission {
            material.emission = radiance;
        }
        if !material.limit_reflectance() {
            self.warn(place, REFLECTS_TOO_MUCH, 1);
        }
        made.material
    }

    /// The material of a light or primitive, of which a note may name the brdf.
    pub fn noted_material(
        &mut self,
        notes: &'d ObjectNotes,
        emission: Option<Rgb>,
        place: Place,
    ) -> Resolved<MaterialId> {
        self.named_material(notes.material.as_ref(), emission, place)
    }

    /// The material that a brdf's name alone makes; grey without one.
    pub fn named_material(
        &mut self,
        name: Option<&'d Name>,
        emission: Option<Rgb>,
        place: Place,
    ) -> Resolved<MaterialId> {
        let mut look = Look::default();
        if let Some(name) = name {
            let id = self.brdf_named(name, place)?;
            look.brdf = Some(Base::Named(id));
            look.textures
                .clone_from(&self.scene.materials[id as usize].textures);
        }
        Ok(self.material(&look, emission, false, place))
    }
}

/// Reflectance of a surface about which a file says nothing: a lamp's is black, and colours at
/// vertices are the reflectance themselves.
fn silent_reflectance(emission: Option<Rgb>, is_colored: bool) -> Rgb {
    match (emission, is_colored) {
        (Some(_), _) => Rgb::BLACK,
        (None, true) => Rgb::WHITE,
        (None, false) => DEFAULT_REFLECTANCE,
    }
}

impl Look<'_> {
    /// A texture replaces those before the last face, and is added to those behind it, of which a
    /// file that means well has a few.
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
