//! Glossy surfaces as MTL, 3DS, VRML and OpenFlight describe them.
//!
//! Their shading adds a highlight Ks cosⁿ to Kd cos θ, each times the light that arrives: a
//! reflection model f_r = Kd/π + Ks/π cosⁿ whose highlight is not normalised. It becomes the model
//! `lewis`, reciprocal and bounded, with the same highlight.

use azulejo_scene::brdf::{Description, Model, Value};
use azulejo_scene::{Brdf, Material, Rgb};
use std::sync::Arc;

/// The name of the model.
const MODEL: &str = "lewis";

/// The reflectance of the normalised lobe whose highlight is `ks`/π high.
fn reflectance(n: f64) -> f64 {
    2.0 / (n + 2.0)
}

/// The model with exponent `n`, a highlight of `ks` and diffuse reflectance `kd`.
pub(crate) fn brdf(n: f64, ks: Rgb, kd: Rgb) -> Option<Arc<Brdf>> {
    let ks = ks * reflectance(n);
    let ks = Rgb::from([0, 1, 2].map(|k| ks[k].min(1.0 - kd[k])));
    let parameters = [("n", n.into()), ("ks", ks.into()), ("kd", kd.into())];
    let made = Brdf::new(Description::model(MODEL, parameters));
    made.ok().map(Arc::new)
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

/// Exponent and height of the highlight, if the material carries this model.
pub(crate) fn parse(material: &Material) -> Option<(f64, Rgb)> {
    let Description::Model(model) = material.brdf.as_deref()?.description() else {
        return None;
    };
    let n = number(model, "n")?;
    (model.name == MODEL).then_some((n, color(model, "ks")? / reflectance(n)))
}
