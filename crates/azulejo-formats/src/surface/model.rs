//! Access to the reflection model of a material, for writers.

use azulejo_scene::brdf::{Description, Model, Value};
use azulejo_scene::{Material, Rgb};

/// The model of a material that has exactly one.
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

/// Approximate facet slope of a glossy surface: that of the Beckmann distribution whose lobe is
/// equally wide. 0.5 if the model does not define one.
pub(crate) fn slope(model: &Model) -> f64 {
    let of = |name: &str| number(model, name).filter(|x| *x > 0.0);
    // Around the mirror direction, angles are twice those to the half vector.
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
    let slope = exponent.or(sides).or(of("m")).or(waves).or(roughness);
    slope.unwrap_or(0.5).clamp(0.0, 1.0)
}
