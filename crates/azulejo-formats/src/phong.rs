//! Glossy surfaces, as MTL, 3DS and VRML describe them, kept as the reflection model `phong` of GRF.

use azulejo_scene::{Brdf, Material, Rgb};

/// The model with exponent `n`, glossy reflectance `ks` and diffuse reflectance `kd`.
pub(crate) fn brdf(n: f64, ks: Rgb, kd: Rgb) -> Brdf {
    let parameter = |name: &str, values: &[f64]| (name.to_owned(), values.to_vec());
    Brdf::Model {
        name: "phong".into(),
        parameters: vec![
            parameter("n", &[n]),
            parameter("ks", &ks.to_array()),
            parameter("kd", &kd.to_array()),
        ],
    }
}

/// Exponent and glossy reflectance, if the material carries this model.
pub(crate) fn parse(material: &Material) -> Option<(f64, Rgb)> {
    let Some(Brdf::Model { name, parameters }) = &material.brdf else {
        return None;
    };
    let value = |key: &str| {
        parameters
            .iter()
            .find(|p| p.0 == key)
            .map(|p| p.1.as_slice())
    };
    let ks = match *value("ks")? {
        [grey] => Rgb::grey(grey),
        [r, g, b] => Rgb::new(r, g, b),
        _ => return None,
    };
    (name == "phong").then_some((*value("n")?.first()?, ks))
}
