//! Replacements in a text that is kept otherwise.

use std::ops::Range;

/// A replacement of a part of a text.
#[derive(Debug)]
pub(super) struct TextEdit {
    pub range: Range<usize>,
    pub text: String,
}

/// The line end that a text uses.
pub(super) fn line_end(text: &str) -> &'static str {
    match text.find(['\n', '\r']) {
        Some(at) if text[at..].starts_with("\r\n") => "\r\n",
        Some(at) if text[at..].starts_with('\r') => "\r",
        _ => "\n",
    }
}

/// Where a line can be added behind a statement that ends at `end`: behind a comment beside it.
/// Also whether more follows there.
pub(super) fn end_of_statement(text: &str, end: usize) -> (usize, bool) {
    let line = text[end..].find(['\n', '\r']);
    let rest = line.map_or(&text[end..], |n| &text[end..end + n]);
    let is_over = rest.trim_start().is_empty() || rest.trim_start().starts_with("//");
    if is_over {
        (end + rest.len(), false)
    } else {
        (end, true)
    }
}

/// The end of the blanks on a line.
pub(super) fn after_blank(text: &str, from: usize) -> usize {
    let rest = &text[from..];
    from + rest.len() - rest.trim_start_matches([' ', '\t']).len()
}

/// A text with replacements, which are in ascending order and do not overlap.
pub(super) fn edited(text: &str, edits: &[TextEdit]) -> String {
    let added: usize = edits.iter().map(|e| e.text.len()).sum();
    let mut out = String::with_capacity(text.len() + added);
    let mut done = 0;
    for edit in edits {
        out.push_str(&text[done..edit.range.start]);
        out.push_str(&edit.text);
        done = edit.range.end;
    }
    out.push_str(&text[done..]);
    out
}
