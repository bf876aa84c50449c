//! Why a model could not be read, in the language of the window.

use crate::words::Language;
use azulejo::files::reason;
use azulejo::formats::{Position, ReadError};
use azulejo::models::ReadFailure;
use std::io::ErrorKind;
use std::path::Path;

/// What readers find most often in files that are not models; other messages stay in English.
const PHRASES: [&str; 6] = [
    "an empty file",
    "text in no known format",
    "only white space",
    "the end of the file",
    "a PNG picture",
    "a PDF document",
];

/// A failure as text. In English it is what the command line says, too.
pub fn describe(language: Language, path: &Path, failure: &ReadFailure) -> String {
    if language == Language::English {
        let text = failure.to_string();
        let is_named = text.contains(&*path.to_string_lossy());
        return if is_named {
            text
        } else {
            format!("{}: {text}", path.display())
        };
    }
    match failure {
        ReadFailure::File(refused) => {
            let why = match refused.error.kind() {
                ErrorKind::NotFound => language.tr("the file does not exist").to_owned(),
                ErrorKind::PermissionDenied => language.tr("access is denied").to_owned(),
                _ => reason(&refused.error),
            };
            format!("{}: {why}", refused.path.display())
        }
        ReadFailure::Directory(path) => {
            let why = language.tr("this is a folder, expected a model");
            format!("{}: {why}", path.display())
        }
        ReadFailure::Content(error) => content(language, error),
        other => format!("{}: {other}", path.display()),
    }
}

/// What was found where, and what was expected.
fn content(language: Language, error: &ReadError) -> String {
    let place = match error.position {
        Position::Whole => String::new(),
        Position::Line(line, column) => {
            let [line_word, column_word] = [language.tr("line"), language.tr("column")];
            format!(", {line_word} {line}, {column_word} {column}")
        }
        Position::Byte(offset) => format!(", {} {offset}", language.tr("byte")),
    };
    let known = |text: &str| {
        let phrase = PHRASES.iter().find(|p| **p == text);
        phrase.map_or_else(|| text.to_owned(), |p| language.tr(p).to_owned())
    };
    let [found_label, expected] = [language.tr("Found:"), language.tr("Expected:")];
    let expected_text = match error.expected.strip_prefix("a model in ") {
        Some(formats) => format!("{} {formats}", language.tr("a model in")),
        None => known(&error.expected),
    };
    let mut text = format!(
        "{}{place}\n{found_label} {}\n{expected} {expected_text}",
        error.file,
        known(&error.found)
    );
    if let Some(line) = &error.source_line {
        let shown: String = line.chars().take(120).collect();
        text += &format!("\n\n{shown}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::files::Refused;

    #[test]
    fn failures_are_said_in_the_language_of_the_window() {
        let path = Path::new("/a/b.obj");
        let missing = ReadFailure::File(Refused {
            deed: "read",
            path: path.to_owned(),
            error: ErrorKind::NotFound.into(),
        });
        let spanish = describe(Language::Spanish, path, &missing);
        assert_eq!(spanish, "/a/b.obj: el archivo no existe");
        let text = "v 1 2\nf 1 2 x";
        let broken = ReadError::at_line("b.obj", text, 2, 7, "\"x\"", "the end of the file");
        let broken = ReadFailure::Content(broken);
        let text = describe(Language::Portuguese, path, &broken);
        for part in [
            "b.obj",
            "linha 2",
            "Encontrado: \"x\"",
            "o fim do ficheiro",
            "f 1 2 x",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        let english = describe(Language::English, path, &broken);
        assert!(
            english.starts_with("/a/b.obj: b.obj:2:7: found"),
            "{english}"
        );
    }
}
