//! Text whose parts have sizes and colours of their own, and the markup for it.
//!
//! ```text
//! Sale {size=2 color=#c00|50%} off
//! ```
//!
//! A brace and the name of an attribute begin a part, a closing brace ends it; parts may contain others. `\{` and `\}`
//! are braces, and so are all that begin no part.

use azulejo_scene::Rgb;
use std::fmt;
use std::ops::Range;

/// A text, and how its parts look.
#[derive(Clone, Debug, PartialEq)]
pub struct StyledText {
    /// The text, without markup.
    pub text: String,
    /// Its parts, in order and without gaps; none for a text without characters.
    pub spans: Vec<Span>,
}

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Its bytes.
    pub bytes: Range<usize>,
    /// How it looks.
    pub style: Style,
}

/// How a part of a text looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Font size, as a multiple of that of the text.
    pub size: f64,
    /// Colour, linear; `None` if it is that of the text.
    pub color: Option<Rgb>,
}

/// An error in markup.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MarkupError {
    /// Line in the text, from 1.
    pub line: usize,
    /// What is wrong.
    pub found: String,
}

/// The size of letters of a part is at most this multiple of that of the text, and at least its inverse.
const LARGEST: f64 = 1e6;

impl Default for Style {
    fn default() -> Style {
        Style {
            size: 1.0,
            color: None,
        }
    }
}

impl fmt::Display for MarkupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MarkupError { line, found } = self;
        write!(f, "line {line} of the text: {found}")
    }
}

impl std::error::Error for MarkupError {}

impl StyledText {
    /// A text that looks the same everywhere.
    pub fn plain(text: impl Into<String>) -> StyledText {
        let mut plain = StyledText {
            text: String::new(),
            spans: Vec::new(),
        };
        plain.push(&text.into(), Style::default());
        plain
    }

    /// Reads markup; `color` reads the value of a colour.
    ///
    /// # Errors
    /// A part that does not end, an attribute that does not exist or whose value cannot be read.
    pub fn parse(
        source: &str,
        color: impl Fn(&str) -> Result<Rgb, String>,
    ) -> Result<StyledText, MarkupError> {
        let mut parsed = StyledText::plain("");
        let mut open = vec![(0, Style::default())];
        let mut at = 0;
        while let Some(c) = source[at..].chars().next() {
            let rest = &source[at..];
            let style = open.last().map_or_else(Style::default, |part| part.1);
            let fail = |found| {
                Err(MarkupError {
                    line: line_of(source, at),
                    found,
                })
            };
            if let Some(escaped) = rest
                .strip_prefix('\\')
                .filter(|r| r.starts_with(['{', '}']))
            {
                parsed.push(&escaped[..1], style);
                at += 2;
            } else if let Some(inside) = rest.strip_prefix('{').filter(|r| begins_part(r)) {
                let Some((attributes, _)) = inside.split_once('|') else {
                    return fail(format!("`{}` has no `|` before its words", shortened(rest)));
                };
                match style.with(attributes, &color) {
                    Ok(style) => open.push((at, style)),
                    Err(found) => return fail(found),
                }
                at += attributes.len() + 2;
            } else if c == '}' && open.len() > 1 {
                open.pop();
                at += 1;
            } else {
                parsed.push(&rest[..c.len_utf8()], style);
                at += c.len_utf8();
            }
        }
        match open[1..] {
            [] => Ok(parsed),
            [.., (start, _)] => Err(MarkupError {
                line: line_of(source, start),
                found: format!("`{}` is not closed by `}}`", shortened(&source[start..])),
            }),
        }
    }

    /// Appends text.
    fn push(&mut self, text: &str, style: Style) {
        let start = self.text.len();
        self.text.push_str(text);
        let end = self.text.len();
        match self.spans.last_mut() {
            Some(last) if last.style == style => last.bytes.end = end,
            _ if text.is_empty() => {}
            _ => self.spans.push(Span {
                bytes: start..end,
                style,
            }),
        }
    }

    /// The paragraphs of the text, without what ends them. The end of the last may be missing, as in files.
    pub fn paragraphs(&self) -> impl Iterator<Item = StyledText> + '_ {
        const ENDS: [char; 6] = ['\n', '\u{b}', '\u{c}', '\u{85}', '\u{2028}', '\u{2029}'];
        self.text.split_inclusive(ENDS).scan(0, |start, line| {
            let words = line.strip_suffix(ENDS).unwrap_or(line);
            let words = words.strip_suffix('\r').unwrap_or(words);
            let part = self.part(*start..*start + words.len());
            *start += line.len();
            Some(part)
        })
    }

    fn part(&self, bytes: Range<usize>) -> StyledText {
        let mut part = StyledText::plain("");
        let first = self.spans.partition_point(|s| s.bytes.end <= bytes.start);
        for span in self.spans[first..]
            .iter()
            .take_while(|s| s.bytes.start < bytes.end)
        {
            let inside = span.bytes.start.max(bytes.start)..span.bytes.end.min(bytes.end);
            part.push(&self.text[inside], span.style);
        }
        part
    }

    /// How the character at a byte looks.
    pub(super) fn style_at(&self, byte: usize) -> Style {
        let after = self.spans.partition_point(|s| s.bytes.end <= byte);
        self.spans
            .get(after)
            .map_or_else(Style::default, |s| s.style)
    }

    /// The bytes at which the size changes.
    pub(super) fn size_changes(&self) -> Vec<usize> {
        let pairs = self.spans.windows(2);
        let changes = pairs.filter(|p| p[0].style.size != p[1].style.size);
        changes.map(|p| p[1].bytes.start).collect()
    }
}

impl Style {
    /// The style with other attributes, `size=1.5 color=#c00`.
    fn with(
        mut self,
        attributes: &str,
        color: &impl Fn(&str) -> Result<Rgb, String>,
    ) -> Result<Style, String> {
        for attribute in attributes.split_whitespace() {
            let (name, value) = attribute.split_once('=').unwrap_or((attribute, ""));
            match name {
                "size" => {
                    let size = value.parse().ok();
                    let size = size.filter(|s| (1.0 / LARGEST..=LARGEST).contains(s));
                    let expected = "expected a multiple of the font size, as in size=1.5";
                    self.size = size.ok_or_else(|| format!("`{attribute}`: {expected}"))?;
                }
                "color" => {
                    let color = color(value).map_err(|e| format!("`{attribute}`: {e}"))?;
                    self.color = Some(color);
                }
                _ => {
                    let expected = "expected size=1.5 or color=#c00, or `\\{` for a brace";
                    return Err(format!("`{attribute}`: {expected}"));
                }
            }
        }
        Ok(self)
    }
}

/// Whether what follows a brace is an attribute: the letters of a name, and an equals sign.
fn begins_part(text: &str) -> bool {
    let behind = text.trim_start_matches(|c: char| c.is_ascii_lowercase());
    behind.len() < text.len() && behind.starts_with('=')
}

fn line_of(text: &str, byte: usize) -> usize {
    1 + text[..byte].matches('\n').count()
}

/// The start of a text, for messages.
fn shortened(text: &str) -> String {
    const SHOWN: usize = 24;
    let line = text.lines().next().unwrap_or_default();
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(source: &str) -> Result<StyledText, MarkupError> {
        StyledText::parse(source, |value| match value {
            "red" => Ok(Rgb::new(1.0, 0.0, 0.0)),
            _ => Err("expected red".to_owned()),
        })
    }

    fn parts(source: &str) -> Vec<(String, f64, bool)> {
        let styled = parse(source).unwrap();
        let part = |s: &Span| {
            let text = styled.text[s.bytes.clone()].to_owned();
            (text, s.style.size, s.style.color.is_some())
        };
        styled.spans.iter().map(part).collect()
    }

    #[test]
    fn parts_have_sizes_and_colors() {
        let plain = |text: &str| vec![(text.to_owned(), 1.0, false)];
        assert_eq!(parts(""), []);
        for braces in ["{a}", "a } b {", "{x|y}", "{}", "C:\\n", "{ size=2|b}"] {
            assert_eq!(parts(braces), plain(braces));
        }
        assert_eq!(parts("\\{size=2|b\\}"), plain("{size=2|b}"));
        let expected = [("a ", 1.0, false), ("b", 1.5, true), (" c", 1.0, false)];
        let expected = expected.map(|(t, s, c)| (t.to_owned(), s, c));
        assert_eq!(parts("a {size=1.5 color=red|b} c"), expected);
        // A part inside of another keeps what it does not change, and | and = are letters as others.
        let expected = [("a|=", 2.0, false), ("}", 2.0, true), ("c", 2.0, false)];
        let expected = expected.map(|(t, s, c)| (t.to_owned(), s, c));
        assert_eq!(parts("{size=2|a|={color=red|\\}}c}"), expected);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let check = |source: &str, line: usize, found: &str| {
            let error = parse(source).unwrap_err();
            assert_eq!(error.line, line, "{error}");
            assert!(error.found.contains(found), "{error}");
        };
        check("a\n{size=2|b", 2, "`{size=2|b` is not closed by `}`");
        check("{size=0|b}", 1, "`size=0`: expected a multiple");
        check("{size=nan|b}", 1, "`size=nan`");
        check("{size=1e9|b}", 1, "`size=1e9`");
        check("\n\n{color=blue|b}", 3, "`color=blue`: expected red");
        check("{colour=red|b}", 1, "`colour=red`: expected size=1.5");
        check("{size=2 bold|b}", 1, "`bold`");
        check("{size=2 b}", 1, "has no `|`");
    }

    #[test]
    fn paragraphs_keep_their_styles() {
        let styled = parse("a {size=2|b\r\nc\n\nd} e\n").unwrap();
        let found: Vec<(String, usize)> = styled
            .paragraphs()
            .map(|p| (p.text, p.spans.len()))
            .collect();
        let expected = [("a b", 2), ("c", 1), ("", 0), ("d e", 2)];
        assert_eq!(found, expected.map(|(t, n)| (t.to_owned(), n)));
        let last = styled.paragraphs().last().unwrap();
        assert_eq!((last.style_at(0).size, last.style_at(1).size), (2.0, 1.0));
        assert_eq!(last.size_changes(), [1]);
    }
}
