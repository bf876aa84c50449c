//! Seven letters, drawn for these scenes: one unit is an em, the baseline is y = 0.

use azulejo::scene::{Contour, Curve, Encoding, Figure, FillRule, Font, Glyph};
use glam::DVec2;

/// The letters of "azulejo" and their codes.
pub fn font() -> (Font, Encoding) {
    let letters = [
        (
            'a',
            vec![
                circle([0.3, 0.3], 0.3),
                hole([0.3, 0.3], 0.16),
                bar([0.44, 0.0], [0.6, 0.6]),
            ],
        ),
        ('z', vec![z()]),
        ('u', vec![u()]),
        ('l', vec![bar([0.0, 0.0], [0.15, 0.9])]),
        ('e', e().to_vec()),
        ('j', vec![j(), circle([0.075, 0.78], 0.1)]),
        ('o', vec![circle([0.3, 0.3], 0.3), hole([0.3, 0.3], 0.16)]),
    ];
    let (mut font, mut encoding) = (Font::default(), Encoding::default());
    for (letter, contours) in letters {
        // Parts of a letter overlap: what any of them goes around is inside.
        let figure = Figure {
            contours,
            rule: FillRule::NonZero,
        };
        font.glyphs.insert(letter.into(), Glyph::new(figure));
        encoding.names.insert(letter.into(), letter.into());
    }
    (font, encoding)
}

fn line(x: f64, y: f64) -> Curve {
    Curve::Line {
        start: DVec2::new(x, y),
    }
}

fn cubic(start: [f64; 2], control1: [f64; 2], control2: [f64; 2]) -> Curve {
    Curve::Cubic {
        start: start.into(),
        control1: control1.into(),
        control2: control2.into(),
    }
}

/// An upright rectangle.
fn bar([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Contour {
    Contour {
        curves: vec![line(x0, y0), line(x1, y0), line(x1, y1), line(x0, y1)],
    }
}

/// A circle, counter-clockwise, of four curves that leave it by 0.03% of its radius.
fn circle(centre: [f64; 2], radius: f64) -> Contour {
    turning(centre, radius, 1.0)
}

/// A circle that takes away what is inside: clockwise.
fn hole(centre: [f64; 2], radius: f64) -> Contour {
    turning(centre, radius, -1.0)
}

fn turning(centre: [f64; 2], radius: f64, turn: f64) -> Contour {
    let reach = radius * 0.5523;
    let quarter = |k: i32| {
        let (outward, along) = [(DVec2::X, DVec2::Y), (DVec2::Y, DVec2::NEG_X)][k as usize % 2];
        let sign = if k < 2 { 1.0 } else { -1.0 };
        let mirror = DVec2::new(1.0, turn);
        // Few digits, so that the file is easy on the eye.
        let at = |p: DVec2| {
            let exact = DVec2::from(centre) + sign * p * mirror;
            (1e4 * exact).round() / 1e4
        };
        Curve::Cubic {
            start: at(radius * outward),
            control1: at(radius * outward + reach * along),
            control2: at(radius * along + reach * outward),
        }
    };
    Contour {
        curves: (0..4).map(quarter).collect(),
    }
}

fn z() -> Contour {
    let corners = [
        [0.0, 0.0],
        [0.5, 0.0],
        [0.5, 0.14],
        [0.2, 0.14],
        [0.5, 0.46],
        [0.5, 0.6],
        [0.0, 0.6],
        [0.0, 0.46],
        [0.3, 0.46],
        [0.0, 0.14],
    ];
    Contour {
        curves: corners.map(|[x, y]| line(x, y)).to_vec(),
    }
}

fn u() -> Contour {
    Contour {
        curves: vec![
            line(0.0, 0.6),
            cubic([0.0, 0.26], [0.0, 0.11], [0.11, 0.0]),
            cubic([0.26, 0.0], [0.41, 0.0], [0.52, 0.11]),
            line(0.52, 0.26),
            line(0.52, 0.6),
            line(0.37, 0.6),
            cubic([0.37, 0.26], [0.37, 0.2], [0.32, 0.15]),
            cubic([0.26, 0.15], [0.2, 0.15], [0.15, 0.2]),
            line(0.15, 0.26),
            line(0.15, 0.6),
        ],
    }
}

/// The letter and its eye.
fn e() -> [Contour; 2] {
    let outside = vec![
        line(0.6, 0.24),
        cubic([0.6, 0.3], [0.6, 0.466], [0.466, 0.6]),
        cubic([0.3, 0.6], [0.134, 0.6], [0.0, 0.466]),
        cubic([0.0, 0.3], [0.0, 0.134], [0.134, 0.0]),
        cubic([0.3, 0.0], [0.4, 0.0], [0.485, 0.045]),
        line(0.54, 0.12),
        cubic([0.43, 0.21], [0.395, 0.165], [0.35, 0.14]),
        cubic([0.3, 0.14], [0.225, 0.14], [0.16, 0.18]),
        line(0.15, 0.24),
    ];
    let eye = vec![
        cubic([0.15, 0.36], [0.17, 0.42], [0.228, 0.46]),
        cubic([0.3, 0.46], [0.372, 0.46], [0.43, 0.42]),
        line(0.45, 0.36),
    ];
    [Contour { curves: outside }, Contour { curves: eye }]
}

/// Its hook reaches to the left of the pen.
fn j() -> Contour {
    Contour {
        curves: vec![
            line(0.0, 0.6),
            cubic([0.0, -0.02], [0.0, -0.09], [-0.05, -0.12]),
            line(-0.15, -0.12),
            cubic([-0.15, -0.25], [0.05, -0.25], [0.15, -0.16]),
            line(0.15, -0.02),
            line(0.15, 0.6),
        ],
    }
}
