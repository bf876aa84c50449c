//! Numbers and names as other programs read them.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};

/// Significant digits of a factor in text, unless a program demands others. Factors by rays have
/// four, closed forms a few more.
pub(super) const DIGITS: usize = 9;

/// C's `%.Ng`: this many digits, the shorter of the two notations, no trailing zeros, and no minus
/// before zero.
pub(crate) fn general(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{x:.*e}", digits - 1);
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        // Infinite, or not a number.
        return scientific;
    };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..digits as i32).contains(&exponent) {
        let places = (digits as i32 - 1 - exponent) as usize;
        return bare(&format!("{x:.places$}")).to_owned();
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", bare(mantissa), exponent.abs())
}

/// A decimal number without trailing zeros.
fn bare(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

/// C's `%.NE` with at least one decimal, as Fortran and Nastran require of a real number.
pub(crate) fn exponential(x: f64, digits: usize) -> String {
    let scientific = format!("{:.*e}", digits - 1, x + 0.0);
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}E{sign}{:02}", exponent.abs())
}

/// Writes words with blanks between them, starting a new line where one would grow beyond `width`.
pub(super) fn wrapped(
    words: impl IntoIterator<Item = String>,
    indent: &str,
    width: usize,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut length = 0;
    for word in words {
        if length > 0 && length + 1 + word.len() > width {
            writeln!(out)?;
            length = 0;
        }
        let before = if length == 0 { indent } else { " " };
        write!(out, "{before}{word}")?;
        length += before.len() + word.len();
    }
    writeln!(out)
}

/// A text between quotation marks, as in JSON.
pub(super) fn json(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c < ' ' => quoted += &format!("\\u{:04x}", c as u32),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// A text inside of XML, in elements and attributes.
pub(super) fn xml(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            // XML has no way to say them.
            c if c < ' ' => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A field of CSV, quoted according to RFC 4180.
pub(crate) fn csv_field(name: &str) -> Cow<'_, str> {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\"")).into()
    } else {
        name.into()
    }
}

/// A text on one line of comment, ASCII and short, whatever it holds.
pub(crate) fn comment(text: &str, length: usize) -> String {
    let printable = |c: char| if (' '..='~').contains(&c) { c } else { '_' };
    text.chars().map(printable).take(length).collect()
}

/// Names as words: whatever is not `allowed` becomes `_`, and words that are equal then, or but for
/// their case, get the row's number.
pub(super) fn words(names: &[Cow<'_, str>], allowed: impl Fn(char) -> bool) -> Vec<String> {
    let word = |name: &Cow<'_, str>| -> String {
        let kept = |c: char| if allowed(c) { c } else { '_' };
        name.chars().map(kept).collect()
    };
    let words: Vec<String> = names.iter().map(word).collect();
    let mut uses: HashMap<String, usize> = HashMap::new();
    for word in &words {
        *uses.entry(word.to_lowercase()).or_default() += 1;
    }
    let rows = words.into_iter().enumerate();
    rows.map(|(i, word)| {
        if word.is_empty() || uses[&word.to_lowercase()] > 1 {
            format!("{word}_{}", i + 1)
        } else {
            word
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_c_prints_them() {
        for (x, digits, expected) in [
            (0.0, 9, "0"),
            (-0.0, 9, "0"),
            (1.0, 9, "1"),
            (0.2, 9, "0.2"),
            (1.0 / 3.0, 9, "0.333333333"),
            (0.1998248, 4, "0.1998"),
            (9.9999, 3, "10"),
            (1234567.0, 6, "1.23457e+06"),
            (0.0001, 9, "0.0001"),
            (0.00001234, 9, "1.234e-05"),
            (1e-300, 9, "1e-300"),
            (f64::INFINITY, 9, "inf"),
        ] {
            assert_eq!(general(x, digits), expected);
        }
        for (x, expected) in [
            (0.2, "2.00000000E-01"),
            (-0.0, "0.00000000E+00"),
            (1234.5, "1.23450000E+03"),
            (1e-300, "1.00000000E-300"),
        ] {
            assert_eq!(exponential(x, 9), expected);
        }
    }

    #[test]
    fn names_become_words_that_differ() {
        let names = ["a b", "A_B", "", "c"].map(Cow::from);
        let words = words(&names, char::is_alphanumeric);
        assert_eq!(words, ["a_b_1", "A_B_2", "_3", "c"]);
        assert_eq!(json("a\"\\\n"), "\"a\\\"\\\\\\u000a\"");
        assert_eq!(xml("<a & \"b\"\u{1}>"), "&lt;a &amp; &quot;b&quot; &gt;");
        assert_eq!(comment("é\nabc", 4), "__ab");
    }

    #[test]
    fn long_lists_are_broken() {
        let mut out = Vec::new();
        let numbers = (98..103).map(|x| x.to_string());
        wrapped(numbers, "  ", 11, &mut out).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), "  98 99 100\n  101 102\n");
    }
}
