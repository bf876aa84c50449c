//! Where the values of a JSON text stand.
//!
//! Edits keep every byte that they don't mean, so they need positions, which parsed JSON no longer has.
//! The text has been parsed before: here only strings and brackets are followed, and a text that is not
//! JSON gives no positions, or wrong ones within the text.

use std::ops::Range;

/// The bytes of a value in its text.
pub type Span = Range<usize>;

/// A member of an object.
#[derive(Debug)]
pub struct Member {
    /// Its name, without escapes.
    pub key: String,
    /// Its bytes, from the quotation mark of the name to the end of the value.
    pub span: Span,
    /// The bytes of the value.
    pub value: Span,
}

/// The value that a text consists of.
pub fn whole(text: &str) -> Span {
    let start = skip_blank(text.as_bytes(), 0);
    start..text.trim_end_matches(is_blank).len().max(start)
}

/// The members of an object in the order of the text; `None` for other values.
pub fn members(text: &str, object: &Span) -> Option<Vec<Member>> {
    let bytes = text.as_bytes().get(..object.end)?;
    let mut at = opened(bytes, object, b'{')?;
    let mut list = Vec::new();
    while bytes.get(at) == Some(&b'"') {
        let start = at;
        at = value_end(bytes, at);
        let name = text.get(start..at)?;
        at = skip_blank(bytes, at);
        if bytes.get(at) != Some(&b':') {
            return None;
        }
        let value = skip_blank(bytes, at + 1);
        at = value_end(bytes, value);
        list.push(Member {
            key: unescaped(name)?,
            span: start..at,
            value: value..at,
        });
        at = after_comma(bytes, at);
    }
    Some(list)
}

/// The elements of a list; `None` for other values.
pub fn elements(text: &str, list: &Span) -> Option<Vec<Span>> {
    let bytes = text.as_bytes().get(..list.end)?;
    let mut at = opened(bytes, list, b'[')?;
    let mut spans = Vec::new();
    while bytes.get(at).is_some_and(|b| *b != b']') {
        let end = value_end(bytes, at);
        if end == at {
            return None;
        }
        spans.push(at..end);
        at = after_comma(bytes, end);
    }
    Some(spans)
}

/// The value of a member. Of several of one name the last counts, as for most parsers.
pub fn member(text: &str, object: &Span, key: &str) -> Option<Span> {
    let members = members(text, object)?.into_iter();
    Some(members.rev().find(|m| m.key == key)?.value)
}

/// The member of a member of ... an object.
pub fn find(text: &str, from: &Span, keys: &[&str]) -> Option<Span> {
    let first = from.clone();
    keys.iter()
        .try_fold(first, |span, key| member(text, &span, key))
}

/// The text of a JSON string.
pub fn string(text: &str, span: &Span) -> Option<String> {
    unescaped(text.get(span.clone())?)
}

/// A value as a whole number.
pub fn number(text: &str, span: &Span) -> Option<usize> {
    let number = text.get(span.clone())?;
    let plain = number.parse().ok();
    // Some writers give indices a fraction of zero.
    plain.or_else(|| {
        serde_json::from_str::<serde_json::Value>(number)
            .ok()?
            .as_f64()
            .and_then(whole_of)
    })
}

fn whole_of(value: f64) -> Option<usize> {
    let is_whole = value >= 0.0 && value.fract() == 0.0 && value < 2f64.powi(53);
    is_whole.then_some(value as usize)
}

fn unescaped(string: &str) -> Option<String> {
    match string.strip_prefix('"')?.strip_suffix('"')? {
        plain if !plain.contains('\\') => Some(plain.to_owned()),
        _ => serde_json::from_str(string).ok(),
    }
}

fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\r' | '\n')
}

fn skip_blank(bytes: &[u8], from: usize) -> usize {
    let rest = bytes.get(from..).unwrap_or_default();
    from + rest.iter().take_while(|b| is_blank(**b as char)).count()
}

/// The first item after an opening bracket.
fn opened(bytes: &[u8], span: &Span, bracket: u8) -> Option<usize> {
    (bytes.get(span.start) == Some(&bracket)).then(|| skip_blank(bytes, span.start + 1))
}

fn after_comma(bytes: &[u8], at: usize) -> usize {
    let at = skip_blank(bytes, at);
    match bytes.get(at) {
        Some(b',') => skip_blank(bytes, at + 1),
        _ => at,
    }
}

/// The end of the value that begins at `start`.
fn value_end(bytes: &[u8], start: usize) -> usize {
    match bytes.get(start) {
        Some(b'"') => string_end(bytes, start),
        Some(b'{' | b'[') => nested_end(bytes, start),
        _ => {
            let rest = bytes.get(start..).unwrap_or_default();
            let ends = |b: &u8| matches!(b, b',' | b']' | b'}') || is_blank(*b as char);
            start + rest.iter().position(ends).unwrap_or(rest.len())
        }
    }
}

fn string_end(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while let Some(b) = bytes.get(at) {
        match b {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}

fn nested_end(bytes: &[u8], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0usize);
    while let Some(b) = bytes.get(at) {
        match b {
            b'"' => {
                at = string_end(bytes, at);
                continue;
            }
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth -= 1,
            _ => {}
        }
        at += 1;
        if depth == 0 {
            return at;
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        " {\r\n \"a\" : [ 1, -0.0,{\"]\":\"}\\\"\"} , [] ],\"\\u0062\":{},\"b\" :\"\u{e9}\" }\n";

    #[test]
    fn values_and_their_places() {
        let root = whole(TEXT);
        assert_eq!(&TEXT[root.clone()][..1], "{");
        assert!(TEXT[root.clone()].ends_with('}'));
        let keys = members(TEXT, &root).unwrap();
        let keys: Vec<&str> = keys.iter().map(|m| m.key.as_str()).collect();
        assert_eq!(keys, ["a", "b", "b"]);
        let list = member(TEXT, &root, "a").unwrap();
        let parts = elements(TEXT, &list).unwrap();
        let parts: Vec<&str> = parts.into_iter().map(|s| &TEXT[s]).collect();
        assert_eq!(parts, ["1", "-0.0", "{\"]\":\"}\\\"\"}", "[]"]);
        let third = &elements(TEXT, &list).unwrap()[2];
        let deep = find(TEXT, third, &["]"]).unwrap();
        assert_eq!(string(TEXT, &deep).unwrap(), "}\"");
        let last = member(TEXT, &root, "b").unwrap();
        assert_eq!(&TEXT[last], "\"\u{e9}\"");
        assert!(members(TEXT, &list).is_none());
        assert!(elements(TEXT, &root).is_none());
    }

    #[test]
    fn numbers() {
        let check = |text: &str, expected| assert_eq!(number(text, &whole(text)), expected);
        check("7", Some(7));
        check("7.0", Some(7));
        check("7.5", None);
        check("-1", None);
        check("\"7\"", None);
    }

    #[test]
    fn texts_that_end_early() {
        for end in 0..TEXT.len() {
            let Some(text) = TEXT.get(..end) else {
                continue;
            };
            let root = whole(text);
            if let Some(list) = member(text, &root, "a") {
                elements(text, &list);
            }
        }
    }
}
