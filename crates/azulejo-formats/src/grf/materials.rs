//! From what a file says about a surface to a material.

use super::brdf::COMBINATION;
use super::document::MaterialNote;
use azulejo_scene::{Brdf, Dielectric, Material, Rgb, TextureId};

/// Reflectance of surfaces about which a file says nothing.
pub(super) const DEFAULT_REFLECTANCE: Rgb = Rgb::grey(0.5);

/// The warning when [`limit`] had something to do.
pub(super) const REFLECTS_TOO_MUCH: &str =
    "a material reflects less than nothing or more than arrives; limited to 0..1";

/// A material and how much of it the file said.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub material: Material,
    /// Whether the diffuse reflectance was said; a colour multiplies it then, and is it otherwise.
    pub says_diffuse: bool,
    /// A model of which only the diffuse part is used.
    pub unevaluated: Option<String>,
}

/// What a `brdf` makes.
pub(super) fn surface(name: &str, brdf: &Brdf) -> Surface {
    let mut surface = match brdf {
        Brdf::File(path) => Surface {
            unevaluated: Some(format!("\"{path}\"")),
            ..Surface::default()
        },
        Brdf::Model { name, parameters } if name == COMBINATION => combination(parameters),
        Brdf::Model { name, parameters } => model(name, parameters),
    };
    surface.material.name = name.to_owned();
    if surface.unevaluated.is_some() {
        surface.material.brdf = Some(brdf.clone());
    }
    if !surface.says_diffuse {
        surface.material.diffuse = DEFAULT_REFLECTANCE;
    }
    surface
}

type Parameter = (String, Vec<f64>);

/// A parameter that is a number or an (r, g, b).
fn rgb(parameters: &[Parameter], key: &str) -> Option<Rgb> {
    let (_, value) = parameters
        .iter()
        .find(|(k, _)| k.eq_ignore_ascii_case(key))?;
    match value[..] {
        [grey] => Some(Rgb::grey(grey)),
        [r, g, b] => Some(Rgb::new(r, g, b)),
        _ => None,
    }
}

fn model(name: &str, parameters: &[Parameter]) -> Surface {
    let mut surface = Surface::default();
    let diffuse = rgb(parameters, "kd");
    surface.says_diffuse = diffuse.is_some() || name == "specular";
    surface.material.diffuse = diffuse.unwrap_or(Rgb::BLACK);
    match name {
        "diffuse" => {}
        "specular" => surface.material.mirror = rgb(parameters, "ks").unwrap_or(Rgb::WHITE),
        _ => surface.unevaluated = Some(format!("`{name}`")),
    }
    surface
}

/// `weight = w` holds for the models behind it, up to the next weight.
fn combination(parameters: &[Parameter]) -> Surface {
    let mut sum = Surface::default();
    let mut weight = 1.0;
    let is_part = |(_, value): &Parameter| value.is_empty();
    for (at, (key, value)) in parameters.iter().enumerate() {
        if key.eq_ignore_ascii_case("weight") {
            weight = value.first().copied().unwrap_or(1.0);
        }
        if !value.is_empty() {
            continue;
        }
        let rest = &parameters[at + 1..];
        let end = rest.iter().position(is_part).unwrap_or(rest.len());
        let part = model(key, &rest[..end]);
        sum.material.diffuse += weight * part.material.diffuse;
        sum.material.mirror += weight * part.material.mirror;
        sum.says_diffuse |= part.says_diffuse;
        sum.unevaluated = sum.unevaluated.or(part.unevaluated);
    }
    sum
}

impl Surface {
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
            material.brdf = Some(Brdf::File(path.clone()));
        }
        if let Some(textures) = textures {
            material.textures = textures;
        }
    }
}
