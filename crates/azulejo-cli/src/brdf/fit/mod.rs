//! `brdf fit`: fits the parameters of a model to measured data, or to another model.

mod measured;
mod search;
mod variables;

use super::args::FitArgs;
use super::model;
use crate::failure::Failure;
use crate::report::{Report, count, number, percent, short};
use crate::session::Session;
use azulejo::output::Output;
use azulejo_formats::brdf;
use azulejo_scene::brdf::{Description, Model, find};
use azulejo_trace::Progress;
use measured::{FitErrors, FitSample};
use search::{FitError, FitProblem, FitResult};
use serde_json::{Value, json};
use variables::FitVariable;

/// Runs `brdf fit`.
pub fn run(args: &FitArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = args.output.as_deref().map(Output::check).transpose()?;
    session.claim_stdout(output.as_ref().is_some_and(Output::is_stdout))?;
    let given = given(&args.model)?;
    let target = model::read(&args.target, session)?;
    let entries = measured::entries(&target, args.most_angle.to_radians());
    if entries.is_empty() {
        let message = format!("{} reflects nothing within --most-angle", args.target.model);
        return Err(Failure::Failed(message));
    }
    let question = question(given, &entries)?;
    let starts = args.starts as usize;
    let (answer, lambert) = session.with_progress(|progress| {
        let answer = solved(&question, starts, progress)?;
        let lambert = question_of("diffuse", &entries)?;
        let lambert = solved(&lambert, 1, progress)?;
        Ok::<_, Failure>((answer, lambert))
    })?;
    if let Some(output) = &output {
        let description = answer.brdf.description();
        output.write(session.progress(), |out| {
            brdf::text::write(description, out)
        })?;
    }
    let mut report = Report::default();
    let errors = [&answer.brdf, &lambert.brdf].map(|b| measured::errors(&entries, b));
    describe(&question, &answer, errors, &mut report);
    if let Some(path) = &args.output {
        let path = path.display().to_string();
        report.fact("output", path.clone(), "wrote", path);
    }
    Ok(report)
}

/// The model to fit, with its fixed parameters.
fn given(text: &str) -> Result<Model, Failure> {
    match text.parse().map_err(Failure::misuse)? {
        Description::Model(model) => Ok(model),
        _ => Err(Failure::misuse(
            "a combination cannot be fitted, expected one model",
        )),
    }
}

fn question(given: Model, entries: &[FitSample]) -> Result<FitProblem<'_>, Failure> {
    let info = find(&given.name).map_err(Failure::misuse)?;
    let is_colored = entries.iter().any(|e| !e.value.is_grey());
    let variables = variables::variables(info, &given, is_colored);
    if variables.is_empty() {
        return Err(Failure::Misuse(format!(
            "all parameters of {} are given: there is nothing to fit",
            info.name
        )));
    }
    Ok(FitProblem {
        given,
        variables,
        entries,
        is_colored,
    })
}

fn question_of<'a>(name: &str, entries: &'a [FitSample]) -> Result<FitProblem<'a>, Failure> {
    question(Model::new(name, []), entries)
}

fn solved(question: &FitProblem, starts: usize, progress: &Progress) -> Result<FitResult, Failure> {
    search::search(question, starts, progress).map_err(|stopped| match stopped {
        FitError::Cancelled => Failure::Cancelled,
        FitError::Problem(problem) => Failure::misuse(problem),
    })
}

fn describe(
    question: &FitProblem,
    answer: &FitResult,
    errors: [FitErrors; 2],
    report: &mut Report,
) {
    let words = answer.brdf.description().to_string();
    report.value("model", words.as_str());
    report.fact(
        "entries",
        question.entries.len(),
        "fitted to",
        format!("{} pairs of directions", count(question.entries.len())),
    );
    let mut parameters = Vec::new();
    for (variable, value) in question.variables.iter().zip(&answer.values) {
        parameters.push(parameter(variable, *value, report));
    }
    report.value("parameters", Value::Array(parameters));
    let [fit, lambert] = errors;
    for (key, name, of) in [
        (
            "compressed_error",
            "RMS of ln(1 + f cos)",
            (|e| e.compressed) as fn(FitErrors) -> f64,
        ),
        ("relative_error", "relative RMS of f cos", |e| e.relative),
    ] {
        let words = match key {
            "relative_error" => [fit, lambert].map(|e| percent(of(e))),
            _ => [fit, lambert].map(|e| short(of(e))),
        };
        report.value(key, number(of(fit)));
        report.value(&format!("lambert_{key}"), number(of(lambert)));
        report.line(
            name,
            format!("{} (best diffuse surface: {})", words[0], words[1]),
        );
    }
    report.value("agreeing", answer.agreeing);
    report.line("model", words);
}

fn parameter(
    variable: &FitVariable,
    (value, error, is_at_end): (f64, f64, bool),
    report: &mut Report,
) -> Value {
    let name = variable.name();
    let behind = if is_at_end {
        ", at the limit of its range"
    } else {
        ""
    };
    report.line(
        &name,
        format!("{} ± {}{behind}", short(value), short(error)),
    );
    json!({
        "name": name,
        "value": number(value),
        "standard_error": number(error),
        "at_end_of_range": is_at_end,
    })
}
