//! Input of programs that compute with finite elements or volumes.

/// Whether the first line that is not a comment is a keyword with which input of Abaqus or CalculiX begins.
pub(super) fn is_abaqus<'a>(lines: impl Iterator<Item = &'a [u8]>) -> bool {
    const FIRST: [&[u8]; 17] = [
        b"HEADING",
        b"NODE",
        b"ELEMENT",
        b"PART",
        b"ASSEMBLY",
        b"INCLUDE",
        b"PREPRINT",
        b"PARAMETER",
        b"RESTART",
        b"SYSTEM",
        b"MATERIAL",
        b"NSET",
        b"ELSET",
        b"SURFACE",
        b"AMPLITUDE",
        b"PHYSICAL CONSTANTS",
        b"USER MATERIAL",
    ];
    let mut lines = lines.filter(|line| !line.starts_with(b"**"));
    let Some(keyword) = lines.next().and_then(|line| line.strip_prefix(b"*")) else {
        return false;
    };
    let keyword = keyword.split(|&b| b == b',').next().unwrap_or_default();
    let keyword = keyword.trim_ascii().to_ascii_uppercase();
    FIRST.contains(&keyword.as_slice())
}

/// Whether a file begins with the header of OpenFOAM, behind the comments of C++.
pub(super) fn is_foam(head: &[u8]) -> bool {
    let mut rest = head.trim_ascii_start();
    loop {
        let behind = match rest {
            [b'/', b'*', comment @ ..] => {
                let end = comment.windows(2).position(|w| w == b"*/");
                end.map(|end| &comment[end + 2..])
            }
            [b'/', b'/', comment @ ..] => {
                let end = comment.iter().position(|&b| b == b'\n');
                end.map(|end| &comment[end + 1..])
            }
            _ => break,
        };
        match behind {
            Some(behind) => rest = behind.trim_ascii_start(),
            None => return false,
        }
    }
    let word = rest.strip_prefix(b"FoamFile").map(<[u8]>::trim_ascii_start);
    word.is_some_and(|behind| behind.starts_with(b"{"))
}

/// Whether a line is a card of NASTRAN that mesh files have: a grid point, an element or a coordinate
/// system with its number, in columns or between commas. Prose has neither.
pub(super) fn is_card(line: &[u8]) -> bool {
    const CARDS: [&[u8]; 21] = [
        b"GRID", b"CTRIA3", b"CTRIA6", b"CTRIAR", b"CQUAD4", b"CQUAD8", b"CQUADR", b"CTETRA",
        b"CHEXA", b"CPENTA", b"CPYRAM", b"CHBDYG", b"CHBDYE", b"CORD1R", b"CORD1C", b"CORD1S",
        b"CORD2R", b"CORD2C", b"CORD2S", b"PSHELL", b"PSOLID",
    ];
    let end = |b: &u8| matches!(b, b',' | b'*' | b' ' | b'\t');
    let name = line.split(end).next().unwrap_or_default();
    if !CARDS.contains(&name.to_ascii_uppercase().as_slice()) {
        return false;
    }
    let is_number = |field: &[u8]| {
        let field = field.trim_ascii();
        !field.is_empty() && field.iter().all(u8::is_ascii_digit)
    };
    let rest = &line[name.len()..];
    let rest = rest.strip_prefix(b"*").unwrap_or(rest);
    match rest.first() {
        Some(b',') => {
            let mut fields = rest[1..].split(|&b| b == b',');
            fields.next().is_some_and(is_number) && fields.next().is_some()
        }
        Some(b'\t') => rest[1..]
            .split(|&b| b == b'\t')
            .next()
            .is_some_and(is_number),
        _ => {
            let width = if line[..line.len().min(8)].contains(&b'*') {
                16
            } else {
                8
            };
            line.len() > 8 + width && is_number(&line[8..8 + width])
        }
    }
}
