//! A reflection model on one line, in GRF syntax: `name key = value ...`.

use crate::reading::lexer::{BadNumber, Lexer};
use azulejo_scene::brdf::{BrdfError, Description, Model, Parameter, Value, find};
use azulejo_scene::{Brdf, Rgb};
use std::sync::Arc;

/// The keyword before a sum of models: `combination weight = w1 model1 ... weight = w2 model2 ...`.
pub(crate) const COMBINATION: &str = "combination";

/// Maximum number of models in a sum. Each takes about a millisecond to construct.
pub(crate) const MOST_PARTS: usize = 64;

/// An error at an offset of the text.
#[derive(Clone, Debug)]
pub(crate) struct InlineError {
    pub offset: usize,
    pub found: String,
    pub expected: String,
}

pub(crate) type InlineResult<T> = Result<T, InlineError>;

/// The offsets of a model: of its name, and of each of its parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModelMarks {
    pub name: usize,
    pub parameters: Vec<usize>,
}

/// A parsed model, with its weight and offsets.
#[derive(Clone, Debug)]
pub(crate) struct WeightedModel {
    pub weight: f64,
    pub model: Model,
    pub marks: ModelMarks,
}

fn trouble(offset: usize, found: impl Into<String>, expected: impl Into<String>) -> InlineError {
    InlineError {
        offset,
        found: found.into(),
        expected: expected.into(),
    }
}

/// The error for an unexpected token.
pub(crate) fn unexpected(mut lexer: Lexer<'_>, expected: impl Into<String>) -> InlineError {
    trouble(lexer.skip_blank(), lexer.describe(), expected)
}

/// Whether a word begins a description.
pub(crate) fn is_model(word: &str) -> bool {
    find(word).is_ok() || word.eq_ignore_ascii_case(COMBINATION)
}

/// Whether `key = value` follows, rather than the next definition of the same `def` in GRF.
pub(crate) fn at_parameter(mut ahead: Lexer<'_>) -> bool {
    let bodies = ["rgb", "brdf", "texture"];
    ahead.word().is_some() && ahead.eat(b'=') && !bodies.iter().any(|body| ahead.eat_word(body))
}

/// Reads a model or a sum of models.
pub(crate) fn description(
    lexer: &mut Lexer<'_>,
) -> InlineResult<(Description, Vec<WeightedModel>)> {
    let mut ahead = *lexer;
    if ahead.eat_word(COMBINATION) {
        *lexer = ahead;
        let parts = parts(lexer)?;
        let sum = parts.iter().map(|p| (p.weight, p.model.clone())).collect();
        return Ok((Description::Combination(sum), parts));
    }
    let part = model(lexer, 1.0)?;
    Ok((Description::Model(part.model.clone()), vec![part]))
}

/// Reads the models of a sum; `weight = w` applies to the following models, up to the next weight.
fn parts(lexer: &mut Lexer<'_>) -> InlineResult<Vec<WeightedModel>> {
    let (mut parts, mut weight): (Vec<WeightedModel>, f64) = (Vec::new(), 1.0);
    loop {
        let mut ahead = *lexer;
        if at_parameter(*lexer) && ahead.eat_word("weight") {
            ahead.eat(b'=');
            *lexer = ahead;
            weight = number(lexer, "the weight of a model, from 0")?;
            if weight < 0.0 {
                let found = format!("a weight of {weight}");
                return Err(trouble(ahead.skip_blank(), found, "a weight from 0 to 1"));
            }
            // This rejects a weight that no model follows.
            parts.push(part(lexer, weight, parts.len())?);
        } else if lexer.peek_word().is_some_and(|word| find(word).is_ok()) {
            parts.push(part(lexer, weight, parts.len())?);
        } else {
            return Ok(parts);
        }
    }
}

fn part(lexer: &mut Lexer<'_>, weight: f64, before: usize) -> InlineResult<WeightedModel> {
    if before < MOST_PARTS {
        return model(lexer, weight);
    }
    let expected = format!("at most {MOST_PARTS} models in a combination");
    Err(trouble(lexer.skip_blank(), "one more", expected))
}

/// Reads `name key = value ...`.
fn model(lexer: &mut Lexer<'_>, weight: f64) -> InlineResult<WeightedModel> {
    let mut marks = ModelMarks {
        name: lexer.skip_blank(),
        parameters: Vec::new(),
    };
    let Some(name) = lexer.word() else {
        return Err(unexpected(*lexer, "the name of a reflection model"));
    };
    let mut model = Model {
        name: name.to_owned(),
        parameters: Vec::new(),
    };
    while at_parameter(*lexer) {
        let mut ahead = *lexer;
        let offset = ahead.skip_blank();
        let name = ahead.word().unwrap_or_default();
        if name.eq_ignore_ascii_case("weight") {
            break;
        }
        ahead.eat(b'=');
        *lexer = ahead;
        let value = value(lexer)?;
        marks.parameters.push(offset);
        model.parameters.push(Parameter {
            name: name.to_owned(),
            value,
        });
        // No model has this many parameters: one of them is invalid, and the rest need not be kept.
        if model.parameters.len() > MOST_PARTS {
            break;
        }
    }
    Ok(WeightedModel {
        weight,
        model,
        marks,
    })
}

/// Reads a number, `(r, g, b)`, or a word.
pub(crate) fn value(lexer: &mut Lexer<'_>) -> InlineResult<Value> {
    let expected = "a number, (r, g, b), or a word";
    let offset = lexer.skip_blank();
    if lexer.at_number() {
        return number(lexer, expected).map(Value::Number);
    }
    if !lexer.eat(b'(') {
        let word = lexer.word().map(|word| Value::Word(word.to_owned()));
        return word.ok_or_else(|| unexpected(*lexer, expected));
    }
    let mut numbers = vec![number(lexer, "a number")?];
    while !lexer.eat(b')') {
        lexer.eat(b',');
        numbers.push(number(lexer, "a number, or `)`")?);
        if numbers.len() > 3 {
            return Err(trouble(offset, "a longer list", "a number or (r, g, b)"));
        }
    }
    match numbers[..] {
        [number] => Ok(Value::Number(number)),
        [r, g, b] => Ok(Value::Color(Rgb::new(r, g, b))),
        _ => Err(trouble(offset, "two numbers", "a number or (r, g, b)")),
    }
}

pub(crate) fn number(lexer: &mut Lexer<'_>, expected: &str) -> InlineResult<f64> {
    lexer.number().map_err(|bad| match bad {
        BadNumber::TooLarge => unexpected(*lexer, format!("{expected} that is not so large")),
        BadNumber::Missing | BadNumber::Malformed => unexpected(*lexer, expected),
    })
}

/// The model of a description, or the error with its offset.
pub(crate) fn made(description: &Description, parts: &[WeightedModel]) -> InlineResult<Arc<Brdf>> {
    Brdf::new(description.clone())
        .map(Arc::new)
        .map_err(|problem| locate_problem(&problem, parts))
}

/// Checks each model separately.
pub(crate) fn check(parts: &[WeightedModel]) -> InlineResult<()> {
    parts.iter().try_for_each(|part| {
        let alone = Brdf::new(Description::Model(part.model.clone()));
        alone.map(drop).map_err(|p| locate_in_part(&p, part))
    })
}

/// Locates the model and the parameter that a problem is about.
fn locate_problem(problem: &BrdfError, parts: &[WeightedModel]) -> InlineError {
    match check(parts) {
        Err(trouble) => trouble,
        Ok(()) => {
            let start = parts.first().map_or(0, |p| p.marks.name);
            let (found, expected) = in_words(problem);
            trouble(start, found, expected)
        }
    }
}

fn locate_in_part(problem: &BrdfError, part: &WeightedModel) -> InlineError {
    let (found, expected) = in_words(problem);
    let is_called = |parameter: &Parameter, name: &str| {
        let known = find(&part.model.name).ok();
        let known = known.and_then(|i| i.all_parameters().find(|p| p.name == name));
        parameter.name == name || known.is_some_and(|p| p.is_called(&parameter.name))
    };
    let mut parameters = part.model.parameters.iter();
    let at = match problem {
        BrdfError::Twice { name } => parameters.rposition(|p| is_called(p, name)),
        BrdfError::UnknownParameter { name, .. } => parameters.position(|p| is_called(p, name)),
        BrdfError::WrongKind { name, .. } | BrdfError::Range { name, .. } => {
            parameters.position(|p| is_called(p, name))
        }
        _ => None,
    };
    let offset = at.and_then(|k| part.marks.parameters.get(k));
    trouble(*offset.unwrap_or(&part.marks.name), found, expected)
}

/// A problem as what was found and what was expected.
pub(crate) fn in_words(problem: &BrdfError) -> (String, String) {
    match problem {
        BrdfError::UnknownModel { name, nearest } => (
            format!("the reflection model `{name}`"),
            format!("a known one: the nearest name is `{nearest}`"),
        ),
        BrdfError::UnknownParameter {
            model,
            name,
            known,
            nearest,
        } => {
            let nearest = nearest.map(|n| format!(": the nearest name is `{n}`"));
            (
                format!("the parameter `{name}` of `{model}`"),
                format!("{}{}", known.join(", "), nearest.unwrap_or_default()),
            )
        }
        BrdfError::Missing { model, name } => {
            (format!("`{model}` without `{name}`"), format!("`{name}`"))
        }
        BrdfError::Twice { name } => (format!("`{name}` again"), "each parameter once".into()),
        BrdfError::WrongKind { name, expected } => (
            format!("another type of value for `{name}`"),
            expected.clone(),
        ),
        BrdfError::Range {
            name,
            value,
            least,
            most,
        } => (
            format!("`{name}` of {value}"),
            format!("a number between {least} and {most}"),
        ),
        BrdfError::Energy { what, sum } => (
            format!("{what} of {sum}"),
            "at most 1, for energy conservation".into(),
        ),
        other => (other.to_string(), "a valid reflection model".into()),
    }
}

/// Warnings about a questionable model: it is not reciprocal, its coefficients add up to more than 1,
/// or its albedo exceeds 1 in some direction.
pub(crate) fn doubts(brdf: &Brdf) -> Vec<String> {
    let models: Vec<&Model> = match brdf.description() {
        Description::Model(model) => vec![model],
        Description::Combination(parts) => parts.iter().map(|(_, model)| model).collect(),
        Description::File { .. } => Vec::new(),
    };
    let infos = || models.iter().filter_map(|m| find(&m.name).ok());
    let mut doubts = Vec::new();
    if let Some(info) = infos().find(|i| !i.is_reciprocal) {
        doubts.push(format!(
            "the brdf `{}` is not reciprocal; `lewis` has the same highlight and is reciprocal",
            info.name
        ));
    }
    if !models.is_empty() && infos().all(|i| i.is_energy_safe) {
        return doubts;
    }
    let [angle, most] = steepest(brdf);
    // Sampling yields the albedo to about a thousandth.
    if most > 1.0 + 2e-3 {
        doubts.push(format!(
            "a brdf has the albedo {most:.2} at {angle} degrees: scaled down where it would not conserve energy"
        ));
    } else if let Some(sum) = models.iter().find_map(|m| excess(m)) {
        // A narrow lobe of this model reflects little, whatever its coefficient says.
        doubts.push(format!(
            "a brdf `phong` with kd + ks of {sum}, which other programs may scale down: at most 1 is safe"
        ));
    }
    doubts
}

/// The sum of the coefficients of `phong`, the one model that allows any, if it exceeds 1.
fn excess(model: &Model) -> Option<f64> {
    let is_phong = find(&model.name).is_ok_and(|info| info.name == "phong");
    let value = |name: &str, default: f64| match model.value(name) {
        Some(Value::Number(number)) => Rgb::grey(*number),
        Some(Value::Color(color)) => *color,
        Some(Value::Word(_)) | None => Rgb::grey(default),
    };
    let sum = (value("kd", 0.0) + value("ks", 1.0)).max_channel();
    // Without the rounding of the sum.
    (is_phong && sum > 1.0 + 1e-9).then(|| (sum * 1e6).round() / 1e6)
}

/// The greatest albedo at 0, 60 or 85 degrees, with its angle first.
fn steepest(brdf: &Brdf) -> [f64; 2] {
    let at = |angle: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        [
            angle,
            brdf.albedo(glam::DVec3::new(sin, 0.0, cos)).max_channel(),
        ]
    };
    let angles = [0.0, 60.0, 85.0].map(at);
    angles
        .into_iter()
        .fold([0.0; 2], |a, b| if b[1] > a[1] { b } else { a })
}
