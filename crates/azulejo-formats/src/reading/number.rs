//! Decimal numbers from bytes.

/// A number at the start of some bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Number {
    /// Its value, correctly rounded; infinite if the exponent is too large.
    pub value: f64,
    /// Number of bytes consumed.
    pub length: usize,
    /// Whether it was written like `3.1+e2`, with the exponent's sign before the letter.
    pub misplaced_sign: bool,
}

/// Reads the decimal number at the start of `bytes`: optional sign, digits with an optional
/// decimal point among, before or after them, optional exponent. `None` if there is none.
///
/// Correctly rounded: Lemire, *Number parsing at a gigabyte per second*, Software: Practice and
/// Experience 51(8), 2021.
#[inline]
pub(crate) fn parse(bytes: &[u8]) -> Option<Number> {
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    // Without infinities and NaN, which the library reads, too.
    let first = bytes.get(start)?;
    if !first.is_ascii_digit() && *first != b'.' {
        return None;
    }
    let (value, length) = fast_float2::parse_partial(bytes).ok()?;
    if matches!(bytes[length..], [b'+' | b'-', b'e' | b'E', b'0'..=b'9', ..])
        && let Some(number) = with_misplaced_sign(bytes, length)
    {
        return Some(number);
    }
    Some(Number {
        value,
        length,
        misplaced_sign: false,
    })
}

/// The number of this length and its exponent, whose sign precedes its letter: `3.1+e2`.
#[cold]
fn with_misplaced_sign(bytes: &[u8], length: usize) -> Option<Number> {
    let digits = &bytes[length + 2..];
    let digits = digits.iter().take_while(|b| b.is_ascii_digit());
    let mut text = [&bytes[..length], &[b'e', bytes[length]]].concat();
    text.extend(digits);
    let value = fast_float2::parse(&text).ok()?;
    Some(Number {
        value,
        length: text.len(),
        misplaced_sign: true,
    })
}

/// What C libraries print for values that are not finite: `nan`, `-nan(ind)`, `1.#QNAN`, `inf`.
#[cold]
pub(crate) fn non_finite(word: &[u8]) -> Option<f64> {
    let word = word.to_ascii_lowercase();
    let unsigned = word.iter().position(|b| !matches!(b, b'+' | b'-'));
    match &word[unsigned?..] {
        bare if bare.starts_with(b"nan") || bare.starts_with(b"1.#") => Some(f64::NAN),
        b"inf" | b"infinity" => Some(f64::INFINITY),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(text: &str, expected: Option<(f64, usize)>) {
        let number = parse(text.as_bytes()).map(|n| (n.value, n.length));
        assert_eq!(number, expected, "{text}");
    }

    #[test]
    fn every_spelling() {
        check("1", Some((1.0, 1)));
        check("+1.", Some((1.0, 3)));
        check("-.5 ", Some((-0.5, 3)));
        check("-0", Some((-0.0, 2)));
        check("2.e1", Some((20.0, 4)));
        check("3E-2/", Some((0.03, 4)));
        check("3.1+e2", Some((310.0, 6)));
        check("3.1-E2", Some((0.031, 6)));
        check("1e", Some((1.0, 1)));
        check("1-2", Some((1.0, 1)));
        check("1e999", Some((f64::INFINITY, 5)));
        check("1e-99999999999999999999", Some((0.0, 23)));
        check("", None);
        check("-", None);
        check(".", None);
        check("e5", None);
        check("nan", None);
    }

    #[test]
    fn digits_of_every_length() {
        for length in 1..40usize {
            for tail in ["", " ", "x", "\u{ff}", "/\u{7f}:", " 1234567"] {
                let digits: String = (0..length)
                    .map(|k| char::from(b"0123456789"[k * 7 % 10]))
                    .collect();
                let text = format!("{digits}{tail}");
                check(&text, Some((digits.parse().unwrap(), length)));
                let text = format!("-12.{digits}{tail}");
                let expected = format!("-12.{digits}").parse().unwrap();
                check(&text, Some((expected, 4 + length)));
            }
        }
    }

    #[test]
    fn a_million_digits_are_one_number() {
        let long = format!("0.{}1", "0".repeat(1_000_000));
        check(&long, Some((0.0, long.len())));
    }

    proptest! {
        #[test]
        fn same_as_the_standard_library(v in prop::num::f64::ANY.prop_filter("finite", |v| v.is_finite())) {
            for text in [format!("{v}"), format!("{v:e}"), format!("{v:.4}")] {
                let expected: f64 = text.parse().unwrap();
                prop_assert_eq!(parse(text.as_bytes()).unwrap().value.to_bits(), expected.to_bits());
            }
        }
    }
}
