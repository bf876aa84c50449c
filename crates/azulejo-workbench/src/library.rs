//! The material library: surfaces that people know, made of azulejo's own models.

use crate::words::Language;
use azulejo::scene::brdf::Description;
use azulejo::scene::{Brdf, Dielectric, Material, Rgb};
use std::sync::Arc;

/// A material of the library.
pub struct LibraryMaterial {
    /// Its name in the language of the window.
    pub title: fn(Language) -> &'static str,
    surface: Surface,
}

/// How a material of the library reflects.
enum Surface {
    /// Diffuse reflectance.
    Matt([f64; 3]),
    /// Reflectance of a perfect mirror.
    Mirror([f64; 3]),
    /// A pane: index of refraction and transmittance of the glass itself.
    Pane(f64, [f64; 3]),
    /// A description of a reflection model.
    Model(&'static str),
}

use Surface::{Matt, Mirror, Model, Pane};

/// All materials of the library, in the order of the window. Reflectances are linear, of
/// measurements of such surfaces where they are well known; metals have the indices of refraction
/// of the table. Dielectrics reflect 4 to 6 % along the normal, over a base that gets what is left.
pub static LIBRARY: [LibraryMaterial; 18] = [
    of(
        |l| l.tr("White plaster"),
        Model("eon rho = (0.82, 0.8, 0.76) r = 0.4"),
    ),
    of(|l| l.tr("White wall paint"), Matt([0.85, 0.85, 0.83])),
    of(
        |l| l.tr("Brick"),
        Model("eon rho = (0.4, 0.145, 0.085) r = 0.7"),
    ),
    of(
        |l| l.tr("Concrete"),
        Model("eon rho = (0.32, 0.31, 0.285) r = 0.6"),
    ),
    of(
        |l| l.tr("Oak"),
        Model("ashikhmin_shirley kd = (0.36, 0.2, 0.095) ks = 0.04 nu = 60 nv = 20"),
    ),
    of(
        |l| l.tr("Glazed tile"),
        Model("ashikhmin_shirley kd = (0.02, 0.075, 0.36) ks = 0.05 nu = 4000 nv = 4000"),
    ),
    of(
        |l| l.tr("Porcelain"),
        Model("ashikhmin_shirley kd = (0.8, 0.79, 0.76) ks = 0.05 nu = 8000 nv = 8000"),
    ),
    of(
        |l| l.tr("Frosted plastic"),
        Model("ashikhmin_shirley kd = (0.62, 0.68, 0.7) ks = 0.04 nu = 30 nv = 30"),
    ),
    of(
        |l| l.tr("Black rubber"),
        Model("ashikhmin_shirley kd = 0.025 ks = 0.04 nu = 8 nv = 8"),
    ),
    of(
        |l| l.tr("Velvet"),
        Model("minnaert kd = (0.2, 0.012, 0.035) k = 0.75"),
    ),
    of(
        |l| l.tr("Red car paint"),
        Model(
            "combination weight = 0.6 ashikhmin_shirley kd = (0.45, 0.01, 0.008) ks = 0.06 nu = 8000 nv = 8000 \
             weight = 0.4 ggx_smith ax = 0.2 f0 = (0.6, 0.02, 0.015)",
        ),
    ),
    of(
        |l| l.tr("Brushed steel"),
        Model("ggx_smith ax = 0.1 ay = 0.4 metal = iron"),
    ),
    of(
        |l| l.tr("Polished chrome"),
        Model("fresnel_conductor metal = chromium"),
    ),
    of(|l| l.tr("Gold"), Model("ggx_smith ax = 0.12 metal = gold")),
    of(
        |l| l.tr("Copper"),
        Model("ggx_smith ax = 0.18 metal = copper"),
    ),
    of(
        |l| l.tr("Aluminium"),
        Model("ggx_ms ax = 0.3 metal = aluminium"),
    ),
    of(|l| l.tr("Mirror"), Mirror([0.92, 0.93, 0.92])),
    of(|l| l.tr("Window glass"), Pane(1.52, [0.97, 0.985, 0.975])),
];

const fn of(title: fn(Language) -> &'static str, surface: Surface) -> LibraryMaterial {
    LibraryMaterial { title, surface }
}

impl LibraryMaterial {
    /// The name in scripts: the English one in small letters, with hyphens.
    pub fn script_name(&self) -> String {
        slug((self.title)(Language::English))
    }

    /// The material; `None` only if its description were wrong, which a test excludes.
    pub fn material(&self, name: impl Into<String>) -> Option<Material> {
        Some(match self.surface {
            Matt(reflectance) => Material::diffuse(name, reflectance.into()),
            Mirror(reflectance) => Material::mirror(name, reflectance.into()),
            Pane(ior, transmittance) => {
                let mut pane = Material::pane(name, ior);
                pane.dielectric = Some(Dielectric {
                    ior,
                    transmittance: Rgb::from(transmittance),
                    thin: true,
                });
                pane
            }
            Model(text) => {
                let description: Description = text.parse().ok()?;
                Material::with_brdf(name, Arc::new(Brdf::new(description).ok()?))
            }
        })
    }

    /// A material with this reflection. It emits what it emitted, and keeps a name that says more
    /// than that it is a material.
    pub fn replacing(&self, old: &Material, language: Language) -> Option<Material> {
        let name = if is_default_name(&old.name) {
            (self.title)(language).to_owned()
        } else {
            old.name.clone()
        };
        Some(Material {
            emission: old.emission,
            emission_picture: old.emission_picture,
            emits_back: old.emits_back,
            sidedness: old.sidedness,
            opacity: old.opacity,
            relief: old.relief,
            lightmap: old.lightmap,
            ..self.material(name)?
        })
    }
}

/// Whether a name was given by a program: none, "material", "white", or that of a material of the
/// library, also with a number.
fn is_default_name(name: &str) -> bool {
    let numbered = |c: char| c.is_ascii_digit() || c == ' ' || c == '_' || c == '-' || c == '.';
    let plain = name.trim_end_matches(numbered).trim();
    let given = ["", "material", "white", "grey", "gray", "default"];
    let is_given = given.iter().any(|g| g.eq_ignore_ascii_case(plain));
    is_given
        || LIBRARY
            .iter()
            .any(|m| Language::ALL.iter().any(|&l| (m.title)(l) == plain))
}

/// A name as file names and scripts have it: small letters and digits, with hyphens between words.
pub fn slug(name: &str) -> String {
    let words = name.split(|c: char| !c.is_alphanumeric());
    let words: Vec<String> = words
        .filter(|w| !w.is_empty())
        .map(str::to_lowercase)
        .collect();
    words.join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Scene;
    use std::collections::HashSet;

    #[test]
    fn all_are_valid_and_have_names_of_their_own() {
        for language in Language::ALL {
            let names: HashSet<_> = LIBRARY.iter().map(|m| (m.title)(language)).collect();
            assert_eq!(names.len(), LIBRARY.len(), "{language:?}");
        }
        for entry in &LIBRARY {
            let name = entry.script_name();
            let material = entry.material(name.clone()).expect(&name);
            let alone = Scene {
                materials: vec![material],
                ..Scene::default()
            };
            assert!(alone.validate().is_ok(), "{name}: {:?}", alone.validate());
        }
    }

    #[test]
    fn names_that_say_something_are_kept() {
        let gold = &LIBRARY[13];
        assert_eq!(gold.script_name(), "gold");
        let name = |old: &str| {
            let old = Material::diffuse(old, Rgb::grey(0.5));
            gold.replacing(&old, Language::Spanish).unwrap().name
        };
        for old in ["", "material", "Material.003", "white 2", "Copper", "Cobre"] {
            assert_eq!(name(old), "Oro", "{old}");
        }
        assert_eq!(name("left wall"), "left wall");
    }

    #[test]
    fn lamps_go_on_shining() {
        let mut lamp = Material::emitter("lamp", Rgb::grey(3.0));
        lamp.emits_back = true;
        lamp.textures = vec![1];
        let new = LIBRARY[0].replacing(&lamp, Language::English).unwrap();
        assert_eq!((new.emission, new.emits_back), (Rgb::grey(3.0), true));
        assert!(new.brdf.is_some() && new.textures.is_empty());
    }

    #[test]
    fn names_become_those_of_files() {
        for (name, expected) in [
            ("Brushed steel", "brushed-steel"),
            ("a/b: c_1", "a-b-c-1"),
            ("Azulejo ñ", "azulejo-ñ"),
            ("..", ""),
        ] {
            assert_eq!(slug(name), expected);
        }
    }
}
