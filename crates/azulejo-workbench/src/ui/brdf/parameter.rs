//! The parameters of a model.

use super::catalog::{self, FresnelChoice, as_color, default_value, set};
use super::fields::{NumberRange, color, number};
use super::parameter_name::label;
use super::theme::{named, row};
use crate::ui::{focus, inputs};
use crate::variants::all;
use crate::words::Language;
use azulejo::scene::brdf::{
    METALS, Model, ModelInfo, ParameterInfo, ParameterKind, Value, find, find_metal,
};
use egui::{ComboBox, Ui};

/// Draws all parameters of a known model.
pub(super) fn parameters(ui: &mut Ui, language: Language, model: &mut Model) {
    let Ok(info) = find(&model.name) else {
        return;
    };
    for parameter in info.parameters {
        ui.push_id(parameter.name, |ui| {
            one(ui, language, info, model, parameter)
        });
    }
    if info.has_fresnel {
        fresnel(ui, language, info, model);
    }
}

/// Description and range of a parameter.
fn about(language: Language, info: &ParameterInfo) -> String {
    let words = language.tr(info.about);
    let (from, to, unit) = (info.least, info.most, language.tr(info.unit));
    match info.kind {
        ParameterKind::Word => words.to_owned(),
        _ => format!("{words}\n{from} … {to} {unit}"),
    }
}

fn one(
    ui: &mut Ui,
    language: Language,
    of: &ModelInfo,
    model: &mut Model,
    info: &'static ParameterInfo,
) {
    let given = model.value(info.name).cloned();
    let name = label(language, of, info.name);
    named(ui, &name, &about(language, info), |ui, name| {
        let is_optional = !info.is_needed && info.default.is_none();
        let mut is_given = given.is_some();
        if is_optional {
            let words = language.tr("Set; otherwise the model uses its default.");
            let check = ui.checkbox(&mut is_given, "").on_hover_text(words);
            check.accessible_name(format!("{name} ?"));
            if !is_given {
                ui.weak(language.tr("Default"));
                return set(model, info, None);
            }
        }
        let old = given.clone().unwrap_or_else(|| default_value(model, info));
        let mut new = old.clone();
        value(ui, language, name, info, &mut new);
        // Defaults that were not changed are not written.
        if new != old || (is_optional && given.is_none()) {
            set(model, info, Some(new));
        }
    });
}

/// The input fields of a value.
fn value(ui: &mut Ui, language: Language, name: &str, info: &ParameterInfo, value: &mut Value) {
    let span = NumberRange {
        least: info.least,
        most: info.most,
        unit: language.tr(info.unit),
        is_strict: false,
    };
    match (info.kind, &mut *value) {
        (ParameterKind::Word, Value::Word(word)) => metal(ui, name, word),
        (ParameterKind::Number, Value::Number(x)) => number(ui, name, span, x),
        (ParameterKind::Color, _) => shade(ui, language, name, span, value),
        // The value has the wrong type for the model: replace it with a valid one.
        (ParameterKind::Word, _) => *value = Value::Word("gold".to_owned()),
        (ParameterKind::Number, _) => *value = Value::Number(as_color(value).r),
    }
}

/// One number for all channels, or three.
fn shade(ui: &mut Ui, language: Language, name: &str, span: NumberRange, value: &mut Value) {
    let mut is_color = matches!(value, Value::Color(_));
    let words = language.tr("One number for each of red, green and blue.");
    let toggle = ui.toggle_value(&mut is_color, "RGB").on_hover_text(words);
    let toggle = toggle.accessible_name(format!("{name} RGB"));
    let shown = as_color(value);
    if toggle.changed() {
        *value = if is_color {
            Value::Color(shown)
        } else {
            Value::Number(shown.mean())
        };
        return;
    }
    match value {
        Value::Number(x) => {
            ui.spacing_mut().slider_width -= 40.0;
            number(ui, name, span, x);
        }
        Value::Color(rgb) => color(ui, name, span, rgb),
        Value::Word(_) => *value = Value::Number(span.least),
    }
}

/// A metal by name.
fn metal(ui: &mut Ui, name: &str, word: &mut String) {
    let known = find_metal(word).map_or(&**word, |m| m.name).to_owned();
    let combo = ComboBox::from_id_salt("metal")
        .selected_text(&known)
        .width(140.0);
    let shown = combo.show_ui(ui, |ui| {
        focus::close_list(ui);
        for metal in METALS {
            let entry = ui.selectable_label(metal.name == known, metal.name);
            if entry.on_hover_text(metal.source).clicked() {
                metal.name.clone_into(word);
            }
        }
    });
    shown.response.accessible_name(name);
}

/// The Fresnel term.
fn fresnel(ui: &mut Ui, language: Language, of: &ModelInfo, model: &mut Model) {
    let term = FresnelChoice::of(model);
    let about = language.tr("Reflectance of a smooth facet as a function of the angle.");
    let mut chosen = term;
    row(ui, language.tr("Fresnel"), about, |ui, name| {
        let words = |t| term_words(language, t);
        let combo = ComboBox::from_id_salt(("fresnel", of.name))
            .width((ui.available_width() - 8.0).min(210.0));
        inputs::choice(combo, ui, &mut chosen, all(), |&t| words(t)).accessible_name(name);
    });
    if chosen != term {
        return chosen.choose(model);
    }
    let names: &[&str] = match term {
        FresnelChoice::None => &[],
        FresnelChoice::Metal => &["metal"],
        FresnelChoice::Index => &["eta", "k"],
        FresnelChoice::Schlick => &["f0", "tint"],
        FresnelChoice::Constant => &["F"],
    };
    for info in names.iter().filter_map(|name| catalog::fresnel(name)) {
        // The parameter that identifies the term is required, the others are optional.
        let is_first = names.first() == Some(&info.name);
        ui.push_id(info.name, |ui| {
            if is_first {
                needed(ui, language, of, model, info)
            } else {
                one(ui, language, of, model, info)
            }
        });
    }
    if term == FresnelChoice::Index {
        copied(ui, language, model);
    }
}

fn needed(
    ui: &mut Ui,
    language: Language,
    of: &ModelInfo,
    model: &mut Model,
    info: &'static ParameterInfo,
) {
    let old = model
        .value(info.name)
        .cloned()
        .unwrap_or_else(|| default_value(model, info));
    let mut new = old.clone();
    let name = label(language, of, info.name);
    named(ui, &name, &about(language, info), |ui, name| {
        value(ui, language, name, info, &mut new)
    });
    if new != old {
        set(model, info, Some(new));
    }
}

/// Copies the values of a metal from the table as a starting point.
fn copied(ui: &mut Ui, language: Language, model: &mut Model) {
    row(ui, "", "", |ui, _| {
        ui.menu_button(language.tr("Copy from a metal"), |ui| {
            for metal in METALS {
                let entry = ui.button(metal.name).on_hover_text(metal.source);
                if entry.clicked() {
                    for (name, color) in [("eta", metal.eta), ("k", metal.k)] {
                        if let Some(info) = catalog::fresnel(name) {
                            set(model, info, Some(Value::Color(color)));
                        }
                    }
                    ui.close();
                }
            }
        });
    });
}

fn term_words(language: Language, term: FresnelChoice) -> &'static str {
    match term {
        FresnelChoice::None => language.tr("None (all light is reflected)"),
        FresnelChoice::Metal => language.tr("Metal"),
        FresnelChoice::Index => language.tr("Refractive indices"),
        FresnelChoice::Schlick => language.tr("Schlick"),
        FresnelChoice::Constant => language.tr("Constant"),
    }
}
