//! The reflection models in groups, and conversion of parameters between models.

use super::color;
use crate::words::Language;
use azulejo::scene::Rgb;
use azulejo::scene::brdf::{
    Description, FRESNEL, MODELS, Model, ModelInfo, Parameter, ParameterInfo, Value, WAVELENGTHS,
    find,
};
use clap::ValueEnum;

/// A group of similar models.
pub(super) struct ModelGroup {
    pub title: fn(Language) -> &'static str,
    names: &'static [&'static str],
}

/// All groups; the last one contains the models in no other group.
pub(super) const GROUPS: [ModelGroup; 6] = [
    ModelGroup {
        title: |l| l.tr("Matt"),
        names: &["diffuse", "oren_nayar", "eon", "burley_diffuse", "minnaert"],
    },
    ModelGroup {
        title: |l| l.tr("Smooth"),
        names: &["specular", "fresnel_conductor", "fresnel_dielectric"],
    },
    ModelGroup {
        title: |l| l.tr("Cosine lobes"),
        names: &["phong", "lewis", "blinn", "ashikhmin_shirley", "lafortune"],
    },
    ModelGroup {
        title: |l| l.tr("Microfacets"),
        names: &[
            "ggx_smith",
            "ggx_ms",
            "beckmann_smith",
            "cook_torrance",
            "torrance_sparrow_gauss",
            "ward",
            "ward_duer",
            "ward_gmd",
            "beard_maxwell",
        ],
    },
    ModelGroup {
        title: |l| l.tr("Wave optics and cylinders"),
        names: &["he_torrance", "he_torrance_mirror", "poulin_fournier"],
    },
    ModelGroup {
        title: |l| l.tr("Empirical"),
        names: &[],
    },
];

impl ModelGroup {
    /// Its models; of the last group those that are in no other.
    pub fn models(&self) -> impl Iterator<Item = &'static ModelInfo> {
        let is_last = self.names.is_empty();
        let named = |name: &str| GROUPS.iter().any(|g| g.names.contains(&name));
        let rest = MODELS
            .iter()
            .copied()
            .filter(move |m| is_last && !named(m.name));
        self.names
            .iter()
            .filter_map(|name| find(name).ok())
            .chain(rest)
    }
}

/// An example of a model; the first one always exists.
pub(super) fn example(info: &ModelInfo, k: usize) -> Option<Model> {
    match info.examples.get(k)?.parse() {
        Ok(Description::Model(model)) => Some(model),
        _ => None,
    }
}

/// Another model with the parameters that both have, and with the colour and the roughness of the
/// old one in its own parameters; the others come from its first example. `last` is the colour to
/// return to from a model that has none.
pub(super) fn converted(old: &Model, info: &'static ModelInfo, last: Option<Rgb>) -> Model {
    let example = example(info, 0).unwrap_or_default();
    let mut copied = example.clone();
    copy_same(old, info, &mut copied);
    let look = color::model_color(old).or(last);
    let mut dressed = copied.clone();
    color::dress(&mut dressed, info, look, old);
    // Where all together is not valid, the colour is worth more than the rest.
    let colored = look.map(|c| color::recolored(&example, c));
    let tried = [Some(dressed), Some(copied), colored];
    let color = tried.into_iter().flatten().find_map(color::valid);
    color.unwrap_or(example)
}

/// Copies the parameters that mean the same in both models.
fn copy_same(old: &Model, info: &'static ModelInfo, model: &mut Model) {
    let old_info = find(&old.name).ok();
    if info.has_fresnel && FresnelChoice::of(old) != FresnelChoice::None {
        // A model takes one Fresnel term: that of the old one replaces that of the example.
        FRESNEL.iter().for_each(|term| set(model, term, None));
    }
    for parameter in info.all_parameters() {
        // The same letter may mean something else; the same description does not.
        let is_same = |p: &ParameterInfo| p.name == parameter.name && p.about == parameter.about;
        let had = old_info.is_some_and(|i| i.all_parameters().any(is_same));
        if let (true, Some(value)) = (had, old.value(parameter.name)) {
            set(model, parameter, Some(value.clone()));
        }
    }
}

/// Sets a parameter, or removes it.
pub(super) fn set(model: &mut Model, info: &ParameterInfo, value: Option<Value>) {
    let at = model
        .parameters
        .iter()
        .position(|p| info.is_called(&p.name));
    match (at, value) {
        (Some(at), Some(value)) => model.parameters[at].value = value,
        (Some(at), None) => drop(model.parameters.remove(at)),
        (None, Some(value)) => model.parameters.push(Parameter {
            name: info.name.to_owned(),
            value,
        }),
        (None, None) => {}
    }
}

/// The default value of a parameter.
pub(super) fn default_value(model: &Model, info: &ParameterInfo) -> Value {
    let exemplary = || {
        let models = find(&model.name).ok()?;
        let examples = (0..models.examples.len()).filter_map(|k| example(models, k));
        examples
            .into_iter()
            .find_map(|m| m.value(info.name).cloned())
    };
    match (info.name, info.default) {
        (_, Some(default)) => Value::Number(default),
        ("lambda", _) => Value::Color(WAVELENGTHS),
        ("ay", _) => model.value("ax").cloned().unwrap_or(Value::Number(0.2)),
        _ => exemplary().unwrap_or(Value::Number(info.least.max(info.most.min(0.5)))),
    }
}

/// The kinds of Fresnel terms in a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FresnelChoice {
    /// None: all light is reflected.
    None,
    /// A metal by name.
    Metal,
    /// Indices of refraction.
    Index,
    /// Reflectance at normal incidence, Schlick's approximation.
    Schlick,
    Constant,
}

impl FresnelChoice {
    /// The kind that a model uses; none in models whose parameters only have such names.
    pub fn of(model: &Model) -> FresnelChoice {
        if find(&model.name).is_ok_and(|info| !info.has_fresnel) {
            return FresnelChoice::None;
        }
        let has = |names: &[&str]| names.iter().any(|n| given(model, n).is_some());
        match () {
            () if has(&["metal"]) => FresnelChoice::Metal,
            () if has(&["eta", "k"]) => FresnelChoice::Index,
            () if has(&["f0", "tint"]) => FresnelChoice::Schlick,
            () if has(&["F"]) => FresnelChoice::Constant,
            () => FresnelChoice::None,
        }
    }

    /// Replaces the Fresnel term of a model.
    pub fn choose(self, model: &mut Model) {
        FRESNEL.iter().for_each(|info| set(model, info, None));
        let (name, value) = match self {
            FresnelChoice::None => return,
            FresnelChoice::Metal => ("metal", Value::Word("gold".to_owned())),
            FresnelChoice::Index => ("eta", Value::Number(1.5)),
            FresnelChoice::Schlick => ("f0", Value::Number(0.04)),
            FresnelChoice::Constant => ("F", Value::Number(1.0)),
        };
        if let Some(info) = fresnel(name) {
            set(model, info, Some(value));
        }
    }
}

/// A parameter of Fresnel terms.
pub(super) fn fresnel(name: &str) -> Option<&'static ParameterInfo> {
    FRESNEL.iter().find(|p| p.name == name)
}

/// The value of a Fresnel parameter in a model.
fn given<'a>(model: &'a Model, name: &str) -> Option<&'a Value> {
    let info = fresnel(name)?;
    let parameter = model.parameters.iter().find(|p| info.is_called(&p.name));
    parameter.map(|p| &p.value)
}

/// A value as a colour.
pub(super) fn as_color(value: &Value) -> Rgb {
    match value {
        Value::Number(number) => Rgb::grey(*number),
        Value::Color(color) => *color,
        Value::Word(_) => Rgb::BLACK,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variants::all;
    use azulejo::scene::Brdf;

    #[test]
    fn each_model_is_in_one_group() {
        let mut models: Vec<&str> = GROUPS
            .iter()
            .flat_map(|g| g.models().map(|m| m.name))
            .collect();
        assert_eq!(models.len(), MODELS.len());
        models.sort_unstable();
        models.dedup();
        assert_eq!(models.len(), MODELS.len());
    }

    #[test]
    fn every_model_follows_every_other() {
        for old in MODELS {
            for info in MODELS {
                let model = converted(&example(old, 0).unwrap(), info, None);
                let arguments = Brdf::new(Description::Model(model.clone()));
                assert!(arguments.is_ok(), "{} to {model}: {arguments:?}", old.name);
            }
        }
    }

    #[test]
    fn parameters_are_kept_where_they_mean_the_same() {
        let check = |old: &str, name: &str, expected: &str| {
            let Description::Model(old) = old.parse().unwrap() else {
                panic!("{old}")
            };
            assert_eq!(
                converted(&old, find(name).unwrap(), None).to_string(),
                expected
            );
        };
        check(
            "blinn kd = (0.1, 0.2, 0.3) ks = 0.5 n = 77",
            "lewis",
            "lewis kd = (0.1, 0.2, 0.3) ks = 0.5 n = 77",
        );
        check(
            "ggx_smith ax = 0.3 metal = gold",
            "beckmann_smith",
            "beckmann_smith ax = 0.3 metal = gold",
        );
        // Minnaert's k is not an index of refraction.
        check(
            "minnaert kd = 0.5 k = 7",
            "fresnel_conductor",
            "fresnel_conductor f0 = 0.5",
        );
    }

    #[test]
    fn terms_replace_each_other() {
        let mut model = example(find("ggx_smith").unwrap(), 0).unwrap();
        assert_eq!(FresnelChoice::of(&model), FresnelChoice::Metal);
        for term in all::<FresnelChoice>() {
            term.choose(&mut model);
            assert_eq!(FresnelChoice::of(&model), term);
            assert!(Brdf::new(Description::Model(model.clone())).is_ok());
        }
        let gltf = example(find("gltf_mr").unwrap(), 1).unwrap();
        assert!(!find(&gltf.name).unwrap().has_fresnel);
    }
}
