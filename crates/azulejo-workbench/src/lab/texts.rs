//! The texts of the lessons.

use super::Lesson;
use crate::words::Language;
use serde::Deserialize;
use std::sync::OnceLock;

/// The texts of one lesson. Labels of the window are in braces, names of objects between backquotes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LessonTexts {
    /// Its title.
    pub title: String,
    /// What it is about, in paragraphs.
    pub about: Vec<String>,
    /// What to do.
    pub steps: Vec<String>,
    /// The question that the number answers.
    pub question: String,
    /// What a wrong answer may come from.
    pub hint: String,
    /// The known answer and where it comes from, in paragraphs; `{=}` stands for its value.
    pub answer: Vec<String>,
}

/// A piece of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum TextPiece<'a> {
    /// Words as they stand.
    Plain(&'a str),
    /// The English text of a label of the window.
    Label(&'a str),
    /// The name of an object or material, or a value to type.
    Name(&'a str),
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TextFile {
    lesson: Vec<LessonTexts>,
}

impl Lesson {
    /// Its texts. A test reads the files: if one were damaged, a lesson without texts would be better than none.
    pub fn texts(self, language: Language) -> &'static LessonTexts {
        static FILES: [OnceLock<Vec<LessonTexts>>; 3] = [const { OnceLock::new() }; 3];
        static NONE: OnceLock<LessonTexts> = OnceLock::new();
        let file = FILES[language as usize].get_or_init(|| {
            let file: TextFile = toml::from_str(source(language)).unwrap_or_default();
            file.lesson
        });
        let texts = file.get(self as usize);
        texts.unwrap_or_else(|| NONE.get_or_init(LessonTexts::default))
    }
}

/// The file of a language.
pub(super) fn source(language: Language) -> &'static str {
    match language {
        Language::English => include_str!("../../lab/en.toml"),
        Language::Spanish => include_str!("../../lab/es.toml"),
        Language::Portuguese => include_str!("../../lab/pt.toml"),
    }
}

/// The pieces of a text, in order. What is not closed is plain.
pub(crate) fn pieces(text: &str) -> Vec<TextPiece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['{', '`']) {
        let end = if rest[at..].starts_with('{') {
            '}'
        } else {
            '`'
        };
        let Some(length) = rest[at + 1..].find(end) else {
            break;
        };
        let inside = &rest[at + 1..][..length];
        if at > 0 {
            pieces.push(TextPiece::Plain(&rest[..at]));
        }
        pieces.push(match end {
            '}' => TextPiece::Label(inside),
            _ => TextPiece::Name(inside),
        });
        rest = &rest[at + length + 2..];
    }
    if !rest.is_empty() {
        pieces.push(TextPiece::Plain(rest));
    }
    pieces
}
