//! Numbers as programs in Fortran write and read them.

use super::number;

/// A real number; the letter of its exponent may be a D, or left out (`1.5-3`). Blank is none.
pub(crate) fn real(field: &[u8]) -> Option<f64> {
    let plain = number::parse(field)?;
    let value = if plain.length == field.len() && !plain.misplaced_sign {
        plain.value
    } else {
        spelled(field)?
    };
    value.is_finite().then_some(value)
}

/// A number whose exponent is spelled as only Fortran does.
fn spelled(field: &[u8]) -> Option<f64> {
    let mut text = Vec::with_capacity(field.len() + 1);
    for &byte in field {
        let byte = if matches!(byte, b'd' | b'D') {
            b'e'
        } else {
            byte
        };
        let is_exponent = matches!(byte, b'+' | b'-') && !text.is_empty();
        if is_exponent && !matches!(text.last(), Some(b'e' | b'E')) {
            text.push(b'e');
        }
        text.push(byte);
    }
    let number = number::parse(&text)?;
    (number.length == text.len() && !number.misplaced_sign).then_some(number.value)
}

/// An integer of at most nine digits, without a sign; those are all that identify something.
pub(crate) fn identifier(field: &[u8]) -> Option<u32> {
    let field = field.strip_prefix(b"+").unwrap_or(field);
    let is_number = !field.is_empty() && field.len() <= 9 && field.iter().all(u8::is_ascii_digit);
    is_number.then(|| (field.iter()).fold(0, |n, digit| 10 * n + u32::from(digit - b'0')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_reals() {
        for (text, expected) in [
            ("1.5-3", Some(1.5e-3)),
            ("-1.5+3", Some(-1500.0)),
            ("+.5-10", Some(0.5e-10)),
            ("2.D2", Some(200.0)),
            ("2.d-2", Some(0.02)),
            ("7.0E+1", Some(70.0)),
            ("3", Some(3.0)),
            ("1.-", None),
            ("1.5--3", None),
            ("1.5e", None),
            ("1+2+3", None),
            ("1.0+999", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(real(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn identifiers_are_whole() {
        for (text, expected) in [
            ("12", Some(12)),
            ("+7", Some(7)),
            ("999999999", Some(999_999_999)),
            ("1000000000", None),
            ("-1", None),
            ("1.", None),
            ("", None),
        ] {
            assert_eq!(identifier(text.as_bytes()), expected, "{text}");
        }
    }
}
