//! JSON as a text that is walked in place: members in the order of the file, each with its offset,
//! and nothing copied.
//!
//! The syntax is checked once, before anything is read; afterwards values are found by counting
//! brackets. Nothing here recurses, so that nesting cannot overflow the stack.

use super::cursor::TextCursor;
use crate::ReadError;
use serde_json::value::RawValue;
use std::borrow::Cow;

/// A value in a text whose syntax has been checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Json<'a> {
    text: &'a str,
    start: usize,
    end: usize,
}

/// The values of a text, one after another: one in most files, one per line in sequences.
///
/// # Errors
/// Malformed JSON, with line and column; no value at all.
pub(crate) fn values<'a>(text: &'a str, file: &str) -> Result<Vec<Json<'a>>, ReadError> {
    let mut stream = serde_json::Deserializer::from_str(text).into_iter::<&RawValue>();
    let mut values = Vec::new();
    let mut behind = 0;
    while let Some(value) = stream.next() {
        let value = value.map_err(|error| malformed(&error, text, behind, file))?;
        let end = stream.byte_offset();
        let start = end - value.get().len();
        values.push(Json { text, start, end });
        behind = end;
    }
    if values.is_empty() {
        let whole = ReadError::whole(file, "no JSON value", "an object in braces");
        return Err(whole);
    }
    Ok(values)
}

/// The error for malformed JSON. Its position counts from the start of the text for the first value,
/// and in streams as well.
fn malformed(error: &serde_json::Error, text: &str, behind: usize, file: &str) -> ReadError {
    let message = error.to_string();
    let why = message.split(" at line ").next().unwrap_or_default();
    let found = format!("malformed JSON ({why})");
    let (line, column) = (error.line(), error.column());
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines
        .by_ref()
        .take(line.saturating_sub(1))
        .map(str::len)
        .sum();
    let mut offset = before
        + column
            .saturating_sub(1)
            .min(lines.next().map_or(0, str::len));
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let offset = offset.max(behind);
    TextCursor::<[u8]>::new(text.as_bytes()).error(file, offset, found, "well-formed JSON")
}

impl<'a> Json<'a> {
    /// The text of the value.
    pub fn get(self) -> &'a str {
        &self.text[self.start..self.end]
    }

    /// The offset of its first byte in the whole text.
    pub fn at(self) -> usize {
        self.start
    }

    fn begins_with(self, byte: u8) -> bool {
        self.text.as_bytes().get(self.start) == Some(&byte)
    }

    /// Whether it is an array.
    pub fn is_array(self) -> bool {
        self.begins_with(b'[')
    }

    /// Whether it is an object.
    pub fn is_object(self) -> bool {
        self.begins_with(b'{')
    }

    /// The elements of an array; none of anything else.
    pub fn elements(self) -> impl Iterator<Item = Json<'a>> {
        let mut parts = JsonParts::of(self, self.is_array());
        std::iter::from_fn(move || parts.value())
    }

    /// The members of an object with their names, in their order; none of anything else.
    pub fn members(self) -> impl Iterator<Item = (Cow<'a, str>, Json<'a>)> {
        let mut parts = JsonParts::of(self, self.is_object());
        std::iter::from_fn(move || Some((parts.value()?.string()?, parts.value()?)))
    }

    /// The member of an object with a name, the last one if there are several.
    pub fn member(self, name: &str) -> Option<Json<'a>> {
        let members = self.members().filter(|(key, _)| key == name);
        members.last().map(|(_, value)| value)
    }

    /// The value of a number, finite.
    pub fn number(self) -> Option<f64> {
        let number: Option<f64> = serde_json::from_str(self.get()).ok();
        number.filter(|x| x.is_finite())
    }

    /// The value of a non-negative integer.
    pub fn index(self) -> Option<usize> {
        self.get().parse().ok()
    }

    /// The content of a string without its escapes. A surrogate without its pair becomes U+FFFD.
    pub fn string(self) -> Option<Cow<'a, str>> {
        let inner = self.get().strip_prefix('"')?.strip_suffix('"')?;
        if !inner.contains('\\') {
            return Some(Cow::Borrowed(inner));
        }
        let resolved = serde_json::from_str(self.get());
        Some(Cow::Owned(
            resolved.unwrap_or_else(|_| inner.replace("\\u", "\u{fffd}")),
        ))
    }

    /// Three numbers.
    pub fn triple(self) -> Option<[f64; 3]> {
        let mut elements = self.elements();
        let mut next = || elements.next()?.number();
        let numbers = [next()?, next()?, next()?];
        elements.next().is_none().then_some(numbers)
    }
}

/// The values inside of an array or object, names of members included.
struct JsonParts<'a> {
    text: &'a str,
    at: usize,
    end: usize,
}

impl<'a> JsonParts<'a> {
    /// What is between the brackets of a value, or nothing.
    fn of(value: Json<'a>, has_parts: bool) -> JsonParts<'a> {
        JsonParts {
            text: value.text,
            at: value.start + 1,
            end: if has_parts { value.end - 1 } else { 0 },
        }
    }

    fn value(&mut self) -> Option<Json<'a>> {
        let bytes = self.text.as_bytes();
        let is_between = |b: u8| b.is_ascii_whitespace() || matches!(b, b',' | b':');
        while self.at < self.end && is_between(bytes[self.at]) {
            self.at += 1;
        }
        if self.at >= self.end {
            return None;
        }
        let start = self.at;
        self.at = value_end(bytes, start, self.end);
        Some(Json {
            text: self.text,
            start,
            end: self.at,
        })
    }
}

/// The end of the value that begins at `start` in well-formed JSON.
fn value_end(bytes: &[u8], start: usize, end: usize) -> usize {
    let mut at = start;
    let mut depth = 0usize;
    while at < end {
        match bytes[at] {
            b'"' => at = string_end(bytes, at),
            b'{' | b'[' => {
                depth += 1;
                at += 1;
            }
            b'}' | b']' => {
                depth = depth.saturating_sub(1);
                at += 1;
            }
            // A number or a word ends where something else begins.
            _ if depth == 0 => {
                let ends = |b: &u8| b.is_ascii_whitespace() || matches!(b, b',' | b'}' | b']');
                let length = bytes[at..end].iter().position(ends);
                return length.map_or(end, |length| at + length);
            }
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at.min(end)
}

/// The byte behind the string that begins at `start`.
fn string_end(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while at < bytes.len() && bytes[at] != b'"' {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Position;

    fn only(text: &str) -> Json<'_> {
        values(text, "a").unwrap()[0]
    }

    #[test]
    fn members_and_elements_in_order() {
        let text = r#" { "b" : [1, "x,]", {"c": [ ]}, null ] , "a":-2.5e1,"\u0061":true} "#;
        let object = only(text);
        let members: Vec<_> = object
            .members()
            .map(|(n, v)| (n.into_owned(), v.get()))
            .collect();
        assert_eq!(
            members[0],
            ("b".to_owned(), r#"[1, "x,]", {"c": [ ]}, null ]"#)
        );
        assert_eq!(
            members[1..],
            [("a".to_owned(), "-2.5e1"), ("a".to_owned(), "true")]
        );
        let elements: Vec<_> = object
            .member("b")
            .unwrap()
            .elements()
            .map(Json::get)
            .collect();
        assert_eq!(elements, ["1", r#""x,]""#, r#"{"c": [ ]}"#, "null"]);
        assert_eq!(object.member("a").unwrap().get(), "true");
        assert_eq!(object.member("b").unwrap().at(), text.find('[').unwrap());
        assert!(object.elements().next().is_none() && only("[1]").members().next().is_none());
    }

    #[test]
    fn scalars() {
        assert_eq!(only("-2.5e1").number(), Some(-25.0));
        assert_eq!(only("1e999").number(), None);
        assert_eq!(
            (only("17").index(), only("-1").index(), only("1.0").index()),
            (Some(17), None, None)
        );
        assert_eq!(only(r#""a\n\"b""#).string().unwrap(), "a\n\"b");
        assert_eq!(only(r#""\ud800!""#).string().unwrap(), "\u{fffd}d800!");
        assert_eq!(only("7").string(), None);
        assert_eq!(only("[1, 2,3]").triple(), Some([1.0, 2.0, 3.0]));
        assert_eq!(
            (only("[1,2]").triple(), only("[1,2,3,4]").triple()),
            (None, None)
        );
    }

    #[test]
    fn sequences_and_deep_nesting() {
        let objects = values("{\"a\":1}\n{\"a\":2}\r\n\n", "a").unwrap();
        let numbers: Vec<_> = objects
            .iter()
            .map(|v| v.member("a").unwrap().number())
            .collect();
        assert_eq!(numbers, [Some(1.0), Some(2.0)]);
        let deep = format!("[{}{}, 5]", "[".repeat(200_000), "]".repeat(200_000));
        assert_eq!(only(&deep).elements().last().unwrap().index(), Some(5));
    }

    #[test]
    fn positions_of_errors() {
        let check = |text: &str, line: u32, column: u32| {
            let error = values(text, "a.json").unwrap_err();
            assert_eq!(error.position, Position::Line(line, column), "{error}");
        };
        check("{\n \"a\": x}", 2, 7);
        check("{\"a\":1}\n{\"a\":", 2, 5);
        assert_eq!(values(" ", "a").unwrap_err().position, Position::Whole);
    }

    /// Whatever precedes the damage: no prefix of a value may panic.
    #[test]
    fn every_prefix() {
        let text = r#"{"a":[1,"\u00e9\\",{"b":null}],"c":-1.5e3}"#;
        for end in 0..text.len() {
            assert!(values(&text[..end], "a").is_err(), "{end}");
        }
    }
}
