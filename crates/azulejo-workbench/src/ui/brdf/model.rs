//! A description: its models and their parameters.

use super::catalog::{GROUPS, converted, example};
use super::color;
use super::fields::{NumberRange, SHARE, number};
use super::parameter::parameters;
use super::theme::{notice, row};
use crate::words::Language;
use azulejo::scene::Rgb;
use azulejo::scene::brdf::{Content, Description, MODELS, Measured, Model, find};
use egui::{ComboBox, RichText, Ui};

/// Draws and edits a description. `last` is the last colour, for models that have none.
pub(super) fn description(
    ui: &mut Ui,
    language: Language,
    description: &mut Description,
    last: &mut Option<Rgb>,
) {
    match description {
        Description::Model(model) => single(ui, language, model, last),
        Description::Combination(parts) => {
            if let Some(last) = combination(ui, language, parts, last) {
                *description = Description::Model(last);
            }
        }
        Description::File { path, content } => {
            let inside = file(ui, language, path, content.as_deref());
            if let Some(inside) = inside {
                *description = inside;
            }
            return;
        }
    }
    if ui
        .button(language.tr("Add a model"))
        .on_hover_text(language.tr("A weighted sum of models: the weights add up to at most 1."))
        .clicked()
    {
        *description = added(description);
    }
}

/// Adds a model with the remaining weight, or half of the total.
fn added(description: &Description) -> Description {
    let mut parts = match description {
        Description::Model(model) => vec![(1.0, model.clone())],
        Description::Combination(parts) => parts.clone(),
        Description::File { .. } => return description.clone(),
    };
    let mut rest = 1.0 - parts.iter().map(|p| p.0).sum::<f64>();
    if rest < 1e-3 {
        parts.iter_mut().for_each(|p| p.0 *= 0.5);
        rest = 0.5;
    }
    let matt = example(MODELS[0], 0).unwrap_or_default();
    parts.push(((1e6 * rest).round() / 1e6, matt));
    Description::Combination(parts)
}

/// The models of a sum; returns the last one if no other is left.
fn combination(
    ui: &mut Ui,
    language: Language,
    parts: &mut Vec<(f64, Model)>,
    last: &mut Option<Rgb>,
) -> Option<Model> {
    let (mut removed, count) = (None, parts.len());
    for (k, (weight, model)) in parts.iter_mut().enumerate() {
        ui.push_id(k, |ui| {
            egui::Frame::group(ui.style()).show(ui, |ui| {
                ui.set_min_width(ui.available_width());
                let about = language.tr("Weight of this model in the sum.");
                let span = NumberRange {
                    is_strict: false,
                    ..SHARE
                };
                row(ui, language.tr("Weight"), about, |ui, name| {
                    let name = format!("{name} {}", k + 1);
                    ui.spacing_mut().slider_width -= 34.0;
                    number(ui, &name, span, weight);
                    let label = format!("{} {}", language.tr("Remove model"), k + 1);
                    let button = ui.add_enabled(count > 1, egui::Button::new("×"));
                    if button
                        .on_hover_text(&label)
                        .accessible_name(label)
                        .clicked()
                    {
                        removed = Some(k);
                    }
                });
                single(ui, language, model, last);
            });
        });
    }
    parts.remove(removed?);
    match &parts[..] {
        [(_, last)] => Some(last.clone()),
        _ => None,
    }
}

/// One model: its type, examples and parameters.
fn single(ui: &mut Ui, language: Language, model: &mut Model, last: &mut Option<Rgb>) {
    let known = find(&model.name).ok();
    let title = known
        .map_or(&*model.name, |info| language.tr(info.title))
        .to_owned();
    let about = known.map_or("", |info| info.paper);
    row(ui, language.tr("Model"), about, |ui, name| {
        let combo = ComboBox::from_id_salt("model")
            .selected_text(title)
            .width(200f32.min(ui.available_width()))
            .height(420.0)
            .truncate();
        let shown = combo.show_ui(ui, |ui| choices(ui, language, model, last));
        shown.response.accessible_name(name);
        examples(ui, language, model);
    });
    parameters(ui, language, model);
}

/// All models in groups.
fn choices(ui: &mut Ui, language: Language, model: &mut Model, last: &mut Option<Rgb>) {
    crate::ui::focus::close_list(ui);
    ui.set_min_width(280.0);
    let old = model.clone();
    for group in &GROUPS {
        ui.label(RichText::new((group.title)(language)).strong());
        for info in group.models() {
            let entry = ui.selectable_label(
                info.is_called(&old.name),
                format!("   {}", language.tr(info.title)),
            );
            let entry = entry.accessible_name(info.title);
            let about = format!("{}\n{}", info.name, info.paper);
            if entry.on_hover_text(about.trim_end()).clicked() && !info.is_called(&old.name) {
                *last = color::model_color(&old).or(*last);
                *model = converted(&old, info, *last);
            }
        }
    }
}

/// Example descriptions of the same model.
fn examples(ui: &mut Ui, language: Language, model: &mut Model) {
    let Ok(info) = find(&model.name) else {
        return;
    };
    ui.menu_button(language.tr("Examples"), |ui| {
        for (k, words) in info.examples.iter().enumerate() {
            if ui.button(*words).clicked() {
                if let Some(example) = example(info, k) {
                    *model = example;
                }
                ui.close();
            }
        }
    });
}

/// A model from a file; returns its description if the user wants to edit it.
fn file(
    ui: &mut Ui,
    language: Language,
    path: &str,
    content: Option<&Content>,
) -> Option<Description> {
    row(ui, language.tr("File"), path, |ui, _| {
        ui.add(egui::Label::new(RichText::new(path).monospace()).truncate())
    });
    match content {
        None => {
            notice(
                ui,
                language.tr("The file could not be found: the surface reflects nothing."),
            );
            None
        }
        Some(Content::Text(description)) => {
            ui.label(RichText::new(description.to_string()).small());
            let words = language.tr("Edit a copy");
            ui.button(words).clicked().then(|| description.clone())
        }
        Some(Content::Measured(measured)) => {
            row(ui, language.tr("Measured"), "", |ui, _| {
                ui.label(measured_words(language, measured))
            });
            None
        }
        // Any other content of a file has no parameters.
        Some(_) => None,
    }
}

fn measured_words(language: Language, measured: &Measured) -> String {
    match measured {
        Measured::Merl(merl) => {
            let [a, b, c] = merl.sizes();
            format!("MERL, {a} × {b} × {c} {}", language.tr("angles"))
        }
        Measured::Rgl(rgl) if rgl.is_isotropic() => {
            format!("RGL, {}", language.tr("isotropic"))
        }
        Measured::Rgl(_) => format!("RGL, {}", language.tr("anisotropic")),
        other => format!("{other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_added_leaves_the_sum_at_one() {
        let check = |text: &str, expected: &[f64]| {
            let Description::Combination(parts) = added(&text.parse().unwrap()) else {
                panic!("{text}");
            };
            let weights: Vec<f64> = parts.iter().map(|p| p.0).collect();
            assert_eq!(weights, expected);
        };
        check("diffuse kd = 0.5", &[0.5, 0.5]);
        check(
            "combination weight = 0.2 specular weight = 0.5 diffuse",
            &[0.2, 0.5, 0.3],
        );
    }
}
