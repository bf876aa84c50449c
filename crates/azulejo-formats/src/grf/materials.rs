//! Materials of surfaces as described in a file.

use super::brdf::{GrfReflection, PlainReflectance, has_diffuse, plain};
use super::document::MaterialNote;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Dielectric, Material, Rgb, Sidedness, TextureId};

/// Reflectance of surfaces for which a file defines none.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// The warning if [`limit`] changed a value.
pub(super) const REFLECTS_TOO_MUCH: &str = "material with a reflectance outside 0..1: clamped";

/// A material, and which parts of it the file defines.
#[derive(Clone, Debug, Default)]
pub(super) struct DefinedMaterial {
    pub material: Material,
    /// Whether the file defines the diffuse reflectance; if so, a colour multiplies it, otherwise
    /// replaces it.
    pub has_diffuse: bool,
}

/// The material of a `brdf`.
pub(super) fn surface(name: &str, reflection: &GrfReflection) -> DefinedMaterial {
    let description = &reflection.description;
    let mut material = match &reflection.brdf {
        Some(brdf) => Material::with_brdf(name, brdf.clone()),
        None => {
            let PlainReflectance { diffuse, mirror } = plain(description).unwrap_or_default();
            let material = Material::diffuse(name, diffuse);
            Material { mirror, ..material }
        }
    };
    let is_black = material.diffuse.is_black();
    // Nothing is known about a missing file.
    if matches!(description, Description::File { content: None, .. }) {
        material.diffuse = DEFAULT_REFLECTANCE;
    }
    DefinedMaterial {
        material,
        has_diffuse: has_diffuse(description) || !is_black,
    }
}

impl DefinedMaterial {
    /// Adds the attributes of an `ext material`; `textures` are those of the note.
    pub fn annotate(&mut self, note: &MaterialNote, textures: Option<Vec<TextureId>>) {
        let material = &mut self.material;
        if let Some(name) = &note.name {
            material.name.clone_from(name);
        }
        if let Some(diffuse) = note.diffuse {
            material.diffuse = diffuse;
            self.has_diffuse = true;
        }
        if let Some(mirror) = note.mirror {
            material.mirror = mirror;
        }
        if let Some(emission) = note.emission {
            material.emission = emission;
        }
        material.emits_back |= note.emits_back;
        if note.sidedness != Sidedness::Unsaid {
            material.sidedness = note.sidedness;
        }
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
