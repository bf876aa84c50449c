//! Glossy materials of all formats as reflection models.

use crate::surface::phong::Highlight;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Brdf, Material, Rgb};
use std::collections::HashMap;
use std::sync::Arc;

/// Distinct models of one file. Creating one usually takes a millisecond, forty at worst, but only a
/// few bytes of a file.
const MOST_MODELS: usize = 1 << 12;

/// The warning about further ones.
const TOO_MANY: &str = "more than 4096 glossy materials: taken as diffuse";

/// What materials that would create energy are scaled to: no paint reflects more, and what reflects all keeps light for
/// ever between surfaces that touch.
const MOST_REFLECTED: f64 = 0.9;

/// The warning about them.
const TOO_MUCH: &str = "glossy material that reflects more light than it receives: scaled to 90%";

/// The least mean roughness of a material whose roughness a picture varies: the model of the mean must not be a mirror.
pub(crate) const SMOOTHEST: f64 = 0.03;

/// The reflection models of one file, each once.
#[derive(Debug, Default)]
pub(crate) struct Gloss {
    known: HashMap<String, Option<Arc<Brdf>>>,
}

impl Gloss {
    /// The model of a description whose numbers are in range; `None` if there are too many models.
    pub fn model(&mut self, description: Description) -> Option<Arc<Brdf>> {
        let text = description.to_string();
        if let Some(known) = self.known.get(&text) {
            return known.clone();
        }
        if self.known.len() >= MOST_MODELS {
            return None;
        }
        let made = Brdf::new(description).ok().map(Arc::new);
        self.known.insert(text, made.clone());
        made
    }

    /// Adds a highlight to the diffuse and mirror reflectance of a material.
    ///
    /// # Errors
    /// A warning: the highlight is left out, or everything is scaled down to conserve energy.
    pub fn highlight(
        &mut self,
        material: &mut Material,
        highlight: Highlight,
    ) -> Result<(), &'static str> {
        let ks = highlight.reflectance();
        if ks.is_black() {
            return Ok(());
        }
        let sum = (material.diffuse + material.mirror + ks).max_channel();
        let scale = if sum > 1.0 + 1e-9 {
            MOST_REFLECTED / sum
        } else {
            1.0
        };
        let (kd, ks) = (within(material.diffuse * scale), ks * scale);
        // Rounding of a sum must not cause a model to be refused.
        let ks = Rgb::from([0, 1, 2].map(|k| ks[k].min(1.0 - kd[k])));
        let brdf = self.model(highlight.description(kd, ks)).ok_or(TOO_MANY)?;
        (material.diffuse, material.mirror) = (kd, within(material.mirror * scale));
        material.brdf = Some(brdf.limited());
        // The albedo of lobes under uniform light is known to about a hundredth.
        material.limit_reflectance();
        if scale < 1.0 { Err(TOO_MUCH) } else { Ok(()) }
    }

    /// Sets a material from glTF's base colour, metalness and roughness, all in 0..=1.
    ///
    /// Metals without roughness are mirrors; fully rough dielectrics are diffuse.
    ///
    /// # Errors
    /// A warning: the material becomes diffuse.
    pub fn metallic_roughness(
        &mut self,
        material: &mut Material,
        base: Rgb,
        metallic: f64,
        roughness: f64,
    ) -> Result<(), &'static str> {
        (material.diffuse, material.mirror) = (base * (1.0 - metallic), base * metallic);
        let is_plain = match metallic {
            0.0 => roughness >= 1.0,
            _ => roughness <= 0.0,
        };
        if is_plain {
            return Ok(());
        }
        let parameters = [
            ("base", base.into()),
            ("metallic", metallic.into()),
            ("roughness", roughness.into()),
        ];
        let Some(brdf) = self.model(Description::model("gltf_mr", parameters)) else {
            (material.diffuse, material.mirror) = (base, Rgb::BLACK);
            return Err(TOO_MANY);
        };
        cover(material, brdf);
        Ok(())
    }

    /// Sets the reflection model of a material from a description.
    ///
    /// # Errors
    /// A warning: the material stays unchanged.
    pub fn cover(
        &mut self,
        material: &mut Material,
        description: Description,
    ) -> Result<(), &'static str> {
        cover(material, self.model(description).ok_or(TOO_MANY)?);
        Ok(())
    }
}

/// Sets the model of a material and the fields that depend on it.
fn cover(material: &mut Material, brdf: Arc<Brdf>) {
    let covered = Material::with_brdf("", brdf);
    material.diffuse = within(covered.diffuse);
    material.mirror = within(covered.mirror);
    material.brdf = covered.brdf;
    material.limit_reflectance();
}

fn within(color: Rgb) -> Rgb {
    color.map(|c| c.clamp(0.0, 1.0))
}

/// Whether the diffuse reflectance of a material differs from that of its model.
pub(crate) fn is_repainted(material: &Material) -> bool {
    let of_model = |brdf: &Arc<Brdf>| within(brdf.mean_diffuse()) != material.diffuse;
    material.brdf.as_ref().is_some_and(of_model)
}
