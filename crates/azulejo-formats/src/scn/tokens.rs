//! SCN's words, numbers and signs, after processing `#define` and `#include`.

use crate::reading::cursor::{TextCursor, is_line_end};
use crate::reading::files::open_beside;
use crate::reading::number;
use crate::reading::options::Budget;
use crate::reading::text::{into_decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::sff::document::{SffPosition, SffSources};
use crate::{Files, ReadError};
use std::collections::HashMap;

/// Maximum depth of includes and of definitions.
const DEEPEST: usize = 32;

/// A word, a number or a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScnToken {
    pub kind: ScnTokenKind,
    /// Its position, or that of the defined name from which it comes.
    pub place: SffPosition,
}

/// The type of a token.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ScnTokenKind {
    Number(f64),
    Word(TokenSpan),
    Sign(u8),
}

/// A byte range of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TokenSpan {
    file: u32,
    start: u32,
    length: u32,
}

impl TokenSpan {
    /// The text of the range.
    pub fn of<'s>(&self, sources: &'s SffSources) -> &'s str {
        let start = self.start as usize;
        let bytes = &sources.bytes(self.file)[start..start + self.length as usize];
        std::str::from_utf8(bytes).unwrap_or("?")
    }
}

/// Reads a file's tokens, and those of the files that it includes.
///
/// # Errors
/// Invalid characters, definitions and includes that cannot be processed.
pub(super) fn read(
    sources: &mut SffSources,
    files: &dyn Files,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Vec<ScnToken>, ReadError> {
    let mut reader = ScnTokenizer {
        sources,
        files,
        budget,
        warnings,
        definitions: HashMap::new(),
        tokens: Vec::new(),
    };
    reader.file(0, 0)?;
    Ok(reader.tokens)
}

struct ScnTokenizer<'r, 's> {
    sources: &'r mut SffSources<'s>,
    files: &'r dyn Files,
    budget: &'r mut Budget,
    warnings: &'r mut Warnings,
    definitions: HashMap<String, Vec<ScnToken>>,
    tokens: Vec<ScnToken>,
}

/// A directive, as opposed to a comment.
enum Directive {
    Define {
        name: TokenSpan,
        body: usize,
    },
    Undefine(TokenSpan),
    Include(TokenSpan),
    /// An unsupported directive.
    Other,
}

impl ScnTokenizer<'_, '_> {
    fn file(&mut self, file: u32, depth: usize) -> Result<(), ReadError> {
        let mut at = 0;
        // Operators are separate signs inside parentheses only.
        let mut parentheses = 0;
        loop {
            let bytes = self.sources.bytes(file);
            let place = SffPosition {
                file,
                offset: at as u32,
            };
            match bytes.get(at) {
                None => return Ok(()),
                Some(b) if *b <= b' ' => at += 1,
                Some(b'#') if starts_line(bytes, at) => {
                    let end = at + directive_length(&bytes[at..]);
                    match directive(bytes, file, at, end) {
                        None => {}
                        Some(directive) => self.obey(directive, place, end, depth)?,
                    }
                    at = end;
                }
                Some(b'%' | b';' | b'#') => at += line_length(&bytes[at..]),
                Some(_) => {
                    let (kind, length) = self.token(place, parentheses)?;
                    match kind {
                        ScnTokenKind::Sign(b'(') => parentheses += 1,
                        ScnTokenKind::Sign(b')') => parentheses -= 1,
                        _ => {}
                    }
                    self.push(ScnToken { kind, place }, place, 0)?;
                    at += length;
                }
            }
        }
    }

    /// Adds a token, or its definition.
    fn push(&mut self, token: ScnToken, place: SffPosition, depth: usize) -> Result<(), ReadError> {
        let name = self.sources.name(place.file);
        self.budget.spend(1).map_err(|e| e.error(name))?;
        let body = match token.kind {
            ScnTokenKind::Word(span) => self.definitions.get(span.of(self.sources)).cloned(),
            _ => None,
        };
        let Some(body) = body else {
            self.tokens.push(ScnToken { place, ..token });
            return Ok(());
        };
        if depth == DEEPEST {
            let found = "a definition that is recursive or nested too deeply";
            let expected = format!("at most {DEEPEST} levels");
            return Err(self.sources.error(place, found, expected));
        }
        for token in body {
            self.push(token, place, depth + 1)?;
        }
        Ok(())
    }

    fn token(
        &self,
        place: SffPosition,
        parentheses: i32,
    ) -> Result<(ScnTokenKind, usize), ReadError> {
        let rest = &self.sources.bytes(place.file)[place.offset as usize..];
        let signed = matches!(rest, [b'+' | b'-', b'.' | b'0'..=b'9', ..]);
        let begins = rest[0].is_ascii_digit() || matches!(rest, [b'.', b'0'..=b'9', ..]);
        if (begins || signed && parentheses == 0)
            && let Some(number) = number::parse(rest)
        {
            return Ok((ScnTokenKind::Number(number.value), number.length));
        }
        let word = rest
            .iter()
            .take_while(|b| is_word(**b, parentheses > 0))
            .count();
        if word > 0 && !rest[0].is_ascii_digit() {
            let span = TokenSpan {
                file: place.file,
                start: place.offset,
                length: word as u32,
            };
            return Ok((ScnTokenKind::Word(span), word));
        }
        match rest[0] {
            sign @ (b'(' | b')' | b',' | b'+' | b'-' | b'*' | b'/' | b'^' | b'|') => {
                Ok((ScnTokenKind::Sign(sign), 1))
            }
            _ => {
                let line = text(&rest[..line_length(rest)]).into_owned();
                let found = format!("\"{}\"", shortened(&line));
                Err(self
                    .sources
                    .error(place, found, "a word, a number or a comment"))
            }
        }
    }

    fn obey(
        &mut self,
        directive: Directive,
        place: SffPosition,
        end: usize,
        depth: usize,
    ) -> Result<(), ReadError> {
        match directive {
            Directive::Define { name, body } => {
                let body = self.body(place, body, end)?;
                let name = name.of(self.sources).to_owned();
                self.definitions.insert(name, body);
                Ok(())
            }
            Directive::Undefine(name) => {
                self.definitions.remove(name.of(self.sources));
                Ok(())
            }
            Directive::Include(name) => self.include(name, place, depth),
            Directive::Other => {
                let message = "directive other than #define, #undef and #include: skipped";
                let position = || self.sources.position(place);
                let name = self.sources.name(place.file);
                self.warnings.add(name, message.into(), position);
                Ok(())
            }
        }
    }

    /// The definition of a name.
    fn body(
        &mut self,
        place: SffPosition,
        mut at: usize,
        end: usize,
    ) -> Result<Vec<ScnToken>, ReadError> {
        let bytes = self.sources.bytes(place.file);
        if bytes.get(at) == Some(&b'(') {
            let found = "a definition with parameters";
            let expected = "a name and its replacement: run a C preprocessor on the file first";
            return Err(self.sources.error(place, found, expected));
        }
        let mut body = Vec::new();
        let mut parentheses = 0;
        while at < end {
            let bytes = self.sources.bytes(place.file);
            match bytes[at] {
                b if b <= b' ' || b == b'\\' => at += 1,
                b'%' | b';' | b'#' => break,
                _ => {
                    let here = SffPosition {
                        offset: at as u32,
                        ..place
                    };
                    let (kind, length) = self.token(here, parentheses)?;
                    match kind {
                        ScnTokenKind::Sign(b'(') => parentheses += 1,
                        ScnTokenKind::Sign(b')') => parentheses -= 1,
                        _ => {}
                    }
                    let name = self.sources.name(place.file);
                    self.budget.spend(1).map_err(|e| e.error(name))?;
                    body.push(ScnToken { kind, place: here });
                    at += length;
                }
            }
        }
        Ok(body)
    }

    fn include(
        &mut self,
        name: TokenSpan,
        place: SffPosition,
        depth: usize,
    ) -> Result<(), ReadError> {
        let name = name.of(self.sources).to_owned();
        let including = self.sources.name(place.file);
        let fail = |found: String, expected: &str| Err(self.sources.error(place, found, expected));
        if depth == DEEPEST {
            return fail("files that include each other".into(), "at most 32 levels");
        }
        let (path, bytes) = match open_beside(self.files, including, &name) {
            Ok(opened) => opened,
            Err(e) => {
                let found = format!("\"{}\", which cannot be read: {e}", shortened(&name));
                return fail(found, "a file beside the scene");
            }
        };
        // A small file may be included often.
        (self.budget.spend(bytes.len() as u64 / 8)).map_err(|e| e.error(including))?;
        let file = self.sources.add(&path, into_decoded(bytes));
        self.file(file, depth + 1)
    }
}

/// File names contain dots, slashes and minus signs, which are operators inside parentheses.
fn is_word(byte: u8, in_parentheses: bool) -> bool {
    let in_names = matches!(byte, b'.' | b'/' | b'\\' | b'-' | b'~' | b':');
    byte.is_ascii_alphanumeric() || byte == b'_' || in_names && !in_parentheses
}

fn line_length(bytes: &[u8]) -> usize {
    TextCursor::new(bytes).line_ahead().len()
}

/// The length of a directive's line, including continuation lines after a backslash.
fn directive_length(bytes: &[u8]) -> usize {
    let mut length = line_length(bytes);
    while length > 0 && bytes[length - 1] == b'\\' && length < bytes.len() {
        let behind = if bytes[length..].starts_with(b"\r\n") {
            2
        } else {
            1
        };
        length += behind + line_length(&bytes[length + behind..]);
    }
    length
}

fn starts_line(bytes: &[u8], at: usize) -> bool {
    let before = bytes[..at].iter().rev();
    let mut before = before.skip_while(|b| matches!(b, b' ' | b'\t'));
    before.next().is_none_or(|&b| is_line_end(b))
}

/// The directive of a line that begins with `#`; `None` for a comment.
fn directive(bytes: &[u8], file: u32, start: usize, end: usize) -> Option<Directive> {
    let line = &bytes[start..end];
    let word_at = |from: usize| {
        let blanks = line[from..]
            .iter()
            .take_while(|b| matches!(b, b' ' | b'\t'))
            .count();
        let begin = from + blanks;
        let word = |b: &&u8| b.is_ascii_alphanumeric() || **b == b'_';
        begin..begin + line[begin..].iter().take_while(word).count()
    };
    let span = |range: std::ops::Range<usize>| TokenSpan {
        file,
        start: (start + range.start) as u32,
        length: range.len() as u32,
    };
    let keyword = 1 + line[1..]
        .iter()
        .take_while(|b| b.is_ascii_lowercase())
        .count();
    let name = word_at(keyword);
    match &line[1..keyword] {
        b"define" if !name.is_empty() => Some(Directive::Define {
            body: start + name.end,
            name: span(name),
        }),
        b"undef" if !name.is_empty() => Some(Directive::Undefine(span(name))),
        b"include" => {
            let open = name.start;
            let closing = match line.get(open)? {
                b'"' => b'"',
                b'<' => b'>',
                _ => return None,
            };
            let length = line[open + 1..].iter().position(|b| *b == closing)?;
            Some(Directive::Include(span(open + 1..open + 1 + length)))
        }
        b"if" | b"ifdef" | b"ifndef" | b"else" | b"elif" | b"endif" => Some(Directive::Other),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Memory, ReadOptions};

    /// The tokens separated by blanks, or the error.
    fn tokens(text: &str, files: &Memory) -> Result<String, String> {
        let mut sources = SffSources::default();
        sources.add("a.scn", text.as_bytes());
        let mut budget = Budget::new(&ReadOptions::in_proportion(text.len()));
        let tokens = read(&mut sources, files, &mut budget, &mut Warnings::default());
        let shown = |token: &ScnToken| match token.kind {
            ScnTokenKind::Number(v) => v.to_string(),
            ScnTokenKind::Word(span) => span.of(&sources).to_owned(),
            ScnTokenKind::Sign(sign) => char::from(sign).to_string(),
        };
        let tokens = tokens.map_err(|e| e.to_string())?;
        Ok(tokens.iter().map(shown).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn words_numbers_and_definitions() {
        let files = Memory::new().with("b.scn", "#define B 7\nB C ; end");
        let check = |text: &str, expected: &str| {
            assert_eq!(tokens(text, &files).as_deref(), Ok(expected), "{text}");
        };
        check("a 3 -0.4 .5 % b\nc;d\n e#f", "a 3 -0.4 0.5 c e");
        check("(3 -0.4*-2^x)", "( 3 - 0.4 * - 2 ^ x )");
        check("text a-b.t3d ../c.d (a/b)", "text a-b.t3d ../c.d ( a / b )");
        check("# a remark\n#define A 1 (2-B) % c\nA", "1 ( 2 - B )");
        check("#define A 1 \\\n 2\nA #define", "1 2");
        check("#define C 5\n#include \"b.scn\"\nB\n#undef B\nB", "7 5 7 B");
    }

    #[test]
    fn what_cannot_be_carried_out() {
        let files = Memory::new().with("a.scn", "#include <a.scn>");
        let check = |text: &str, expected: &str| {
            let error = tokens(text, &files).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        };
        check("a\n @b", "a.scn:2:2: found \"@b\"");
        check(
            "#define A A\nA",
            "a.scn:2:1: found a definition that is recursive",
        );
        check(
            "#define A(x) x\nA",
            "a.scn:1:1: found a definition with parameters",
        );
        check(
            "#include \"a.scn\"",
            "a.scn:1:1: found files that include each other",
        );
        check(
            "#include \"c.scn\"",
            "a.scn:1:1: found \"c.scn\", which cannot be read",
        );
        let mut bomb = String::from("#define A0 1 1 1 1\n");
        for k in 0..20 {
            bomb += &format!("#define A{} A{k} A{k} A{k} A{k}\n", k + 1);
        }
        bomb += "A20";
        check(
            &bomb,
            "a.scn: found instances, arrays or curves that expand to more than",
        );
    }
}
