//! `brdf`: a file, or a model with its parameters.

use super::entries::Entries;
use super::lexer::Lexer;
use super::parser::{Parsed, Parser};
use azulejo_scene::brdf::{Description, Model, Parameter, Value, find};
use azulejo_scene::{Brdf, Rgb};
use std::sync::Arc;

/// The word before a sum of models: `combination weight = w1 model1 ... weight = w2 model2 ...`.
pub(super) const COMBINATION: &str = "combination";

/// A reflection model as the file says it, and what it makes.
#[derive(Clone, Debug)]
pub(super) struct Reflection {
    pub description: Description,
    /// `None` where a diffuse reflectance and a mirror say all.
    pub brdf: Option<Arc<Brdf>>,
}

impl From<&Arc<Brdf>> for Reflection {
    fn from(brdf: &Arc<Brdf>) -> Reflection {
        Reflection {
            description: brdf.description().clone(),
            brdf: Some(brdf.clone()),
        }
    }
}

/// Reflectances of surfaces that need no model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plain {
    pub diffuse: Option<Rgb>,
    pub mirror: Rgb,
}

/// A colour among the parameters of a model.
pub(super) fn color(model: &Model, name: &str) -> Option<Rgb> {
    match model.value(name)? {
        Value::Number(grey) => Some(Rgb::grey(*grey)),
        Value::Color(color) => Some(*color),
        Value::Word(_) => None,
    }
}

/// What a description says, if matt and mirror say all of it.
pub(super) fn plain(description: &Description) -> Option<Plain> {
    let parts = match description {
        Description::Model(model) => std::slice::from_ref(model)
            .iter()
            .map(|m| (1.0, m))
            .collect(),
        Description::Combination(parts) => parts.iter().map(|(w, m)| (*w, m)).collect(),
        Description::File { .. } => return None,
    };
    sum(parts)
}

fn sum(parts: Vec<(f64, &Model)>) -> Option<Plain> {
    let mut sum = Plain::default();
    for (weight, model) in parts {
        let name = find(&model.name).ok()?.name;
        match name {
            "diffuse" => {
                let kd = weight * color(model, "kd").unwrap_or(Rgb::BLACK);
                sum.diffuse = Some(sum.diffuse.unwrap_or(Rgb::BLACK) + kd);
            }
            "specular" => {
                sum.mirror += weight * color(model, "ks").unwrap_or(Rgb::WHITE);
                sum.diffuse = Some(sum.diffuse.unwrap_or(Rgb::BLACK));
            }
            _ => return None,
        }
    }
    Some(sum)
}

fn is_model(word: &str) -> bool {
    find(word).is_ok() || word.eq_ignore_ascii_case(COMBINATION)
}

impl<'a> Parser<'a, '_, '_> {
    /// `brdf` was read.
    pub fn brdf(&mut self) -> Parsed<Arc<Reflection>> {
        let offset = self.lexer.skip_blank();
        let mut ahead = self.lexer;
        let description = match ahead.word() {
            Some(word) if word.eq_ignore_ascii_case(COMBINATION) => {
                self.lexer = ahead;
                Description::Combination(self.parts()?)
            }
            Some(word) if is_model(word) || at_parameter(ahead) => {
                Description::Model(self.model()?)
            }
            _ => Description::File {
                path: self.file_name()?.to_owned(),
                content: None,
            },
        };
        self.reflection(offset, description)
    }

    /// The one copy of what a description makes.
    pub fn reflection(
        &mut self,
        offset: usize,
        description: Description,
    ) -> Parsed<Arc<Reflection>> {
        let text = description.to_string();
        if let Some(known) = self.shared.reflections.get(&text) {
            return Ok(known.clone());
        }
        let made = Arc::new(self.made(offset, description)?);
        self.shared.reflections.insert(text, made.clone());
        Ok(made)
    }

    fn made(&mut self, offset: usize, description: Description) -> Parsed<Reflection> {
        let brdf = if plain(&description).is_some() {
            None
        } else {
            match Brdf::new(description.clone()) {
                Ok(brdf) => Some(Arc::new(brdf)),
                Err(problem) => {
                    self.warn(offset, problem.to_string());
                    None
                }
            }
        };
        Ok(Reflection { description, brdf })
    }

    /// `weight = w` holds for the models behind it, up to the next weight.
    fn parts(&mut self) -> Parsed<Vec<(f64, Model)>> {
        let (mut parts, mut weight) = (Vec::new(), 1.0);
        loop {
            if at_parameter(self.lexer) {
                self.expect_word("weight")?;
                self.expect(b'=')?;
                weight = self.number()?;
            } else if self.lexer.peek_word().is_some_and(is_model) {
                parts.push((weight, self.model()?));
            } else {
                return Ok(parts);
            }
        }
    }

    fn model(&mut self) -> Parsed<Model> {
        let mut model = Model {
            name: self.lexer.word().unwrap_or("").to_owned(),
            parameters: Vec::new(),
        };
        while at_parameter(self.lexer) {
            let mut ahead = self.lexer;
            let name = ahead.word().unwrap_or("").to_owned();
            if name.eq_ignore_ascii_case("weight") {
                break;
            }
            self.lexer = ahead;
            self.expect(b'=')?;
            let value = self.parameter()?;
            model.parameters.push(Parameter { name, value });
        }
        Ok(model)
    }

    /// The file that an extension names.
    pub fn take_brdf_file(&mut self, entries: &mut Entries<'a>) -> Parsed<Option<Arc<Reflection>>> {
        let offset = entries.offset;
        let Some(path) = self.take_text(entries, "brdf_file")? else {
            return Ok(None);
        };
        let content = None;
        let file = Description::File { path, content };
        self.reflection(offset, file).map(Some)
    }

    fn parameter(&mut self) -> Parsed<Value> {
        let offset = self.lexer.skip_blank();
        if !self.lexer.at_number() && self.lexer.peek() != Some(b'(') {
            return match self.lexer.word() {
                Some(word) => Ok(Value::Word(word.to_owned())),
                None => Err(self.unexpected("a number, (r, g, b), or a word")),
            };
        }
        match self.number_or_list()?[..] {
            [number] => Ok(Value::Number(number)),
            [r, g, b] => Ok(Value::Color(Rgb::new(r, g, b))),
            _ => Err(self.fail(offset, "a list", "a number or (r, g, b)")),
        }
    }
}

/// Whether `key = value` follows, and not the next definition of the same `def`.
fn at_parameter(mut ahead: Lexer<'_>) -> bool {
    ahead.word().is_some()
        && ahead.eat(b'=')
        && !["rgb", "brdf", "texture"]
            .iter()
            .any(|body| ahead.eat_word(body))
}
