//! PPE: the glyph names of a font by character code, one `code/name` per line.

use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{ReadError, Warning};
use azulejo_scene::Encoding;
use std::io::{self, Write};

/// The largest code: Unicode's last code point. RTRACE's own go up to 255.
const LARGEST: u32 = 0x10_ffff;

/// Reads an encoding. `name` is used in messages.
///
/// Blanks around the slash and at both ends of a line are ignored. Extensions beyond RTRACE: empty
/// lines, a last line without an end, comments from `#` to the end of the line (after a name, a
/// blank must precede it), and codes of all characters. If several lines have the same code, the
/// last one is used, with a warning.
///
/// # Errors
/// A malformed line.
pub fn read(bytes: &[u8], name: &str) -> Result<(Encoding, Vec<Warning>), ReadError> {
    let bytes = &*decoded(bytes);
    let mut words = Words::new(bytes, name);
    let mut encoding = Encoding::default();
    let mut warnings = Warnings::default();
    while !words.at_end() {
        words.skip_spaces();
        let at = words.offset();
        let line = without_remark(words.rest_of_line());
        if line.is_empty() {
            continue;
        }
        let Some((code, glyph)) = entry(line) else {
            let found = format!("\"{}\"", shortened(&text(line)));
            return Err(words.error_with(at, found, EXPECTED));
        };
        let before = encoding.names.insert(code, glyph.clone());
        if before.is_some_and(|b| b != glyph) {
            let message = format!("code {code} again: the last name is used");
            warnings.add(name, message, || words.position(at));
        }
    }
    Ok((encoding, warnings.finish(name)))
}

const EXPECTED: &str = "a character code, \"/\" and a glyph name, as in 65/A";

fn without_remark(line: &[u8]) -> &[u8] {
    let begins = |i: usize| line[i] == b'#' && (i == 0 || line[i - 1].is_ascii_whitespace());
    let end = (0..line.len()).find(|&i| begins(i));
    line[..end.unwrap_or(line.len())].trim_ascii()
}

fn entry(line: &[u8]) -> Option<(u32, String)> {
    let slash = line.iter().position(|&b| b == b'/')?;
    let digits = line[..slash].trim_ascii_end();
    let name = line[slash + 1..].trim_ascii();
    let code = std::str::from_utf8(digits).ok()?.parse().ok()?;
    let is_good = code <= LARGEST && digits[0] != b'+' && !name.is_empty();
    is_good.then(|| (code, text(name).into_owned()))
}

/// Writes an encoding so that [`read`] returns the same.
///
/// # Errors
/// Those of the writer, and [`io::ErrorKind::InvalidInput`] for what cannot be represented: codes
/// beyond Unicode, and names that are empty or contain blanks or control characters.
pub fn write(encoding: &Encoding, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    for (code, name) in &encoding.names {
        if *code > LARGEST || name.is_empty() || name.bytes().any(|b| b <= b' ') {
            let message = format!("PPE cannot represent the code {code} with the name \"{name}\"");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        writeln!(out, "{code}/{name}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(bytes: &[u8]) -> Vec<(u32, String)> {
        let (encoding, warnings) = read(bytes, "a.ppe").unwrap();
        assert_eq!(warnings, []);
        encoding.names.into_iter().collect()
    }

    #[test]
    fn lines_in_all_their_forms() {
        let check = |bytes: &[u8], expected: &[(u32, &str)]| {
            let expected: Vec<_> = expected.iter().map(|&(c, n)| (c, n.to_owned())).collect();
            assert_eq!(names(bytes), expected, "{}", bytes.escape_ascii());
        };
        check(b"", &[]);
        check(b"65/A\n64/at", &[(64, "at"), (65, "A")]);
        check(
            b"\xef\xbb\xbf65 / A \t\r\n  \r\n064/at\r",
            &[(64, "at"), (65, "A")],
        );
        check(
            b"# ASCII\n35/#\n 33/exclam # !\n",
            &[(33, "exclam"), (35, "#")],
        );
        check(b"47//\n9786/smile/y\n", &[(47, "/"), (9786, "smile/y")]);
        check(b"233/\xe9\n", &[(233, "é")]);
    }

    #[test]
    fn other_lines_are_errors() {
        let check = |bytes: &[u8], message: &str| {
            let error = read(bytes, "a.ppe").unwrap_err().to_string();
            let start = error.lines().next().unwrap();
            assert_eq!(start, format!("a.ppe:{message}, expected {EXPECTED}"));
        };
        check(b"65/A\n\n 66 B\n", "3:2: found \"66 B\"");
        check(b"65/", "1:1: found \"65/\"");
        check(b"/A", "1:1: found \"/A\"");
        check(b"x41/A", "1:1: found \"x41/A\"");
        check(b"+5/A", "1:1: found \"+5/A\"");
        check(b"1114112/A", "1:1: found \"1114112/A\"");
        check(b"65 # /A", "1:1: found \"65\"");
    }

    #[test]
    fn the_last_name_is_used() {
        let (encoding, warnings) = read(b"65/A\n65/Alpha\n65/Alpha\n", "a.ppe").unwrap();
        assert_eq!(encoding.names[&65], "Alpha");
        let messages: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            ["a.ppe:2:1: code 65 again: the last name is used"]
        );
    }

    #[test]
    fn written_encodings_are_read_back() {
        let names = [(0, "a"), (35, "#"), (47, "/"), (0x10_ffff, "Ünï")];
        let encoding = Encoding {
            names: names.map(|(c, n)| (c, n.to_owned())).into(),
        };
        let mut bytes = Vec::new();
        write(&encoding, &mut bytes).unwrap();
        assert_eq!(read(&bytes, "a.ppe"), Ok((encoding, Vec::new())));
    }

    #[test]
    fn unrepresentable_names_are_refused() {
        for (code, name) in [(65, ""), (65, "a b"), (65, "a\n"), (0x11_0000, "A")] {
            let names = [(code, name.to_owned())].into();
            assert!(
                write(&Encoding { names }, &mut Vec::new()).is_err(),
                "{name:?}"
            );
        }
    }
}
