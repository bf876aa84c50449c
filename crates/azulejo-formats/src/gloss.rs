//! Glossy materials of other formats as reflection models: one place for all of them.

use crate::phong::Highlight;
use azulejo_scene::brdf::{Description, Model, Value};
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

/// The one model of a material that has one.
pub(crate) fn model_of(material: &Material) -> Option<&Model> {
    match material.brdf.as_deref()?.description() {
        Description::Model(model) => Some(model),
        _ => None,
    }
}

/// A colour among the parameters of a model.
pub(crate) fn color(model: &Model, name: &str) -> Option<Rgb> {
    match model.value(name)? {
        Value::Number(grey) => Some(Rgb::grey(*grey)),
        Value::Color(color) => Some(*color),
        Value::Word(_) => None,
    }
}

/// A number among the parameters of a model.
pub(crate) fn number(model: &Model, name: &str) -> Option<f64> {
    match model.value(name)? {
        Value::Number(number) => Some(*number),
        _ => None,
    }
}

/// Base colour, metalness and roughness, if the material carries glTF's model.
pub(crate) fn gltf_mr(material: &Material) -> Option<(Rgb, f64, f64)> {
    let model = model_of(material).filter(|m| m.name == "gltf_mr")?;
    let metallic = number(model, "metallic").unwrap_or(0.0);
    let roughness = number(model, "roughness").unwrap_or(1.0);
    Some((color(model, "base")?, metallic, roughness))
}

/// Whether the diffuse reflectance of a material is not what its model says.
pub(crate) fn is_repainted(material: &Material) -> bool {
    let of_model = |brdf: &Arc<Brdf>| within(brdf.mean_diffuse()) != material.diffuse;
    material.brdf.as_ref().is_some_and(of_model)
}

/// About the slope of the facets of a glossy surface, as a Beckmann distribution with a lobe as
/// wide has it; half of all slopes if the model does not say.
pub(crate) fn slope(model: &Model) -> f64 {
    let of = |name: &str| number(model, name).filter(|x| *x > 0.0);
    // Around the mirrored direction angles are twice those to the half vector.
    let mirrored = |n: f64| (2.0 / (4.0 * n + 2.0)).sqrt();
    let half = |n: f64| (2.0 / (n + 2.0)).sqrt();
    let exponent = match &*model.name {
        "phong" | "lewis" => of("n").map(mirrored),
        "strauss" => Some(mirrored(3.0 / (1.0 - of("smoothness").unwrap_or(0.0)))),
        "ashikhmin_shirley" => of("nu").map(|nu| half((nu * of("nv").unwrap_or(nu)).sqrt())),
        _ => of("n").map(half),
    };
    let sides = of("ax").map(|ax| (ax * of("ay").unwrap_or(ax)).sqrt());
    let waves = of("sigma").and_then(|sigma| Some(2.0 * sigma / of("tau")?));
    let roughness = of("roughness").map(|r| r * r);
    let found = exponent.or(sides).or(of("m")).or(waves).or(roughness);
    found.unwrap_or(0.5).clamp(0.0, 1.0)
}
