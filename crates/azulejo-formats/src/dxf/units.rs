//! The length of a unit of the drawing.

use super::record::Record;

/// Metres per unit, by the variables of the header.
///
/// $INSUNITS names the unit. If it does not, architectural and engineering lengths ($LUNITS 4 and
/// 3) are feet and inches with the inch as unit. $MEASUREMENT only chooses between patterns
/// for inches and for millimetres, and does not define a unit.
pub(super) fn metres_per_unit(header: &Record) -> Option<f64> {
    const INCH: f64 = 0.0254;
    let named = integer(header, b"$INSUNITS").and_then(metres);
    let shown_in_feet = matches!(integer(header, b"$LUNITS"), Some(3 | 4));
    named.or(shown_in_feet.then_some(INCH))
}

/// A variable of the header: its name is a group 9, its value the next.
fn integer(header: &Record, name: &[u8]) -> Option<i64> {
    let is_name = |at: &usize| {
        let pair = &header.pairs[*at];
        pair.code == 9 && pair.value.text() == name
    };
    let at = (0..header.pairs.len()).find(is_name)?;
    header.whole(header.pairs.get(at + 1)?.value)
}

/// The length of a unit of $INSUNITS; `None` for 0, which means no unit.
fn metres(unit: i64) -> Option<f64> {
    /// The survey foot of the United States.
    const SURVEY_FOOT: f64 = 1200.0 / 3937.0;
    const LENGTHS: [f64; 24] = [
        0.0254,
        0.3048,
        1609.344,
        1e-3,
        1e-2,
        1.0,
        1e3,
        0.0254e-6,
        0.0254e-3,
        0.9144,
        1e-10,
        1e-9,
        1e-6,
        0.1,
        10.0,
        100.0,
        1e9,
        149_597_870_700.0,
        9.460_730_472_580_8e15,
        3.085_677_581_491_367e16,
        SURVEY_FOOT,
        SURVEY_FOOT / 12.0,
        SURVEY_FOOT * 3.0,
        SURVEY_FOOT * 5280.0,
    ];
    let index = usize::try_from(unit.checked_sub(1)?).ok()?;
    LENGTHS.get(index).copied()
}

#[cfg(test)]
mod tests {
    use super::super::record::Records;
    use super::*;

    fn check(variables: &str, expected: Option<f64>) {
        let text = format!("0\nSECTION\n2\nHEADER\n{variables}0\nEOF\n");
        let mut header = Record::default();
        assert!(Records::new(text.as_bytes()).read(&mut header));
        assert_eq!(metres_per_unit(&header), expected, "{variables}");
    }

    #[test]
    fn lengths() {
        check("", None);
        check("9\n$MEASUREMENT\n70\n1\n", None);
        check("9\n$INSUNITS\n70\n0\n", None);
        check("9\n$INSUNITS\n70\n1\n", Some(0.0254));
        check(
            "9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n     4\n",
            Some(1e-3),
        );
        check("9\n$INSUNITS\n70\n6\n9\n$LUNITS\n70\n4\n", Some(1.0));
        check("9\n$INSUNITS\n70\n24\n", Some(6_336_000.0 / 3937.0));
        check("9\n$INSUNITS\n70\n25\n9\n$LUNITS\n70\n4\n", Some(0.0254));
        check("9\n$LUNITS\n70\n2\n", None);
        check("9\n$INSUNITS\n", None);
    }
}
