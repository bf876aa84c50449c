//! From what a file says about a surface to a material.

use super::brdf::{GrfReflection, plain, says_diffuse};
use super::document::MaterialNote;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Dielectric, Material, Rgb, TextureId};

/// Reflectance of surfaces about which a file says nothing.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// The warning when [`limit`] had something to do.
pub(super) const REFLECTS_TOO_MUCH: &str =
    "a material reflects less than nothing or more than arrives; limited to 0..1";

/// A material and how much of it the file said.
#[derive(Clone, Debug, Default)]
pub(super) struct DefinedMaterial {
    pub material: Material,
    /// Whether the diffuse reflectance was said; a colour multiplies it then, and is it otherwise.
    pub says_diffuse: bool,
}

/// What a `brdf` makes.
pub(super) fn surface(name: &str, reflection: &GrfReflection) -> DefinedMaterial {
    let description = &reflection.description;
    let mut material = match &reflection.brdf {
        Some(brdf) => Material::with_brdf(name, brdf.clone()),
        None => {
            let said = plain(description).unwrap_or_default();
            Material {
                mirror: said.mirror,
                ..Material::diffuse(name, said.diffuse)
            }
        }
    };
    let is_black = material.diffuse.is_black();
    // Of a file that is not there nothing is known.
    if matches!(description, Description::File { content: None, .. }) {
        material.diffuse = DEFAULT_REFLECTANCE;
    }
    DefinedMaterial {
        material,
        says_diffuse: says_diffuse(description) || !is_black,
    }
}

impl DefinedMaterial {
    /// Completes a material by what its `ext material` says; `textures` are those of the note.
    pub fn annotate(&mut self, note: &MaterialNote, textures: Option<Vec<TextureId>>) {
        let material = &mut self.material;
        if let Some(name) = &note.name {
            material.name.clone_from(name);
        }
        if let Some(diffuse) = note.diffuse {
            material.diffuse = diffuse;
            self.says_diffuse = true;
        }
        if let Some(mirror) = note.mirror {
            material.mirror = mirror;
        }
        if let Some(emission) = note.emission {
            material.emission = emission;
        }
        material.emits_back |= note.emits_back;
        if let Some(ior) = note.ior {
            material.dielectric = Some(Dielectric {
                ior,
                transmittance: note.transmittance.unwrap_or(Rgb::WHITE),
                thin: note.thin,
            });
        }
        if let Some(path) = &note.brdf_file {
            material.brdf.clone_from(&path.brdf);
        }
        if let Some(textures) = textures {
            material.textures = textures;
        }
    }
}
