//! Numbers, points and colours, with arithmetic.

use super::ScnResult;
use super::colors::ColorNames;
use super::tokens::{ScnToken, ScnTokenKind};
use crate::ReadError;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::sff::document::{SffPosition, SffSources};
use azulejo_scene::Rgb;
use glam::DVec3;

/// Maximum depth of parentheses.
const DEEPEST: usize = 64;

/// Largest magnitude of a value.
const LARGEST: f64 = 1e30;

/// The remaining tokens.
pub(super) struct TokenStream<'t> {
    tokens: &'t [ScnToken],
    at: usize,
    pub sources: &'t SffSources<'t>,
    pub warnings: &'t mut Warnings,
    colors: ColorNames,
    depth: usize,
}

impl<'t> TokenStream<'t> {
    pub fn new(
        tokens: &'t [ScnToken],
        sources: &'t SffSources<'t>,
        warnings: &'t mut Warnings,
    ) -> TokenStream<'t> {
        TokenStream {
            tokens,
            at: 0,
            sources,
            warnings,
            colors: ColorNames::new(),
            depth: 0,
        }
    }

    /// The position of the next token, or of the last one at the end.
    pub fn place(&self) -> SffPosition {
        let next = self.tokens.get(self.at).or(self.tokens.last());
        next.map_or(SffPosition::default(), |t| t.place)
    }

    /// Number of remaining tokens.
    pub fn left(&self) -> usize {
        self.tokens.len() - self.at
    }

    fn kind(&self) -> Option<ScnTokenKind> {
        self.tokens.get(self.at).map(|t| t.kind)
    }

    /// The next token if it is a word; it is not consumed.
    pub fn peek_word(&self) -> Option<&'t str> {
        match self.kind() {
            Some(ScnTokenKind::Word(span)) => Some(span.of(self.sources)),
            _ => None,
        }
    }

    /// The next token if it is a word.
    pub fn word(&mut self) -> Option<&'t str> {
        let word = self.peek_word();
        self.at += usize::from(word.is_some());
        word
    }

    /// Consumes a word if it is one of these.
    pub fn take(&mut self, words: &[&str]) -> bool {
        let is_taken = self.peek_word().is_some_and(|w| words.contains(&w));
        self.at += usize::from(is_taken);
        is_taken
    }

    fn take_sign(&mut self, sign: u8) -> bool {
        let is_taken = self.kind() == Some(ScnTokenKind::Sign(sign));
        self.at += usize::from(is_taken);
        is_taken
    }

    /// An error about the next token.
    pub fn unexpected(&self, expected: &str) -> ReadError {
        let found = match self.kind() {
            None => "the end of the file".to_owned(),
            Some(ScnTokenKind::Number(v)) => format!("the number {v}"),
            Some(ScnTokenKind::Word(span)) => format!("\"{}\"", shortened(span.of(self.sources))),
            Some(ScnTokenKind::Sign(sign)) => format!("\"{}\"", char::from(sign)),
        };
        self.sources.error(self.place(), found, expected)
    }

    /// An error at a position.
    pub fn error(&self, place: SffPosition, found: impl Into<String>, expected: &str) -> ReadError {
        self.sources.error(place, found, expected)
    }

    pub fn warn(&mut self, place: SffPosition, message: impl Into<String>) {
        let sources = self.sources;
        let position = || sources.position(place);
        let name = sources.name(place.file);
        self.warnings.add(name, message.into(), position);
    }

    /// Whether a number follows.
    pub fn real_follows(&self) -> bool {
        match self.kind() {
            Some(ScnTokenKind::Number(_)) => true,
            Some(ScnTokenKind::Sign(sign)) => matches!(sign, b'(' | b'-' | b'+'),
            Some(ScnTokenKind::Word(_)) => {
                let word = self.peek_word().unwrap_or_default();
                FUNCTIONS.contains(&word) || word == "dotvector"
            }
            None => false,
        }
    }

    /// Whether a point follows.
    pub fn point_follows(&self) -> bool {
        let word = self.peek_word();
        self.real_follows() || word.is_some_and(|w| VECTORS.contains(&w))
    }

    /// Whether a colour follows.
    pub fn color_follows(&self) -> bool {
        let named = |w: &str| w == "mono" || self.colors.get(w).is_some();
        self.real_follows() || self.peek_word().is_some_and(named)
    }

    /// Reads a number; operators may occur in parentheses only.
    pub fn real(&mut self) -> ScnResult<f64> {
        let place = self.place();
        let value = self.nested(Self::signed)?;
        if value.abs() <= LARGEST {
            return Ok(value);
        }
        Err(self.error(
            place,
            format!("the value {value}"),
            "a number with a magnitude of at most 1e30",
        ))
    }

    /// Calls a rule one level deeper.
    fn nested<T>(&mut self, rule: fn(&mut Self) -> ScnResult<T>) -> ScnResult<T> {
        if self.depth == DEEPEST {
            let found = format!("parentheses more than {DEEPEST} deep");
            return Err(self.error(self.place(), found, "fewer"));
        }
        self.depth += 1;
        let result = rule(self);
        self.depth -= 1;
        result
    }

    fn signed(&mut self) -> ScnResult<f64> {
        match self.kind() {
            Some(ScnTokenKind::Number(value)) => {
                self.at += 1;
                Ok(value)
            }
            Some(ScnTokenKind::Sign(b'(')) => self.parenthesis(),
            Some(ScnTokenKind::Sign(b'-')) => {
                self.at += 1;
                Ok(-self.nested(Self::signed)?)
            }
            Some(ScnTokenKind::Sign(b'+')) => {
                self.at += 1;
                self.nested(Self::signed)
            }
            _ => self.function(),
        }
    }

    fn parenthesis(&mut self) -> ScnResult<f64> {
        self.expect(b'(')?;
        let value = self.nested(Self::sum)?;
        self.expect(b')')?;
        Ok(value)
    }

    fn expect(&mut self, sign: u8) -> ScnResult<()> {
        if self.take_sign(sign) {
            return Ok(());
        }
        Err(self.unexpected(&format!("\"{}\"", char::from(sign))))
    }

    fn sum(&mut self) -> ScnResult<f64> {
        let mut value = self.product()?;
        loop {
            if self.take_sign(b'+') {
                value += self.product()?;
            } else if self.take_sign(b'-') {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> ScnResult<f64> {
        let mut value = self.power()?;
        loop {
            if self.take_sign(b'*') {
                value *= self.power()?;
            } else if self.take_sign(b'/') {
                value /= self.power()?;
            } else if self.take_sign(b'|') {
                value = value.round() % self.power()?.round();
            } else {
                return Ok(value);
            }
        }
    }

    fn power(&mut self) -> ScnResult<f64> {
        if self.take_sign(b'-') {
            return Ok(-self.nested(Self::power)?);
        }
        let base = self.nested(Self::signed)?;
        if self.take_sign(b'^') {
            return Ok(base.powf(self.nested(Self::power)?));
        }
        Ok(base)
    }

    fn function(&mut self) -> ScnResult<f64> {
        let name = self.peek_word().unwrap_or_default();
        let known = FUNCTIONS.contains(&name) || name == "dotvector";
        if !known {
            return Err(self.unexpected("a number"));
        }
        self.at += 1;
        if name == "dotvector" {
            let (a, b) = self.pair(Self::point)?;
            return Ok(a.dot(b));
        }
        if matches!(name, "max" | "min") {
            let (a, b) = self.pair(Self::sum)?;
            return Ok(if name == "max" { a.max(b) } else { a.min(b) });
        }
        let x = self.parenthesis()?;
        Ok(match name {
            "int" => x.trunc(),
            "sin" => x.sin(),
            "cos" => x.cos(),
            "tan" => x.tan(),
            "asin" => x.asin(),
            "acos" => x.acos(),
            "atan" => x.atan(),
            "sqrt" => x.sqrt(),
            "rtod" => x.to_degrees(),
            "dtor" => x.to_radians(),
            "exp" => x.exp(),
            "log" => x.ln(),
            _ => x.abs(),
        })
    }

    fn pair<A>(&mut self, rule: fn(&mut Self) -> ScnResult<A>) -> ScnResult<(A, A)> {
        self.expect(b'(')?;
        let first = self.nested(rule)?;
        self.expect(b',')?;
        let second = self.nested(rule)?;
        self.expect(b')')?;
        Ok((first, second))
    }

    /// Reads three numbers, or a function that returns a point.
    pub fn point(&mut self) -> ScnResult<DVec3> {
        let name = self.peek_word().unwrap_or_default();
        if !VECTORS.contains(&name) {
            return Ok(DVec3::new(self.real()?, self.real()?, self.real()?));
        }
        let place = self.place();
        self.at += 1;
        let result = match name {
            "scalevector" => {
                self.expect(b'(')?;
                let v = self.nested(Self::point)?;
                self.expect(b',')?;
                let k = self.nested(Self::sum)?;
                self.expect(b')')?;
                k * v
            }
            "normvector" => {
                self.expect(b'(')?;
                let v = self.nested(Self::point)?;
                self.expect(b')')?;
                v.normalize()
            }
            _ => {
                let (a, b) = self.pair(Self::point)?;
                match name {
                    "addvector" => a + b,
                    "diffvector" => a - b,
                    _ => a.cross(b),
                }
            }
        };
        if result.abs().max_element() <= LARGEST {
            return Ok(result);
        }
        Err(self.error(
            place,
            format!("{name} without a finite value"),
            "vectors for which it is defined",
        ))
    }

    /// Reads a point that is a direction.
    pub fn vector(&mut self) -> ScnResult<DVec3> {
        let place = self.place();
        let v = self.point()?;
        if v.normalize_or_zero() != DVec3::ZERO {
            return Ok(v);
        }
        Err(self.error(place, "a vector of length 0", "a direction"))
    }

    /// Reads a positive number.
    pub fn positive(&mut self, what: &str) -> ScnResult<f64> {
        let place = self.place();
        let value = self.real()?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(self.error(place, format!("{what} {value}"), "a positive number"))
    }

    /// Reads a number and clamps it to a range, with a warning.
    pub fn within(&mut self, low: f64, high: f64, what: &str) -> ScnResult<f64> {
        let place = self.place();
        let value = self.real()?;
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        self.warn(place, format!("{what} outside {low}..{high}: clamped"));
        Ok(value.clamp(low, high))
    }

    /// Reads a colour with any values.
    pub fn wide_color(&mut self) -> ScnResult<Rgb> {
        if self.take(&["mono"]) {
            return Ok(Rgb::grey(self.real()?));
        }
        if let Some(color) = self.peek_word().and_then(|w| self.colors.get(w)) {
            self.at += 1;
            return Ok(color);
        }
        if !self.real_follows() {
            let expected = "a colour: three numbers, mono and one number, or a name";
            return Err(self.unexpected(expected));
        }
        Ok(Rgb::new(self.real()?, self.real()?, self.real()?))
    }

    /// Reads a colour in 0..=1.
    pub fn color(&mut self) -> ScnResult<Rgb> {
        let place = self.place();
        let color = self.wide_color()?;
        let limited = color.map(|c| c.clamp(0.0, 1.0));
        if limited != color {
            self.warn(place, "colour outside 0..1: clamped");
        }
        Ok(limited)
    }

    /// Reads a file name, which contains a dot.
    pub fn file_name(&mut self) -> ScnResult<String> {
        match self.peek_word() {
            Some(name) if name.contains('.') => {
                self.at += 1;
                Ok(name.to_owned())
            }
            _ => Err(self.unexpected("a file name that contains a dot")),
        }
    }

    /// Reads a file name, if one follows.
    pub fn file_name_if_any(&mut self) -> String {
        let named = self.peek_word().is_some_and(|w| w.contains('.'));
        if named {
            self.word().unwrap_or_default().to_owned()
        } else {
            String::new()
        }
    }
}

/// Functions that return a number, except for the one with two vectors.
const FUNCTIONS: [&str; 15] = [
    "int", "sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "rtod", "dtor", "exp", "log",
    "abs", "max", "min",
];

/// Functions that return a point.
const VECTORS: [&str; 5] = [
    "addvector",
    "diffvector",
    "scalevector",
    "crossvector",
    "normvector",
];
