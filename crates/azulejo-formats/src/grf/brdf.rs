//! `brdf`: a file, or a model with its parameters.

use super::lexer::Lexer;
use super::parser::{Parsed, Parser};
use azulejo_scene::Brdf;
use std::sync::Arc;

/// The models that the grammar names.
const MODELS: [&str; 17] = [
    "diffuse",
    "specular",
    "phong",
    "blinn",
    "torrance",
    "poulin",
    "he",
    "ward",
    "lewis",
    "schlick",
    "oren-nayar",
    "strauss",
    "lafortune",
    "shirley",
    "minnaert",
    "beardmaxwell",
    COMBINATION,
];

/// The model that adds others: `combination weight = w1 model1 ... weight = w2 model2 ...`.
pub(super) const COMBINATION: &str = "combination";

fn is_model(word: &str) -> bool {
    MODELS.iter().any(|m| word.eq_ignore_ascii_case(m))
}

/// Whether a model can be written so that it is read back as it is.
pub(super) fn is_sayable(brdf: &Brdf) -> bool {
    let Brdf::Model { name, parameters } = brdf else {
        return false;
    };
    let is_word = |word: &str| {
        let mut lexer = Lexer::new(word);
        lexer.word() == Some(word)
    };
    let is_said = |(key, value): &(String, Vec<f64>)| match value[..] {
        [] => name == COMBINATION && is_model(key) && *key == key.to_ascii_lowercase(),
        _ => is_word(key) && value.iter().all(|v| v.is_finite()),
    };
    let is_named = is_model(name)
        || (is_word(name)
            && parameters
                .first()
                .is_some_and(|(_, value)| !value.is_empty()));
    is_named && *name == name.to_ascii_lowercase() && parameters.iter().all(is_said)
}

impl Parser<'_, '_, '_> {
    /// `brdf` was read.
    pub fn brdf(&mut self) -> Parsed<Arc<Brdf>> {
        let offset = self.lexer.skip_blank();
        let mut ahead = self.lexer;
        match ahead.word() {
            Some(word) if is_model(word) => {}
            Some(word) if at_parameter(ahead) => {
                self.warn(offset, format!("the brdf model `{word}` is not known"));
            }
            _ => {
                let path = self.file_name()?;
                return Ok(Arc::new(Brdf::File(path.to_owned())));
            }
        }
        let name = self.lexer.word().unwrap_or("").to_ascii_lowercase();
        let mut parameters = Vec::new();
        loop {
            if at_parameter(self.lexer) {
                let key = self.lexer.word().unwrap_or("").to_owned();
                self.expect(b'=')?;
                parameters.push((key, self.number_or_list()?));
            } else if name == COMBINATION && self.lexer.peek_word().is_some_and(is_model) {
                let part = self.lexer.word().unwrap_or("").to_ascii_lowercase();
                parameters.push((part, Vec::new()));
            } else {
                break;
            }
        }
        Ok(Arc::new(Brdf::Model { name, parameters }))
    }
}

/// Whether `key = number` or `key = (` follows.
fn at_parameter(mut ahead: Lexer<'_>) -> bool {
    ahead.word().is_some()
        && ahead.eat(b'=')
        && (ahead.at_number() || ahead.peek().is_none_or(|b| b == b'('))
}
