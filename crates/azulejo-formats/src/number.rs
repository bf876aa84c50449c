//! Decimal numbers from bytes, fast where that is exact.

/// Powers of ten that are exact in `f64`.
const EXACT_TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A number at the start of some bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Number {
    /// Its value, correctly rounded; infinite when the exponent is too large.
    pub value: f64,
    /// How many bytes it took.
    pub length: usize,
    /// Whether it was spelled `3.1+e2`, the exponent's sign before its letter.
    pub misplaced_sign: bool,
}

/// The run of digits at `at`: appends them to `mantissa` and returns where they end.
///
/// The mantissa wraps on overflow; the caller counts digits before it trusts it.
#[inline]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
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

/// Reads the decimal number at the start of `bytes`: optional sign, digits with an optional
/// point among, before or behind them, optional exponent. `None` when there is none.
///
/// Up to 15 digits and powers of ten up to 22 are one exact product or quotient of two exact
/// numbers, hence correctly rounded (Clinger, *How to read floating point numbers accurately*,
/// PLDI 1990). The rest goes through the standard library.
#[inline]
pub(crate) fn parse(bytes: &[u8]) -> Option<Number> {
    let signed = matches!(bytes.first(), Some(b'+' | b'-'));
    let start = usize::from(signed);
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
    let significand = end;
    let mut power = -(fraction as i64);
    let mut misplaced_sign = false;
    if let Some(e) = exponent(&bytes[end..]) {
        power += e.value;
        end += e.length;
        misplaced_sign = e.misplaced_sign;
    }
    let value = if count <= 15 && power.unsigned_abs() <= 22 {
        let (m, ten) = (mantissa as f64, EXACT_TENS[power.unsigned_abs() as usize]);
        let v = if power < 0 { m / ten } else { m * ten };
        if bytes[0] == b'-' { -v } else { v }
    } else {
        slow(&bytes[..significand], power + fraction as i64)?
    };
    Some(Number {
        value,
        length: end,
        misplaced_sign,
    })
}

struct Exponent {
    value: i64,
    length: usize,
    misplaced_sign: bool,
}

/// The exponent at the start of `bytes`: `e5`, `E-5`, or by a common slip `-e5`.
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
    // More digits than this are zero or infinity whatever they are.
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
