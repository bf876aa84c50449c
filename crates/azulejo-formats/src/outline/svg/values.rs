//! Numbers, lengths, transforms and colours in SVG syntax.

use crate::picture::srgb::linear_from_srgb_f64;
use azulejo_scene::Rgb;
use glam::{DAffine2, DVec2};
use roxmltree::Node;
use svgtypes::{Color, Length, LengthUnit, NumberListParser, Transform};

/// Larger numbers are damage, and their squares could overflow.
pub(super) const LARGEST: f64 = 1e30;

/// Numbers separated by blanks and commas up to the first error, and whether there is one.
pub(super) fn numbers(text: &str) -> (Vec<f64>, bool) {
    let mut numbers = Vec::new();
    for number in NumberListParser::from(text) {
        match number {
            Ok(number) if number.abs() <= LARGEST => numbers.push(number),
            _ => return (numbers, true),
        }
    }
    (numbers, false)
}

/// A length in SVG's user units, of which there are 96 to the inch, and whether its unit is a physical
/// one. `None` for relative ones.
pub(super) fn length(text: &str) -> Option<(f64, bool)> {
    const PER_INCH: f64 = 96.0;
    let length: Length = text.trim().parse().ok()?;
    let unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::Pt => PER_INCH / 72.0,
        LengthUnit::Pc => PER_INCH / 6.0,
        LengthUnit::Mm => PER_INCH / 25.4,
        LengthUnit::Cm => PER_INCH / 2.54,
        LengthUnit::In => PER_INCH,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return None,
    };
    let value = length.number * unit;
    let is_physical = !matches!(length.unit, LengthUnit::None | LengthUnit::Px);
    (value.abs() <= LARGEST).then_some((value, is_physical))
}

/// What relative lengths refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LengthUnits {
    /// The size of the nearest viewport, user units.
    pub view: DVec2,
    /// The size of the font, user units.
    pub em: f64,
}

impl LengthUnits {
    /// The value of an attribute or property, whose name says which side of the viewport per cents are of.
    pub fn length(&self, name: &str, text: &str) -> Option<f64> {
        if let Some((value, _)) = length(text) {
            return Some(value);
        }
        let whole = match name {
            "x" | "width" | "cx" | "rx" | "x1" | "x2" | "dx" => self.view.x,
            "y" | "height" | "cy" | "ry" | "y1" | "y2" | "dy" => self.view.y,
            "font-size" => self.em,
            // SVG 2, 8.9: the diagonal, such that it is the side of a square.
            _ => (0.5 * self.view.length_squared()).sqrt(),
        };
        let length: Length = text.trim().parse().ok()?;
        let unit = match length.unit {
            LengthUnit::Percent => 0.01 * whole,
            LengthUnit::Em => self.em,
            LengthUnit::Ex => 0.5 * self.em,
            _ => return None,
        };
        let value = length.number * unit;
        (value.abs() <= LARGEST).then_some(value)
    }

    /// The length of an element's attribute; 0 without it, and `None` if it is none.
    pub fn of(&self, element: Node, name: &str) -> Option<f64> {
        let text = element.attribute(name);
        text.map_or(Some(0.0), |text| self.length(name, text))
    }
}

/// A list of transforms as one; `None` if it is malformed.
pub(super) fn transform(text: &str) -> Option<DAffine2> {
    let Transform { a, b, c, d, e, f } = text.parse().ok()?;
    let map = DAffine2::from_cols_array(&[a, b, c, d, e, f]);
    map.is_finite().then_some(map)
}

/// An opaque colour of CSS, linear.
pub(super) fn color(text: &str) -> Option<Rgb> {
    let color: Color = text.parse().ok()?;
    let parts = [color.red, color.green, color.blue].map(f64::from);
    let linear = parts.map(|part| linear_from_srgb_f64(part / 255.0));
    (color.alpha == 255).then(|| linear.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_run_into_each_other() {
        let check = |text: &str, expected: &[f64], is_cut: bool| {
            assert_eq!(numbers(text), (expected.to_vec(), is_cut), "{text}");
        };
        check(" 1,-2 \n+3e1", &[1.0, -2.0, 30.0], false);
        check("1.5.5-3-.25e-1", &[1.5, 0.5, -3.0, -0.025], false);
        check("", &[], false);
        check("1 x", &[1.0], true);
        check("1e99", &[], true);
    }

    #[test]
    fn lengths_have_units() {
        assert_eq!(length("25.4mm"), Some((96.0, true)));
        assert_eq!(length(" 1in "), Some((96.0, true)));
        assert_eq!(length("12"), Some((12.0, false)));
        assert_eq!(length("12px"), Some((12.0, false)));
        assert_eq!(
            (length("50%"), length("auto"), length("2em")),
            (None, None, None)
        );
    }

    #[test]
    fn relative_lengths_are_of_the_viewport_or_the_font() {
        let units = LengthUnits {
            view: DVec2::new(300.0, 400.0),
            em: 20.0,
        };
        let check = |name: &str, text: &str, expected: Option<f64>| {
            let found = units.length(name, text);
            let is_near = |(a, b): (f64, f64)| (a - b).abs() < 1e-9;
            assert_eq!(found.is_some(), expected.is_some(), "{name} {text}");
            assert!(
                found.zip(expected).is_none_or(is_near),
                "{name} {text}: {found:?}"
            );
        };
        check("x", "10%", Some(30.0));
        check("height", "50%", Some(200.0));
        check("r", "10%", Some(0.1 * (125_000.0_f64).sqrt()));
        check("font-size", "150%", Some(30.0));
        check("x", "2em", Some(40.0));
        check("dy", "1ex", Some(10.0));
        check("x", "1in", Some(96.0));
        check("x", "auto", None);
    }

    #[test]
    fn transforms_are_applied_from_the_right() {
        let check = |text: &str, expected: [f64; 2]| {
            let point = transform(text)
                .unwrap()
                .transform_point2(DVec2::new(1.0, 2.0));
            assert!(point.distance(expected.into()) < 1e-12, "{text} {point}");
        };
        check("", [1.0, 2.0]);
        check("translate(10)", [11.0, 2.0]);
        check("translate(10, 20) scale(2)", [12.0, 24.0]);
        check("scale(2,3),translate(1 1)", [4.0, 9.0]);
        check("rotate(90)", [-2.0, 1.0]);
        check("rotate(90 1 1)", [0.0, 1.0]);
        check("matrix(1 0 2 1 5 6)", [10.0, 8.0]);
        check("skewX(45) ", [3.0, 2.0]);
        check("skewY(45)", [1.0, 3.0]);
        for bad in [
            "scale",
            "scale(",
            "scale()",
            "spin(3)",
            "rotate(1,2)",
            "scale(a)",
        ] {
            assert_eq!(transform(bad), None, "{bad}");
        }
    }

    #[test]
    fn colors_are_linear() {
        let check = |text: &str, expected: [f64; 3]| {
            let [r, g, b] = expected;
            assert_eq!(color(text), Some(Rgb::new(r, g, b)), "{text}");
        };
        check("#f00", [1.0, 0.0, 0.0]);
        check("#00FF00", [0.0, 1.0, 0.0]);
        check("rgb(0, 0,255)", [0.0, 0.0, 1.0]);
        check("rgb(100%,0%,100%)", [1.0, 0.0, 1.0]);
        check(" White ", [1.0, 1.0, 1.0]);
        assert!((color("#808080").unwrap().r - 0.2159).abs() < 1e-4);
        for bad in ["url(#a)", "#12", "rgb(1,2)", "chartreusy", "", "#é12"] {
            assert_eq!(color(bad), None, "{bad}");
        }
    }
}
