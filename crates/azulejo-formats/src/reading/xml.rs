//! Limits on XML that are checked before it is parsed.
//!
//! The parser compares each attribute of an element with all others of it, and looks a prefix up in the
//! list of all namespaces in scope. Both are quadratic for files that no program writes.

/// Most attributes of an element, namespaces among them.
const MOST_ATTRIBUTES: usize = 1000;

/// Most namespaces that may be in scope at once.
const MOST_NAMESPACES: usize = 256;

/// The first element that the parser would take too long for: its byte, and what is wrong with it.
///
/// Takes linear time. What is not well-formed ends the search; it is up to the parser.
pub(crate) fn crowded_element(text: &str) -> Option<(usize, String)> {
    let bytes = text.as_bytes();
    // Namespaces in scope at each level.
    let (mut scopes, mut at) = (vec![0], 0);
    while let Some(start) = find(bytes, at, b"<") {
        let rest = &bytes[start..];
        let special = [
            (&b"<!--"[..], &b"-->"[..]),
            (b"<![CDATA[", b"]]>"),
            (b"<?", b"?>"),
            (b"<!", b">"),
            (b"</", b">"),
        ];
        if let Some((mark, end)) = special.into_iter().find(|(mark, _)| rest.starts_with(mark)) {
            if mark == b"</" && scopes.len() > 1 {
                scopes.pop();
            }
            at = find(bytes, start + mark.len(), end)? + end.len();
            continue;
        }
        let tag = XmlTag::scan(bytes, start)?;
        if tag.attributes > MOST_ATTRIBUTES {
            let found = format!("an element with more than {MOST_ATTRIBUTES} attributes");
            return Some((start, found));
        }
        let namespaces = scopes.last().map_or(0, |n| n + tag.namespaces);
        if namespaces > MOST_NAMESPACES {
            let found = format!("an element in more than {MOST_NAMESPACES} namespaces");
            return Some((start, found));
        }
        if !tag.is_closed {
            scopes.push(namespaces);
        }
        at = tag.end;
    }
    None
}

/// The place of `what` from `at` on.
fn find(bytes: &[u8], at: usize, what: &[u8]) -> Option<usize> {
    let rest = bytes.get(at..)?;
    let distance = rest.windows(what.len()).position(|w| w == what);
    distance.map(|step| at + step)
}

/// The start of an element.
struct XmlTag {
    /// The byte behind it.
    end: usize,
    attributes: usize,
    /// Attributes that declare one.
    namespaces: usize,
    /// Whether the element has no content.
    is_closed: bool,
}

impl XmlTag {
    /// The tag that starts at a byte; `None` if it does not end.
    fn scan(bytes: &[u8], start: usize) -> Option<XmlTag> {
        let mut tag = XmlTag {
            end: start,
            attributes: 0,
            namespaces: 0,
            is_closed: false,
        };
        let mut at = start + 1;
        // The start of the last word outside of quotes.
        let mut word = at;
        loop {
            match *bytes.get(at)? {
                b'>' => {
                    tag.is_closed = bytes[at - 1] == b'/';
                    tag.end = at + 1;
                    return Some(tag);
                }
                quote @ (b'"' | b'\'') => {
                    tag.attributes += 1;
                    tag.namespaces += usize::from(bytes[word..at].starts_with(b"xmlns"));
                    at = find(bytes, at + 1, &[quote])?;
                    word = at + 1;
                }
                c if c.is_ascii_whitespace() => {
                    let next = bytes.get(at + 1)?;
                    if !next.is_ascii_whitespace() && !matches!(next, b'=' | b'"' | b'\'') {
                        word = at + 1;
                    }
                }
                b'<' => return None,
                _ => {}
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expected: Option<(usize, &str)>) {
        let crowded = crowded_element(text);
        let crowded = crowded.as_ref().map(|(at, what)| (*at, &**what));
        assert_eq!(crowded, expected, "{}", &text[..text.len().min(80)]);
    }

    fn attributes(range: std::ops::Range<usize>, prefix: &str) -> String {
        range.map(|k| format!(" {prefix}{k} = '<\"x='")).collect()
    }

    #[test]
    fn attributes_of_one_element_are_counted() {
        let most = attributes(0..1000, "a");
        check(&format!("<a{most}/><b{most}>{most}</b>"), None);
        let words = "an element with more than 1000 attributes";
        check(&format!("<a/><b{most} c=''/>"), Some((4, words)));
        check(&format!("<a{most}><b{most} c=''"), None);
    }

    #[test]
    fn namespaces_in_scope_are_counted() {
        let (some, more) = (attributes(0..200, "xmlns:a"), attributes(0..56, "xmlns:b"));
        check(&format!("<a{some}><b{more}/><b{more}></b><c{more}/>"), None);
        let words = "an element in more than 256 namespaces";
        let text = format!("<a{some}><b{more}>");
        check(&format!("{text}<c xmlns='x'/>"), Some((text.len(), words)));
        check(&format!("{text}<c yxmlns='x'/></b><c xmlns='x'/>"), None);
    }

    #[test]
    fn what_is_no_element_is_passed() {
        let most = attributes(0..1001, "a");
        for (start, end) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")] {
            let text = format!("<a>{start} <b{most}/> {end}<c/>");
            let words = "an element with more than 1000 attributes";
            check(&text, None);
            let at = text.len();
            check(&format!("{text}<b{most}/>"), Some((at, words)));
        }
        check("<!DOCTYPE X3D PUBLIC \"a\" \"b\"><X3D", None);
        check("<", None);
        check("<a b='", None);
    }

    /// A million elements, and one that does not end.
    #[test]
    fn the_search_is_linear() {
        check(&"<a b=''>".repeat(1_000_000), None);
        check(&format!("<a{}", " '".repeat(3_000_000)), None);
        check(&"<!-- ".repeat(1_000_000), None);
        check(&"<a <".repeat(1_000_000), None);
    }
}
