//! `brdf list`: the models and their parameters.

use super::args::ListArgs;
use crate::failure::Failure;
use crate::report::{Report, number};
use azulejo_scene::brdf::{MODELS, ModelInfo, ParameterInfo, ParameterKind, find};
use serde_json::{Value, json};

/// Runs `brdf list`.
pub fn run(args: &ListArgs) -> Result<Report, Failure> {
    let mut report = Report::default();
    match &args.model {
        Some(name) => one(find(name).map_err(Failure::misuse)?, &mut report),
        None => all(&mut report),
    }
    Ok(report)
}

fn all(report: &mut Report) {
    for info in MODELS {
        let names: Vec<String> = info.parameters.iter().map(given).collect();
        let fresnel = if info.has_fresnel { " FRESNEL" } else { "" };
        report.line(
            info.name,
            format!("{} {}{fresnel}", info.title, bracketed(&names)),
        );
    }
    report.plain(
        "FRESNEL is one of eta=.. k=.., eta=.., metal=.., f0=.. tint=.., F=..; without it the \
         Fresnel reflectance is 1.",
    );
    report.value(
        "models",
        MODELS.iter().map(|i| described(i)).collect::<Value>(),
    );
}

/// A parameter as on the command line: with its default, or with dots if there is none.
fn given(parameter: &ParameterInfo) -> String {
    match parameter.default {
        Some(default) => format!("{}={default}", parameter.name),
        None if parameter.is_needed => format!("{}=..", parameter.name),
        None => format!("[{}=..]", parameter.name),
    }
}

fn bracketed(names: &[String]) -> String {
    if names.is_empty() {
        return String::new();
    }
    format!("({})", names.join(" "))
}

fn one(info: &'static ModelInfo, report: &mut Report) {
    report.line("name", info.name);
    if !info.aliases.is_empty() {
        report.line("also", info.aliases.join(", "));
    }
    report.line("title", info.title);
    if !info.paper.is_empty() {
        report.line("paper", info.paper);
    }
    report.line("reciprocal", yes(info.is_reciprocal));
    report.line("energy-safe", yes(info.is_energy_safe));
    for parameter in info.all_parameters() {
        report.line(parameter.name, explained(parameter));
    }
    for example in info.examples {
        report.line("example", *example);
    }
    report.value("model", described(info));
}

fn yes(it_is: bool) -> &'static str {
    if it_is { "yes" } else { "no" }
}

/// Description, range, default and aliases of a parameter.
fn explained(parameter: &ParameterInfo) -> String {
    let mut words = parameter.about.to_owned();
    if parameter.kind != ParameterKind::Word {
        words += &format!(", {}..{}", parameter.least, parameter.most);
    }
    if !parameter.unit.is_empty() {
        words += &format!(" {}", parameter.unit);
    }
    if parameter.kind == ParameterKind::Color {
        words += ", one number or three";
    }
    match parameter.default {
        Some(default) => words += &format!(" [default: {default}]"),
        None if parameter.is_needed => words += " [required]",
        None => {}
    }
    if !parameter.aliases.is_empty() {
        words += &format!(" [also: {}]", parameter.aliases.join(", "));
    }
    words
}

fn described(info: &'static ModelInfo) -> Value {
    let parameters: Vec<Value> = info.all_parameters().map(parameter).collect();
    json!({
        "name": info.name,
        "aliases": info.aliases,
        "title": info.title,
        "paper": info.paper,
        "reciprocal": info.is_reciprocal,
        "energy_safe": info.is_energy_safe,
        "examples": info.examples,
        "parameters": parameters,
    })
}

fn parameter(info: &ParameterInfo) -> Value {
    let kind = match info.kind {
        ParameterKind::Number => "number",
        ParameterKind::Color => "color",
        ParameterKind::Word => "word",
    };
    json!({
        "name": info.name,
        "aliases": info.aliases,
        "kind": kind,
        "default": info.default.map(number),
        "needed": info.is_needed,
        "least": number(info.least),
        "most": number(info.most),
        "unit": info.unit,
        "about": info.about,
    })
}
