//! The keys and values of an extension.

use super::document::{BoxedError, GrfName, NameKind};
use super::parse::BlockEnd;
use super::parser::{GrfParser, ParseResult};
use crate::reading::lexer::Lexer;
use azulejo_scene::Rgb;
use glam::{DAffine3, DVec3};

const EXTENSION: BlockEnd = BlockEnd::required(&["ext"]);

/// What a key may say that an extension need not have.
pub(super) type Taken<T> = ParseResult<Option<T>>;

/// The value of a key.
pub(super) enum EntryValue<'a> {
    Numbers(Vec<f64>),
    Vectors(Vec<[f64; 3]>),
    Words(Vec<&'a str>),
    Text(String),
}

impl EntryValue<'_> {
    /// The map given by twelve numbers, the images of the axes and of the origin.
    pub fn map(&self) -> Option<DAffine3> {
        let EntryValue::Numbers(numbers) = self else {
            return None;
        };
        let columns = <[f64; 12]>::try_from(&numbers[..]).ok()?;
        Some(DAffine3::from_cols_array(&columns))
    }

    fn describe(&self) -> String {
        let (count, what) = match self {
            EntryValue::Numbers(list) => (list.len(), "number"),
            EntryValue::Vectors(list) => (list.len(), "triple"),
            EntryValue::Words(list) => (list.len(), "word"),
            EntryValue::Text(_) => (1, "text"),
        };
        let plural = if count == 1 { "" } else { "s" };
        format!("{count} {what}{plural}")
    }
}

pub(super) struct GrfEntry<'a> {
    pub key: &'a str,
    /// The offset of the value.
    pub offset: usize,
    pub value: EntryValue<'a>,
}

/// The keys and values of one extension, or of one solid in it. Reading a value removes it; what is
/// left at the end is unknown.
pub(super) struct GrfEntries<'a> {
    /// The name of their owner in messages: `ext camera`, in backticks.
    pub title: String,
    pub offset: usize,
    pub list: Vec<GrfEntry<'a>>,
}

impl<'a> GrfEntries<'a> {
    pub fn new(title: impl Into<String>, offset: usize) -> GrfEntries<'a> {
        GrfEntries {
            title: title.into(),
            offset,
            list: Vec::new(),
        }
    }

    pub fn has(&self, key: &str) -> bool {
        self.list.iter().any(|e| e.key.eq_ignore_ascii_case(key))
    }

    pub fn take(&mut self, key: &str) -> Option<GrfEntry<'a>> {
        let at = self
            .list
            .iter()
            .position(|e| e.key.eq_ignore_ascii_case(key))?;
        Some(self.list.remove(at))
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads everything after `begin`, and `end ext`.
    pub fn entries(&mut self, extension: &str, offset: usize) -> ParseResult<GrfEntries<'a>> {
        let mut entries = GrfEntries::new(format!("`ext {extension}`"), offset);
        self.entries_and(&mut entries, |_| Ok(false))?;
        self.end(offset, &EXTENSION)?;
        Ok(entries)
    }

    /// Reads keys with their values, and what `other` reads in between, up to something else.
    pub fn entries_and(
        &mut self,
        entries: &mut GrfEntries<'a>,
        mut other: impl FnMut(&mut Self) -> ParseResult<bool>,
    ) -> ParseResult<()> {
        loop {
            if at_key(self.lexer) {
                let key = self.lexer.word().unwrap_or("");
                self.expect(b'=')?;
                let offset = self.lexer.skip_blank();
                let value = self.value()?;
                entries.list.push(GrfEntry { key, offset, value });
            } else if !other(self)? {
                return Ok(());
            }
        }
    }

    /// Warns about keys that were not used.
    pub fn warn_of_rest(&mut self, entries: &GrfEntries<'_>) {
        for rest in &entries.list {
            self.warn(
                rest.offset,
                format!("{} has no key `{}`: skipped", entries.title, rest.key),
            );
        }
    }

    fn value(&mut self) -> ParseResult<EntryValue<'a>> {
        match self.lexer.peek() {
            Some(b'"') => match self.lexer.escaped_text() {
                Some(text) => Ok(EntryValue::Text(unescaped(text))),
                None => Err(self.unexpected("a string that ends with `\"` on the same line")),
            },
            Some(b'(') => {
                let mut vectors = Vec::new();
                while self.lexer.peek() == Some(b'(') {
                    vectors.push(self.vector3()?.to_array());
                }
                Ok(EntryValue::Vectors(vectors))
            }
            _ if self.lexer.at_number() => {
                let mut numbers = Vec::new();
                while !at_key(self.lexer) && self.lexer.at_number() {
                    numbers.push(self.number()?);
                    self.lexer.eat(b',');
                }
                Ok(EntryValue::Numbers(numbers))
            }
            _ => {
                let mut words = Vec::new();
                while (words.is_empty() || !at_item(self.lexer))
                    && let Some(word) = self.lexer.peek_word()
                    && !word.eq_ignore_ascii_case("end")
                {
                    self.lexer.word();
                    words.push(word);
                }
                if words.is_empty() {
                    return Err(self.unexpected("a number, a vector, a \"text\" or a word"));
                }
                Ok(EntryValue::Words(words))
            }
        }
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    #[cold]
    pub fn wrong(&mut self, entry: &GrfEntry<'_>, expected: &str) -> BoxedError {
        let found = format!("`{}` of {}", entry.key, entry.value.describe());
        self.fail(entry.offset, found, expected)
    }

    pub fn required<T>(
        &mut self,
        entries: &GrfEntries<'_>,
        key: &str,
        value: Option<T>,
    ) -> ParseResult<T> {
        match value {
            Some(value) => Ok(value),
            None => Err(self.fail(
                entries.offset,
                format!("{} without `{key}`", entries.title),
                format!("`{key} = ...` in it"),
            )),
        }
    }

    /// The entry of a key, which must be there.
    pub fn needed(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<GrfEntry<'a>> {
        let entry = entries.take(key);
        self.required(entries, key, entry)
    }

    pub fn take_number(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<(f64, usize)> {
        let Some(entry) = entries.take(key) else {
            return Ok(None);
        };
        match entry.value {
            EntryValue::Numbers(ref n) if n.len() == 1 => Ok(Some((n[0], entry.offset))),
            _ => Err(self.wrong(&entry, "one number")),
        }
    }

    /// An angle in radians, from `key` in degrees or from `key_radians`, which is written if no
    /// number of degrees gives the same bits.
    pub fn take_angle(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<f64> {
        let degrees = self.take_number(entries, key)?;
        let radians = self.take_number(entries, &format!("{key}_radians"))?;
        Ok(radians
            .map(|(r, _)| r)
            .or(degrees.map(|(d, _)| d.to_radians())))
    }

    pub fn take_point(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<DVec3> {
        match entries.take(key) {
            None => Ok(None),
            Some(entry) => match entry.value {
                EntryValue::Vectors(ref v) if v.len() == 1 => Ok(Some(DVec3::from_array(v[0]))),
                _ => Err(self.wrong(&entry, "one vector (x, y, z)")),
            },
        }
    }

    pub fn needed_point(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<DVec3> {
        let point = self.take_point(entries, key)?;
        self.required(entries, key, point)
    }

    /// A unit vector, from one of any length.
    pub fn needed_direction(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<DVec3> {
        let offset = entries.offset;
        let direction = self.needed_point(entries, "direction")?;
        match super::unit(direction) {
            Some(unit) => Ok(unit),
            None => Err(self.fail(offset, "a direction of length 0", "a non-zero vector")),
        }
    }

    pub fn take_rgb(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<Rgb> {
        let Some(entry) = entries.take(key) else {
            return Ok(None);
        };
        let rgb = match &entry.value {
            EntryValue::Vectors(v) if v.len() == 1 => Rgb::from(v[0]),
            EntryValue::Numbers(n) if n.len() == 1 => Rgb::grey(n[0]),
            _ => return Err(self.wrong(&entry, "one number or (r, g, b)")),
        };
        Ok(Some(self.not_negative(entry.offset, rgb)))
    }

    pub fn needed_rgb(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<Rgb> {
        let rgb = self.take_rgb(entries, key)?;
        self.required(entries, key, rgb)
    }

    pub fn take_reflectance(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<Rgb> {
        let offset = entries.offset;
        let rgb = self.take_rgb(entries, key)?;
        if rgb.is_some_and(|c| c.max_channel() > 1.0) {
            self.warn(offset, "reflectance above 1: read as 1");
        }
        Ok(rgb.map(|c| c.map(|x| x.min(1.0))))
    }

    pub fn take_text(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> Taken<String> {
        match entries.take(key) {
            None => Ok(None),
            Some(GrfEntry {
                value: EntryValue::Text(text),
                ..
            }) => Ok(Some(text)),
            Some(entry) => Err(self.wrong(&entry, "a \"text\"")),
        }
    }

    pub fn take_word(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
    ) -> Taken<(&'a str, usize)> {
        match entries.take(key) {
            None => Ok(None),
            Some(entry) => match entry.value {
                EntryValue::Words(ref w) if w.len() == 1 => Ok(Some((w[0], entry.offset))),
                _ => Err(self.wrong(&entry, "one word")),
            },
        }
    }

    pub fn needed_word(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
    ) -> ParseResult<(&'a str, usize)> {
        let word = self.take_word(entries, key)?;
        self.required(entries, key, word)
    }

    /// The value whose word a key has.
    pub fn take_choice<T: Copy>(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        choices: &[(&str, T)],
    ) -> Taken<T> {
        let Some((word, offset)) = self.take_word(entries, key)? else {
            return Ok(None);
        };
        match choices.iter().find(|(name, _)| *name == word) {
            Some((_, value)) => Ok(Some(*value)),
            None => Err(self.fail(offset, format!("`{word}`"), in_words(choices))),
        }
    }

    /// A name that a `def` must have defined.
    pub fn take_name(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        kind: NameKind,
    ) -> Taken<GrfName> {
        let Some((word, offset)) = self.take_word(entries, key)? else {
            return Ok(None);
        };
        let name = self.shared.intern(word);
        self.note_use(offset, kind, &name);
        Ok(Some(name))
    }

    pub fn needed_name(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        kind: NameKind,
    ) -> ParseResult<GrfName> {
        let name = self.take_name(entries, key, kind)?;
        self.required(entries, key, name)
    }
}

/// The words of choices in a message: "`a`, `b` or `c`".
fn in_words<T>(choices: &[(&str, T)]) -> String {
    let words: Vec<String> = choices.iter().map(|(w, _)| format!("`{w}`")).collect();
    match words.split_last() {
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

/// Whether `key =` follows.
fn at_key(mut ahead: Lexer<'_>) -> bool {
    ahead.word().is_some() && ahead.eat(b'=')
}

/// Whether `begin`, `key =`, `member begin` or `glyph (` follows, which ends a list of words.
fn at_item(mut ahead: Lexer<'_>) -> bool {
    ahead.eat_word("begin")
        || ahead.word().is_some() && (ahead.eat(b'=') || ahead.eat(b'(') || ahead.eat_word("begin"))
}

/// Resolves the escapes `\n`, `\r`, `\t` and `\u{hex}`; any other character after a backslash stands
/// for itself.
fn unescaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        if c != '\\' {
            out.push(c);
            continue;
        }
        match rest.next() {
            Some('n') => out.push('\n'),
            Some('r') => out.push('\r'),
            Some('t') => out.push('\t'),
            Some('u') => {
                let digits: String = rest
                    .by_ref()
                    .take_while(|&c| c != '}')
                    .filter(|&c| c != '{')
                    .collect();
                let code = u32::from_str_radix(&digits, 16)
                    .ok()
                    .and_then(char::from_u32);
                out.push(code.unwrap_or(char::REPLACEMENT_CHARACTER));
            }
            Some(other) => out.push(other),
            None => {}
        }
    }
    out
}
