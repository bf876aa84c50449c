//! Glossy materials of other formats as reflection models: one place for all of them.

use crate::surface::phong::Highlight;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Brdf, Material, Rgb};
use std::collections::HashMap;
use std::sync::Arc;

/// Distinct models of one file. Each takes a millisecond to make as a rule, forty at worst, and a few
/// bytes of a file to say.
const MOST_MODELS: usize = 1 << 12;

/// The warning about more of them.
const TOO_MANY: &str = "more glossy materials than 4096: matt";

/// The warning about what would create energy.
const TOO_MUCH: &str = "glossy material that reflects more than it gets: all of it scaled down";

/// The reflection models of one file, each once.
#[derive(Debug, Default)]
pub(crate) struct Gloss {
    known: HashMap<String, Option<Arc<Brdf>>>,
}

impl Gloss {
    /// The model of a description whose numbers are in range; `None` of one too many.
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

    /// Adds a highlight to what scatters and mirrors.
    ///
    /// # Errors
    /// A warning: it is left out, or everything is scaled down to be possible.
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
        let scale = if sum > 1.0 + 1e-9 { 1.0 / sum } else { 1.0 };
        let (kd, ks) = (within(material.diffuse * scale), ks * scale);
        // The last bit of a sum must not refuse a model.
        let ks = Rgb::from([0, 1, 2].map(|k| ks[k].min(1.0 - kd[k])));
        let brdf = self.model(highlight.description(kd, ks)).ok_or(TOO_MANY)?;
        (material.diffuse, material.mirror) = (kd, within(material.mirror * scale));
        material.brdf = Some(brdf.limited());
        // What lobes reflect of even light is known to about a hundredth.
        material.limit_reflectance();
        if scale < 1.0 { Err(TOO_MUCH) } else { Ok(()) }
    }

    /// Makes a surface of glTF's base colour, metalness and roughness, all in 0..=1.
    ///
    /// Metals without roughness are mirrors; dielectrics as rough as can be are matt.
    ///
    /// # Errors
    /// A warning: it becomes matt.
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

    /// Makes a surface of a description.
    ///
    /// # Errors
    /// A warning: the surface stays what it is.
    pub fn cover(
        &mut self,
        material: &mut Material,
        description: Description,
    ) -> Result<(), &'static str> {
        cover(material, self.model(description).ok_or(TOO_MANY)?);
        Ok(())
    }
}

/// Gives a material a model and what goes with it.
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

/// Whether the diffuse reflectance of a material is not what its model says.
pub(crate) fn is_repainted(material: &Material) -> bool {
    let of_model = |brdf: &Arc<Brdf>| within(brdf.mean_diffuse()) != material.diffuse;
    material.brdf.as_ref().is_some_and(of_model)
}
