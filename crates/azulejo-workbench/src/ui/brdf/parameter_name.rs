//! Readable names of the parameters of reflection models.

use crate::words::Language;
use azulejo::scene::brdf::ModelInfo;

/// The label of a parameter: what it means, and its symbol in papers and files in parentheses.
pub(super) fn label(language: Language, model: &ModelInfo, symbol: &str) -> String {
    match meaning(language, model.name, symbol) {
        Some(words) if words.eq_ignore_ascii_case(symbol) => words.to_owned(),
        Some(words) => format!("{words} ({symbol})"),
        None => symbol.to_owned(),
    }
}

/// What a parameter means. The same symbol may mean something else in another model.
fn meaning(language: Language, model: &str, symbol: &str) -> Option<&'static str> {
    let words = match (model, symbol) {
        ("minnaert", "k") => language.tr("Limb darkening"),
        ("minnaert", "kd") => language.tr("Reflectance"),
        ("schlick", "ks") => language.tr("Reflectance at normal incidence"),
        ("ggx_ms", "ax") => language.tr("Roughness"),
        ("beard_maxwell", "tau") => language.tr("Shadowing decay angle"),
        (_, "base") => language.tr("Base colour"),
        (_, "bias") => language.tr("First-surface factor"),
        (_, "color") => language.tr("Colour"),
        (_, "kd") => language.tr("Diffuse reflectance"),
        (_, "ks") => language.tr("Specular reflectance"),
        (_, "kv") => language.tr("Reflectance of the layer below"),
        (_, "rho") => language.tr("Reflectance"),
        (_, "F") => language.tr("Constant reflectance"),
        (_, "f0") => language.tr("Reflectance at normal incidence"),
        (_, "tint") => language.tr("Edge tint"),
        (_, "eta") => language.tr("Refractive index"),
        (_, "k") => language.tr("Extinction coefficient"),
        (_, "metal") => language.tr("Metal"),
        (_, "n") => language.tr("Exponent"),
        (_, "nu") => language.tr("Exponent along x"),
        (_, "nv") => language.tr("Exponent along y"),
        (_, "ax") => language.tr("Roughness along x"),
        (_, "ay") => language.tr("Roughness along y"),
        (_, "m" | "r" | "rough" | "roughness" | "sigma") => language.tr("Roughness"),
        (_, "c" | "smoothness") => language.tr("Smoothness"),
        (_, "p") => language.tr("Isotropy"),
        (_, "metallic") => language.tr("Metallic"),
        (_, "metalness") => language.tr("Metalness"),
        (_, "transparency") => language.tr("Transparency"),
        (_, "omega") => language.tr("Shadowing onset angle"),
        (_, "sigma0") => language.tr("RMS height"),
        (_, "tau") => language.tr("Correlation length"),
        (_, "lambda") => language.tr("Wavelengths"),
        (_, "cx") => language.tr("Lobe coefficient along x"),
        (_, "cy") => language.tr("Lobe coefficient along y"),
        (_, "cz") => language.tr("Lobe coefficient along z"),
        (_, "d") => language.tr("Distance between cylinders"),
        (_, "h") => language.tr("Depth of the axes"),
        _ => return None,
    };
    Some(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::brdf::{MODELS, find};
    use std::collections::HashSet;

    #[test]
    fn every_parameter_has_a_name_of_its_own() {
        for model in MODELS {
            for language in Language::ALL {
                let mut seen = HashSet::new();
                for parameter in model.all_parameters() {
                    let words = meaning(language, model.name, parameter.name);
                    let words = words.unwrap_or_else(|| panic!("{}", parameter.name));
                    assert!(
                        seen.insert(label(language, model, parameter.name)),
                        "{words} of {} in {language:?}",
                        model.name
                    );
                }
            }
        }
    }

    #[test]
    fn a_symbol_stays_in_parentheses() {
        let label = |model, symbol| label(Language::English, find(model).unwrap(), symbol);
        assert_eq!(label("ward", "ax"), "Roughness along x (ax)");
        assert_eq!(label("minnaert", "k"), "Limb darkening (k)");
        assert_eq!(label("ggx_smith", "k"), "Extinction coefficient (k)");
        assert_eq!(label("gltf_mr", "roughness"), "Roughness");
    }
}
