//! The inline codes of MTEXT: AutoCAD's *DXF Reference*, "Paragraph text formatting".

/// How letters look.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LetterStyle {
    /// Height of capital letters.
    pub height: f64,
    /// Their width, as a share of what the font has.
    pub width: f64,
    /// By how much they lean, degrees.
    pub oblique: f64,
    /// Distance between letters, as a share of what the font has.
    pub tracking: f64,
    /// The family, and whether it is bold and italic, unless it is that of the style.
    pub font: Option<(String, [bool; 2])>,
}

impl Default for LetterStyle {
    fn default() -> LetterStyle {
        LetterStyle {
            height: 1.0,
            width: 1.0,
            oblique: 0.0,
            tracking: 1.0,
            font: None,
        }
    }
}

/// Letters of one style, without a place where a line may end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StyledLetters {
    /// Their style.
    pub style: LetterStyle,
    /// What they say: `[text]`, or two texts one above the other.
    pub texts: Vec<String>,
}

/// What a line is made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// Letters.
    Text(StyledLetters),
    /// A blank, where a line may end.
    Blank(LetterStyle),
    /// The end of a paragraph.
    Break,
}

/// Deepest nesting of braces.
const DEEPEST: usize = 64;

/// The tokens of a text in the style of its entity.
pub(super) fn tokens(text: &str, style: LetterStyle) -> Vec<Token> {
    let mut reader = CodeReader {
        rest: text,
        style,
        outer: Vec::new(),
        word: String::new(),
        tokens: Vec::new(),
    };
    while let Some(c) = reader.next() {
        reader.character(c);
    }
    reader.end_word();
    reader.tokens
}

struct CodeReader<'t> {
    rest: &'t str,
    style: LetterStyle,
    /// The styles outside of the braces.
    outer: Vec<LetterStyle>,
    /// Letters since the last change.
    word: String,
    tokens: Vec<Token>,
}

impl<'t> CodeReader<'t> {
    fn next(&mut self) -> Option<char> {
        let c = self.rest.chars().next()?;
        self.rest = &self.rest[c.len_utf8()..];
        Some(c)
    }

    fn end_word(&mut self) {
        if !self.word.is_empty() {
            let texts = vec![std::mem::take(&mut self.word)];
            let style = self.style.clone();
            self.tokens
                .push(Token::Text(StyledLetters { style, texts }));
        }
    }

    fn push(&mut self, token: Token) {
        self.end_word();
        self.tokens.push(token);
    }

    fn character(&mut self, c: char) {
        match c {
            '\\' => self.code(),
            '{' if self.outer.len() < DEEPEST => {
                self.end_word();
                self.outer.push(self.style.clone());
            }
            '}' => {
                self.end_word();
                self.style = self.outer.pop().unwrap_or(self.style.clone());
            }
            ' ' | '\t' => self.push(Token::Blank(self.style.clone())),
            '^' => match self.next() {
                Some('J') => self.push(Token::Break),
                Some('I') => self.push(Token::Blank(self.style.clone())),
                Some('M') | None => {}
                Some(' ') => self.word.push('^'),
                Some(other) => self.word.extend(['^', other]),
            },
            '\n' | '\r' => {}
            c => self.word.push(c),
        }
    }

    /// What follows a backslash.
    fn code(&mut self) {
        match self.next() {
            Some('P' | 'X' | 'N') => self.push(Token::Break),
            Some('~') => self.word.push('\u{a0}'),
            Some(c @ ('\\' | '{' | '}')) => self.word.push(c),
            Some('S') => self.stack(),
            // Lines under, over and through letters, which stay out, as do colours and paragraphs.
            Some('L' | 'l' | 'O' | 'o' | 'K' | 'k') | None => {}
            Some('C' | 'c' | 'A' | 'p') => _ = self.argument(),
            Some(c @ ('H' | 'W' | 'Q' | 'T' | 'F' | 'f')) => {
                self.end_word();
                let argument = self.argument();
                self.set(c, argument);
            }
            Some(other) => self.word.extend(['\\', other]),
        }
    }

    /// What is before the next semicolon.
    fn argument(&mut self) -> &'t str {
        let (argument, rest) = self.rest.split_once(';').unwrap_or((self.rest, ""));
        self.rest = rest;
        argument.trim()
    }

    fn set(&mut self, code: char, argument: &str) {
        let (number, is_share) = match argument.strip_suffix(['x', 'X']) {
            Some(number) => (number, true),
            None => (argument, false),
        };
        let number = number.trim().parse().ok().filter(|x: &f64| x.is_finite());
        let positive = number.filter(|x| *x > 0.0);
        let style = &mut self.style;
        match code {
            'H' if is_share => style.height *= positive.unwrap_or(1.0),
            'H' => style.height = positive.unwrap_or(style.height),
            'W' if is_share => style.width *= positive.unwrap_or(1.0),
            'W' => style.width = positive.unwrap_or(style.width),
            'T' => style.tracking = positive.unwrap_or(style.tracking),
            'Q' => style.oblique = number.unwrap_or(style.oblique),
            _ => {
                let mut parts = argument.split('|');
                let family = parts.next().unwrap_or_default().to_owned();
                let rest: Vec<&str> = parts.collect();
                let looks = ["b1", "i1"].map(|look| rest.contains(&look));
                style.font = (!family.is_empty()).then_some((family, looks));
            }
        }
    }

    /// Two texts, one above the other: `1/2`, `1#2`, or `+0.1^-0.2`.
    fn stack(&mut self) {
        self.end_word();
        let mut texts = vec![String::new()];
        while let Some(c) = self.next() {
            match c {
                ';' => break,
                '\\' => texts
                    .last_mut()
                    .into_iter()
                    .for_each(|t| t.extend(self.next())),
                '/' | '#' | '^' if texts.len() == 1 => texts.push(String::new()),
                c => texts.last_mut().into_iter().for_each(|t| t.push(c)),
            }
        }
        let texts = texts.iter().map(|t| t.trim().to_owned()).collect();
        let style = self.style.clone();
        self.tokens
            .push(Token::Text(StyledLetters { style, texts }));
    }
}

/// Text with the control codes that all texts have: `%%c`, `%%d`, `%%p`, numbers, and `\U+2205`.
pub(super) fn decoded_codes(text: &str) -> String {
    let mut decoded = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let (sign, length) = sign(rest).unwrap_or((Some(c), c.len_utf8()));
        decoded.extend(sign);
        rest = &rest[length..];
    }
    decoded
}

/// The code at the start of a text: its sign, if it has one, and its bytes.
fn sign(text: &str) -> Option<(Option<char>, usize)> {
    if let Some(hex) = text.strip_prefix("\\U+").and_then(|t| t.get(..4)) {
        let code = u32::from_str_radix(hex, 16).ok()?;
        return Some((Some(char::from_u32(code)?), 7));
    }
    let code = text.strip_prefix("%%")?;
    if let Some(number) = code.get(..3).and_then(|digits| digits.parse::<u8>().ok()) {
        return Some((Some(char::from(number)), 5));
    }
    let sign = match code.chars().next()?.to_ascii_lowercase() {
        'c' => Some('Ø'),
        'd' => Some('°'),
        'p' => Some('±'),
        '%' => Some('%'),
        // Lines under, over and through what follows.
        'u' | 'o' | 'k' => None,
        _ => return None,
    };
    Some((sign, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words with their heights, `|` at the ends of paragraphs, `_` for blanks.
    fn shown(text: &str) -> String {
        let shown = |token: &Token| match token {
            Token::Text(StyledLetters { style, texts }) => {
                format!("{}@{}", texts.join("/"), style.height)
            }
            Token::Blank(_) => "_".to_owned(),
            Token::Break => "|".to_owned(),
        };
        let shown: Vec<String> = tokens(text, LetterStyle::default())
            .iter()
            .map(shown)
            .collect();
        shown.join(" ")
    }

    #[test]
    fn codes_change_the_style_within_their_braces() {
        assert_eq!(shown("a b\\Pc"), "a@1 _ b@1 | c@1");
        assert_eq!(shown("{\\H2;big}small"), "big@2 small@1");
        assert_eq!(shown("{\\H0.5x;{\\H0.5x;a}b}c"), "a@0.25 b@0.5 c@1");
        assert_eq!(shown("x\\S1/2;y"), "x@1 1/2@1 y@1");
        assert_eq!(shown("\\S+0.1^ -0.2;"), "+0.1/-0.2@1");
        assert_eq!(
            shown("\\A1;\\C3;\\Lline\\l \\pxqc;\\~"),
            "line@1 _ \u{a0}@1"
        );
        assert_eq!(shown("\\\\ \\{ \\}^I^J"), "\\@1 _ {@1 _ }@1 _ |");
        assert_eq!(shown("}}a"), "a@1");
        assert_eq!(shown("\\H"), "");
        let tokens = tokens(
            "\\fArial|b1|i0|c0|p34;\\W0.8;\\Q15;\\T2;a",
            LetterStyle::default(),
        );
        let Token::Text(StyledLetters { style, .. }) = &tokens[0] else {
            panic!("{tokens:?}");
        };
        let expected = LetterStyle {
            height: 1.0,
            width: 0.8,
            oblique: 15.0,
            tracking: 2.0,
            font: Some(("Arial".into(), [true, false])),
        };
        assert_eq!(*style, expected);
    }

    #[test]
    fn control_codes_are_signs() {
        assert_eq!(decoded_codes("%%c20 %%p0.1 45%%D %%%"), "Ø20 ±0.1 45° %");
        assert_eq!(
            decoded_codes("%%uline%%u %%065 \\U+00e9 \\U+zz"),
            "line A é \\U+zz"
        );
        assert_eq!(decoded_codes("%%x 5%%"), "%%x 5%%");
    }
}
