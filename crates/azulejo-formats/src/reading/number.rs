//! Decimal numbers from bytes, with a fast path where that is exact.

/// Powers of ten that are exact in `f64`.
const EXACT_TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

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

/// Appends the run of digits at `at` to `mantissa` and returns the offset of its end.
///
/// The mantissa wraps on overflow; the caller checks the number of digits before using it.
#[inline]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(&eight) = bytes.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        let (value, count) = leading_digits(eight);
        *mantissa = mantissa.wrapping_mul(TENS[count]).wrapping_add(value);
        at += count;
        if count < 8 {
            return at;
        }
    }
    while let Some(d) = bytes
        .get(at)
        .map(|b| b.wrapping_sub(b'0'))
        .filter(|d| *d < 10)
    {
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(d));
        at += 1;
    }
    at
}

const TENS: [u64; 9] = [
    1,
    10,
    100,
    1_000,
    10_000,
    100_000,
    1_000_000,
    10_000_000,
    100_000_000,
];

/// Value and number of the leading digits of eight bytes.
///
/// They are handled all at once, because a branch for every digit costs more than the arithmetic:
/// numbers in files have all lengths. Lemire, *Number parsing at a gigabyte per second* (2021).
#[inline]
fn leading_digits(bytes: [u8; 8]) -> (u64, usize) {
    let digits = u64::from_le_bytes(bytes) ^ 0x3030_3030_3030_3030;
    // The high bit of every byte above 9; a carry reaches only bytes after the first of them.
    let others = (digits.wrapping_add(0x7676_7676_7676_7676) | digits) & 0x8080_8080_8080_8080;
    let count = (others.trailing_zeros() / 8) as usize;
    // Non-digits are shifted out, zeros come before the first digit.
    let Some(v) = digits.checked_shl(64 - 8 * count as u32) else {
        return (0, 0);
    };
    let pairs = (v.wrapping_mul(10) + (v >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100) + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    let value = fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xffff_ffff;
    (value, count)
}

/// Reads the decimal number at the start of `bytes`: optional sign, digits with an optional
/// decimal point among, before or after them, optional exponent. `None` if there is none.
///
/// Up to 15 digits and powers of ten up to 22 are one exact product or quotient of two exact
/// numbers, hence correctly rounded (Clinger, *How to read floating point numbers accurately*,
/// PLDI 1990). Other numbers are converted by the standard library.
#[inline]
pub(crate) fn parse(bytes: &[u8]) -> Option<Number> {
    let sign = bytes.first().copied().unwrap_or_default();
    let start = usize::from(matches!(sign, b'+' | b'-'));
    let mut mantissa = 0;
    let point = digits(bytes, start, &mut mantissa);
    let mut end = point;
    let mut fraction = 0;
    if bytes.get(point) == Some(&b'.') {
        end = digits(bytes, point + 1, &mut mantissa);
        fraction = end - point - 1;
    }
    let count = point - start + fraction;
    if count == 0 {
        return None;
    }
    let more = matches!(bytes.get(end), Some(b'e' | b'E' | b'+' | b'-'));
    if count > 15 || more {
        return long(&bytes[..end], &bytes[end..], mantissa, count, fraction);
    }
    let value = mantissa as f64 / EXACT_TENS[fraction];
    Some(Number {
        value: if sign == b'-' { -value } else { value },
        length: end,
        misplaced_sign: false,
    })
}

/// A number of many digits, or with an exponent in `rest`.
#[inline(never)]
fn long(
    significand: &[u8],
    rest: &[u8],
    mantissa: u64,
    count: usize,
    fraction: usize,
) -> Option<Number> {
    let mut power = -(fraction as i64);
    let mut length = significand.len();
    let mut misplaced_sign = false;
    if let Some(e) = exponent(rest) {
        power += e.value;
        length += e.length;
        misplaced_sign = e.misplaced_sign;
    }
    let value = if count <= 15 && power.unsigned_abs() <= 22 {
        let (m, ten) = (mantissa as f64, EXACT_TENS[power.unsigned_abs() as usize]);
        let v = if power < 0 { m / ten } else { m * ten };
        if significand[0] == b'-' { -v } else { v }
    } else {
        slow(significand, power + fraction as i64)?
    };
    Some(Number {
        value,
        length,
        misplaced_sign,
    })
}

struct Exponent {
    value: i64,
    length: usize,
    misplaced_sign: bool,
}

/// The exponent at the start of `bytes`: `e5`, `E-5`, or by a common mistake `-e5`.
fn exponent(bytes: &[u8]) -> Option<Exponent> {
    let letter = |i: usize| matches!(bytes.get(i), Some(b'e' | b'E'));
    let sign = |i: usize| matches!(bytes.get(i), Some(b'+' | b'-'));
    let misplaced_sign = sign(0) && letter(1);
    if !letter(0) && !misplaced_sign {
        return None;
    }
    let signed_at = if misplaced_sign { 0 } else { 1 };
    let start = if misplaced_sign || sign(1) { 2 } else { 1 };
    let length = start
        + bytes[start..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count();
    if length == start {
        return None;
    }
    // More digits than this mean zero or infinity, whatever they are.
    let magnitude = bytes[start..length]
        .iter()
        .fold(0i64, |e, b| (e * 10 + i64::from(b - b'0')).min(100_000_000));
    let negative = bytes[signed_at] == b'-';
    Some(Exponent {
        value: if negative { -magnitude } else { magnitude },
        length,
        misplaced_sign,
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

/// The standard library's conversion, for long mantissas and large exponents.
#[cold]
fn slow(significand: &[u8], power: i64) -> Option<f64> {
    let digits = std::str::from_utf8(significand).ok()?;
    format!("{digits}e{power}").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(text: &str, expected: Option<(f64, usize)>) {
        let found = parse(text.as_bytes()).map(|n| (n.value, n.length));
        assert_eq!(found, expected, "{text}");
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
