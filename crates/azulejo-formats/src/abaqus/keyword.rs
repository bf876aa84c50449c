//! Keyword lines: a keyword and its parameters, over one or more lines.

use crate::reading::cursor::{TextCursor, is_line_end};
use crate::reading::text::text;

/// A line that is neither a comment nor empty.
#[derive(Clone, Copy)]
pub(super) struct InputLine<'a> {
    /// The line without the blanks around it.
    pub text: &'a [u8],
    /// Its offset.
    pub at: usize,
}

/// The lines of a file.
#[derive(Clone, Copy)]
pub(super) struct InputLines<'a> {
    pub text: TextCursor<'a>,
}

impl<'a> Iterator for InputLines<'a> {
    type Item = InputLine<'a>;

    fn next(&mut self) -> Option<InputLine<'a>> {
        while !self.text.at_end() {
            let start = self.text.offset();
            let line = self.text.take_while(|b| !is_line_end(b));
            self.text.pass_line_end();
            let at = start + line.len() - line.trim_ascii_start().len();
            let line = line.trim_ascii();
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some(InputLine { text: line, at });
            }
        }
        None
    }
}

/// A field of a line, without the blanks around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct InputField<'a> {
    pub text: &'a [u8],
    pub at: usize,
}

impl<'a> InputLine<'a> {
    /// Whether this is the first line of a keyword.
    pub fn is_keyword(&self) -> bool {
        self.text.starts_with(b"*")
    }

    /// The fields between commas; a comma at the end of the line has none behind it.
    pub fn fields(&self) -> impl Iterator<Item = InputField<'a>> + use<'a> {
        let mut at = self.at;
        let text = self.text.strip_suffix(b",").unwrap_or(self.text);
        text.split(|&b| b == b',').map(move |field| {
            let blanks = field.len() - field.trim_ascii_start().len();
            let trimmed = InputField {
                text: field.trim_ascii(),
                at: at + blanks,
            };
            at += field.len() + 1;
            trimmed
        })
    }
}

/// A keyword with its parameters.
#[derive(Clone, Debug, Default)]
pub(super) struct KeywordLine {
    /// In capitals and without blanks, as CalculiX compares them: `SOLIDSECTION`.
    pub name: String,
    /// Names in capitals and without blanks, and values as they are, without quotes.
    parameters: Vec<(String, String)>,
    pub at: usize,
}

impl KeywordLine {
    /// Reads a keyword; a comma at the end of a line continues it on the next.
    pub fn read(first: InputLine, lines: &mut InputLines) -> KeywordLine {
        let mut whole = first.text.to_vec();
        while whole.last() == Some(&b',') {
            let mut ahead = *lines;
            match ahead.next() {
                Some(line) if !line.is_keyword() => {
                    whole.extend_from_slice(line.text);
                    *lines = ahead;
                }
                _ => break,
            }
        }
        let whole = text(&whole[1..]).into_owned();
        let mut parts = whole.split(',');
        let name = capitals(parts.next().unwrap_or_default());
        let parameters = parts.filter(|p| !p.trim().is_empty()).map(|part| {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            (capitals(name), unquoted(value).to_owned())
        });
        KeywordLine {
            name,
            parameters: parameters.collect(),
            at: first.at,
        }
    }

    /// The value of a parameter, empty if it has none; `None` if it is absent.
    pub fn parameter(&self, name: &str) -> Option<&str> {
        let mut known = self.parameters.iter();
        let parameter = known.find(|(known, _)| known == name);
        parameter.map(|(_, value)| value.as_str())
    }

    /// The value of a parameter that has one.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.parameter(name).filter(|v| !v.is_empty())
    }
}

/// A name without the quotes that it may be in.
pub(super) fn unquoted(name: &str) -> &str {
    name.trim().trim_matches('"').trim()
}

fn capitals(text: &str) -> String {
    let letters = text.chars().filter(|c| !c.is_whitespace());
    letters.map(|c| c.to_ascii_uppercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_continue_behind_a_comma() {
        let source = b"** a comment\n\n *Solid  section, elset = \"Set A\",\n** here\nMATERIAL=steel\r\n 1, 2,\n*End";
        let mut lines = InputLines {
            text: TextCursor::new(source),
        };
        let first = lines.next().unwrap();
        let keyword = KeywordLine::read(first, &mut lines);
        assert_eq!((&*keyword.name, keyword.at), ("SOLIDSECTION", 15));
        assert_eq!(keyword.value("ELSET"), Some("Set A"));
        assert_eq!(keyword.value("MATERIAL"), Some("steel"));
        assert_eq!(keyword.parameter("GENERATE"), None);
        let data = lines.next().unwrap();
        let fields: Vec<_> = data.fields().map(|f| (f.text, f.at)).collect();
        assert_eq!(fields, [(&b"1"[..], 74), (&b"2"[..], 77)]);
        assert!(lines.next().unwrap().is_keyword() && lines.next().is_none());
    }
}
