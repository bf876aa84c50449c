//! The colour and the roughness of a reflection model, taken from one and given to another.

use super::catalog::{FresnelChoice, as_color, fresnel, set};
use super::roughness;
use azulejo::scene::brdf::{Description, FRESNEL, Model, ModelInfo, ParameterInfo, Value, find};
use azulejo::scene::{Brdf, Material, Rgb};
use glam::DVec3;

/// Below this a surface is black: it has no colour that could be kept.
const BLACK: f64 = 1e-6;

/// Reflectance of a highlight without colour on a coloured surface, where a model has no Fresnel
/// term: that of varnish.
const VARNISH: f64 = 0.04;

/// Largest smoothness that Strauss' model takes over for a surface other than a metal: its white
/// highlight grows with it until no colour is left.
const SMOOTHEST: f64 = 0.6;

/// Names of the colour of a model's base, at most one of which each model has.
const BASES: [&str; 4] = ["kd", "rho", "base", "color"];

/// Names of the share of a metal.
const METALNESS: [&str; 2] = ["metallic", "metalness"];

/// The colour of a material: of its base or, without one, of what it mirrors. `None` if it is black
/// or reflects all colours as glass and varnish do.
pub(super) fn material_color(material: &Material) -> Option<Rgb> {
    match (&material.dielectric, &material.brdf) {
        (Some(_), _) => None,
        (None, Some(brdf)) => match brdf.description() {
            Description::Model(model) => model_color(model),
            _ => visible(brdf.albedo(DVec3::Z)),
        },
        _ => visible(material.diffuse).or_else(|| visible(material.mirror)),
    }
}

/// The colour of a model, as [`material_color`].
pub(super) fn model_color(model: &Model) -> Option<Rgb> {
    let info = find(&model.name).ok()?;
    let base = base(info).and_then(|base| visible(color(model, base)));
    base.or_else(|| highlight(model, info))
}

/// A copy of the model in another colour; unchanged if that would not be a valid model.
pub(super) fn recolored(model: &Model, color: Rgb) -> Model {
    let mut new = model.clone();
    if let Ok(info) = find(&model.name) {
        paint(&mut new, info, color, model);
    }
    valid(new).unwrap_or_else(|| model.clone())
}

/// The model itself, if it is valid.
pub(super) fn valid(model: Model) -> Option<Model> {
    let is_valid = Brdf::new(Description::Model(model.clone())).is_ok();
    is_valid.then_some(model)
}

/// Gives `model` a colour, on the base or in the highlight as `old` has it, and the roughness of
/// `old` where only the parameters differ.
pub(super) fn dress(model: &mut Model, info: &ModelInfo, look: Option<Rgb>, old: &Model) {
    roughness::copy(old, model);
    if info.name == "minnaert" && old.name != model.name {
        // Any other exponent brightens the rim, by which bright colours would reflect too much.
        let exponent = parameter(info, &["k"]);
        exponent
            .into_iter()
            .for_each(|k| set(model, k, Some(Value::Number(1.0))));
    }
    if let Some(color) = look {
        paint(model, info, color, old);
    }
}

fn paint(model: &mut Model, info: &ModelInfo, color: Rgb, old: &Model) {
    let color = color.map(|x| (1e6 * x.clamp(0.0, 1.0)).round() / 1e6);
    let is_metal = is_metal(old);
    if let Some(metalness) = parameter(info, &METALNESS) {
        let share = metalness_of(old).unwrap_or(f64::from(u8::from(is_metal)));
        set(model, metalness, Some(Value::Number(share)));
    }
    let has_highlight = info.has_fresnel || parameter(info, &["ks"]).is_some();
    match base(info) {
        Some(base) if !(is_metal && has_highlight) => {
            set(model, base, Some(Value::from(color)));
            varnish(model, info, color, old);
        }
        base => {
            if let Some(base) = base {
                set(model, base, None);
            }
            color_highlight(model, info, color, old);
        }
    }
}

/// Gives the highlight of a coloured base what the base leaves: that of `old`, or of varnish.
fn varnish(model: &mut Model, info: &ModelInfo, base: Rgb, old: &Model) {
    let room = (1e6 * (1.0 - base.max_channel())).round() / 1e6;
    let had = find(&old.name).ok().and_then(|i| parameter(i, &["ks"]));
    let kept = had.map(|ks| color(old, ks));
    if info.has_fresnel && FresnelChoice::of(old) == FresnelChoice::None {
        FresnelChoice::Index.choose(model);
    }
    if let Some(smoothness) = parameter(info, &["smoothness"]).filter(|_| old.name != model.name) {
        let share = color(model, smoothness).r.min(SMOOTHEST);
        set(model, smoothness, Some(Value::Number(share)));
    }
    if let Some(layer) = parameter(info, &["kv"]) {
        // Beard and Maxwell's layer below the surface takes its share of what the base leaves.
        let share = old.value(layer.name).map(as_color);
        let share = share.map(|kv| Value::from(kv.map(|x| x.min(room))));
        set(model, layer, share);
    }
    let Some(ks) = parameter(info, &["ks"]) else {
        return;
    };
    let most = if info.has_fresnel { 1.0 } else { VARNISH };
    let share = kept.unwrap_or(Rgb::grey(most));
    set(model, ks, Some(Value::from(share.map(|x| x.min(room)))));
}

/// Gives a model its colour by its highlight.
fn color_highlight(model: &mut Model, info: &ModelInfo, color: Rgb, old: &Model) {
    let ks = parameter(info, &["ks"]);
    if !info.has_fresnel {
        if let Some(ks) = ks {
            set(model, ks, Some(Value::from(color)));
        }
        return;
    }
    let had = find(&old.name).ok().and_then(|info| highlight(old, info));
    let is_kept =
        FresnelChoice::of(old) != FresnelChoice::None && had.is_some_and(|c| is_near(c, color));
    // The reflectance of the example would darken the Fresnel term.
    if let Some(ks) = ks.filter(|ks| !is_kept || old.value(ks.name).is_none()) {
        set(model, ks, None);
    }
    if is_kept || is_varnish_only(info) {
        return;
    }
    FRESNEL.iter().for_each(|info| set(model, info, None));
    if let Some(f0) = fresnel("f0") {
        set(model, f0, Some(Value::from(color)));
    }
}

/// Whether a model only mirrors as varnish does, in no colour.
fn is_varnish_only(info: &ModelInfo) -> bool {
    info.name == "fresnel_dielectric"
}

/// The colour of what a model without a base reflects along the normal.
fn highlight(model: &Model, info: &ModelInfo) -> Option<Rgb> {
    let scale = parameter(info, &["ks"]).map_or(Rgb::WHITE, |ks| color(model, ks));
    if !info.has_fresnel {
        return visible(scale);
    }
    let terms = model.parameters.iter();
    let terms = terms.filter(|p| FRESNEL.iter().any(|f| f.is_called(&p.name)));
    let smooth = Model {
        name: "fresnel_conductor".to_owned(),
        parameters: terms.cloned().collect(),
    };
    let is_metal = |f: &Rgb| f.max_channel() > 2.0 * VARNISH;
    let smooth = Brdf::new(Description::Model(smooth)).ok()?;
    visible(smooth.mirror(1.0))
        .filter(is_metal)
        .map(|f| f * scale)
}

/// Whether a model has its colour in its highlight, as metals have.
fn is_metal(model: &Model) -> bool {
    let Ok(info) = find(&model.name) else {
        return false;
    };
    let has_base = base(info).is_some_and(|b| visible(color(model, b)).is_some());
    metalness_of(model).is_some_and(|m| m >= 0.5) || !has_base && highlight(model, info).is_some()
}

fn metalness_of(model: &Model) -> Option<f64> {
    let info = parameter(find(&model.name).ok()?, &METALNESS)?;
    Some(color(model, info).r)
}

fn base(info: &ModelInfo) -> Option<&'static ParameterInfo> {
    parameter(info, &BASES)
}

fn parameter(info: &ModelInfo, names: &[&str]) -> Option<&'static ParameterInfo> {
    info.parameters.iter().find(|p| names.contains(&p.name))
}

/// The value of a parameter as given or by default.
fn color(model: &Model, info: &ParameterInfo) -> Rgb {
    let default = || Rgb::grey(info.default.unwrap_or(0.0));
    model.value(info.name).map_or_else(default, as_color)
}

fn visible(color: Rgb) -> Option<Rgb> {
    (color.max_channel() > BLACK).then_some(color)
}

pub(super) fn is_near(a: Rgb, b: Rgb) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-3)
}

#[cfg(test)]
mod tests {
    use super::super::catalog::converted;
    use super::*;
    use azulejo::scene::brdf::MODELS;

    const RED: Rgb = Rgb::new(0.8, 0.1, 0.05);

    fn matt() -> Model {
        Model::new("diffuse", [("kd", Value::from(RED))])
    }

    fn check_red(model: &Model) {
        if model.name == "fresnel_dielectric" {
            return;
        }
        let brdf = Brdf::new(Description::Model(model.clone())).unwrap();
        let seen = brdf.albedo(DVec3::Z);
        assert!(seen.r > 2.0 * seen.g && seen.r > 0.05, "{model}: {seen:?}");
        let color = model_color(model).unwrap();
        assert!(is_near(color, RED), "{model}: {color:?}");
    }

    #[test]
    fn red_stays_red_in_every_model_and_back() {
        for info in MODELS {
            let model = converted(&matt(), info, Some(RED));
            check_red(&model);
            let back = converted(&model, find("diffuse").unwrap(), Some(RED));
            assert_eq!(back, matt(), "by {model}");
        }
    }

    #[test]
    fn red_stays_red_from_every_model_to_every_other() {
        for first in MODELS {
            let first = converted(&matt(), first, Some(RED));
            for second in MODELS {
                check_red(&converted(&first, second, Some(RED)));
            }
        }
    }

    #[test]
    fn metals_stay_metals() {
        let gold = "ggx_smith ax = 0.2 metal = gold".parse().unwrap();
        let Description::Model(gold) = gold else {
            panic!("{gold}")
        };
        let check = |name: &str, expected: &str| {
            let model = converted(&gold, find(name).unwrap(), None);
            assert_eq!(model.to_string(), expected);
            let [a, b] = [&gold, &model].map(|m| model_color(m).unwrap());
            assert!((a - b).max_channel().abs() < 0.02, "{model}: {a:?} {b:?}");
        };
        check("fresnel_conductor", "fresnel_conductor metal = gold");
        check(
            "ward_gmd",
            "ward_gmd ks = (0.922682, 0.791609, 0.403452) ax = 0.2",
        );
        check(
            "gltf_mr",
            "gltf_mr base = (0.922682, 0.791609, 0.403452) roughness = 0.447214 metallic = 1",
        );
    }

    #[test]
    fn another_colour_leaves_the_rest() {
        let check = |text: &str, expected: &str| {
            let Description::Model(model) = text.parse().unwrap() else {
                panic!("{text}")
            };
            assert_eq!(recolored(&model, RED).to_string(), expected);
        };
        check(
            "ggx_smith kd = 0.4 ks = 0.6 ax = 0.3 eta = 1.4",
            "ggx_smith kd = (0.8, 0.1, 0.05) ks = 0.2 ax = 0.3 eta = 1.4",
        );
        check(
            "eon rho = 0.5 r = 0.3",
            "eon rho = (0.8, 0.1, 0.05) r = 0.3",
        );
        check(
            "cook_torrance m = 0.3 metal = copper",
            "cook_torrance m = 0.3 f0 = (0.8, 0.1, 0.05)",
        );
    }
}
