//! Descriptions of reflection models, in the notation of files and the command line.

use super::arguments::Arguments;
use super::lobe::Lobe;
use super::measured::Table;
use super::{BrdfError, Measured, models};
use crate::Rgb;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// A reflection model as a file describes it, by the names of [`MODELS`](super::MODELS).
#[derive(Clone, Debug, PartialEq)]
pub enum Description {
    /// One model with its parameters.
    Model(Model),
    /// A sum of models, each with a weight.
    Combination(Vec<(f64, Model)>),
    /// A model in another file.
    File {
        /// The file's name as written, relative to the model.
        path: String,
        /// Its content; `None` if the file was not found. The model then reflects nothing.
        content: Option<Arc<Content>>,
    },
}

/// The content of a file of a reflection model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Content {
    /// A description.
    Text(Description),
    /// Measurements.
    Measured(Arc<Measured>),
}

/// A model with its parameters, as written in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// A name of [`MODELS`](super::MODELS), or an unknown one.
    pub name: String,
    /// In the order of the file.
    pub parameters: Vec<Parameter>,
}

/// `name = value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Value,
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// One number, for all channels where a colour is expected.
    Number(f64),
    /// One number per channel.
    Color(Rgb),
    /// A name.
    Word(String),
}

impl Model {
    /// A model with parameters.
    pub fn new<const N: usize>(name: &str, parameters: [(&str, Value); N]) -> Model {
        let parameter = |(name, value): (&str, Value)| Parameter {
            name: name.to_owned(),
            value,
        };
        Model {
            name: name.to_owned(),
            parameters: parameters.map(parameter).to_vec(),
        }
    }

    /// The value of a parameter, by the name that the file or the model gives it.
    pub fn value(&self, name: &str) -> Option<&Value> {
        let known = models::find(&self.name).ok();
        let known = known.and_then(|info| info.all_parameters().find(|p| p.is_called(name)));
        let is = |given: &str| {
            given.eq_ignore_ascii_case(name) || known.is_some_and(|p| p.is_called(given))
        };
        let parameter = self.parameters.iter().find(|p| is(&p.name));
        parameter.map(|p| &p.value)
    }

    fn lobes(&self) -> Result<Vec<Lobe>, BrdfError> {
        let info = models::find(&self.name)?;
        (info.make)(&Arguments::new(info, &self.parameters)?)
    }
}

impl Description {
    /// One model.
    pub fn model<const N: usize>(name: &str, parameters: [(&str, Value); N]) -> Description {
        Description::Model(Model::new(name, parameters))
    }

    /// Its lobes, each with its weight.
    pub(super) fn lobes(&self) -> Result<Vec<(f64, Lobe)>, BrdfError> {
        match self {
            Description::Model(model) => Ok(model.lobes()?.into_iter().map(|l| (1.0, l)).collect()),
            Description::Combination(parts) => combination(parts),
            Description::File { content: None, .. } => Ok(Vec::new()),
            Description::File {
                content: Some(content),
                ..
            } => match &**content {
                Content::Text(description) => description.lobes(),
                Content::Measured(measured) => {
                    Ok(vec![(1.0, Lobe::Measured(Table(measured.clone())))])
                }
            },
        }
    }
}

fn combination(parts: &[(f64, Model)]) -> Result<Vec<(f64, Lobe)>, BrdfError> {
    let mut sum = 0.0;
    let mut lobes = Vec::new();
    for (weight, model) in parts {
        // NaN is not at least 0 either.
        if !(*weight >= 0.0) {
            return Err(BrdfError::Range {
                name: "weight",
                value: *weight,
                least: 0.0,
                most: 1.0,
            });
        }
        sum += weight;
        lobes.extend(model.lobes()?.into_iter().map(|lobe| (*weight, lobe)));
    }
    if sum > 1.0 + 1e-9 {
        return Err(BrdfError::Energy {
            what: "the sum of the weights of a combination".to_owned(),
            sum,
        });
    }
    Ok(lobes)
}

impl From<Rgb> for Value {
    /// One number where all channels are equal.
    fn from(color: Rgb) -> Value {
        if color.is_grey() {
            Value::Number(color.r)
        } else {
            Value::Color(color)
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Value {
        Value::Number(number)
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(number) => write!(f, "{number}"),
            Value::Color(Rgb { r, g, b }) => write!(f, "({r}, {g}, {b})"),
            Value::Word(word) => f.write_str(word),
        }
    }
}

impl fmt::Display for Model {
    /// As GRF writes it: `name key = value ...`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        let mut parameters = self.parameters.iter();
        parameters.try_for_each(|p| write!(f, " {} = {}", p.name, p.value))
    }
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Description::Model(model) => model.fmt(f),
            Description::Combination(parts) => {
                f.write_str("combination")?;
                let mut parts = parts.iter();
                parts.try_for_each(|(weight, model)| write!(f, " weight = {weight} {model}"))
            }
            Description::File { path, .. } => write!(f, "\"{path}\""),
        }
    }
}

/// Splits `text` into words, numbers and lists; `=` and `,` are blanks beside them.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let end = match rest.as_bytes()[0] {
            b'(' => rest.find(')').map_or(rest.len(), |k| k + 1),
            b'=' => 1,
            _ => rest
                .find(|c: char| c.is_whitespace() || c == '=' || c == '(')
                .unwrap_or(rest.len()),
        };
        tokens.push(&rest[..end]);
        rest = rest[end..].trim_start();
    }
    tokens
}

impl FromStr for Value {
    type Err = BrdfError;

    /// A number, three in brackets or with commas between them, or a word.
    fn from_str(text: &str) -> Result<Value, BrdfError> {
        let list = text.trim_start_matches('(').trim_end_matches(')');
        let numbers: Option<Vec<f64>> = list.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([number]) => Ok(Value::Number(*number)),
            Some([r, g, b]) => Ok(Value::Color(Rgb::new(*r, *g, *b))),
            None if text.starts_with(|c: char| c.is_alphabetic()) => {
                Ok(Value::Word(text.to_owned()))
            }
            _ => Err(BrdfError::Syntax {
                found: format!("`{text}`"),
                expected: "a number, (r, g, b), or a word",
            }),
        }
    }
}

impl FromStr for Description {
    type Err = BrdfError;

    /// `name key = value ...`, or `combination weight = w name ... weight = w name ...`.
    fn from_str(text: &str) -> Result<Description, BrdfError> {
        let words = tokens(text);
        let [name, rest @ ..] = &words[..] else {
            return Err(BrdfError::Syntax {
                found: "nothing".to_owned(),
                expected: "the name of a reflection model",
            });
        };
        if name.eq_ignore_ascii_case("combination") {
            return parts(rest).map(Description::Combination);
        }
        let (model, rest) = model(name, rest)?;
        match rest {
            [] => Ok(Description::Model(model)),
            [found, ..] => Err(BrdfError::Syntax {
                found: format!("`{found}`"),
                expected: "key = value",
            }),
        }
    }
}

/// Parses the parameters of a model; stops at the first token that is not one.
fn model<'a, 'b>(name: &str, mut rest: &'b [&'a str]) -> Result<(Model, &'b [&'a str]), BrdfError> {
    let mut model = Model {
        name: name.to_owned(),
        parameters: Vec::new(),
    };
    while let [key, "=", value, behind @ ..] = rest {
        if key.eq_ignore_ascii_case("weight") {
            break;
        }
        model.parameters.push(Parameter {
            name: (*key).to_owned(),
            value: value.parse()?,
        });
        rest = behind;
    }
    Ok((model, rest))
}

fn parts(mut rest: &[&str]) -> Result<Vec<(f64, Model)>, BrdfError> {
    let (mut parts, mut weight) = (Vec::new(), 1.0);
    loop {
        match rest {
            [] => return Ok(parts),
            [key, "=", value, behind @ ..] if key.eq_ignore_ascii_case("weight") => {
                let Value::Number(number) = value.parse()? else {
                    return Err(BrdfError::WrongKind {
                        name: "weight",
                        expected: "one number".to_owned(),
                    });
                };
                (weight, rest) = (number, behind);
            }
            [name, behind @ ..] => {
                let (part, behind) = model(name, behind)?;
                parts.push((weight, part));
                rest = behind;
            }
        }
    }
}
