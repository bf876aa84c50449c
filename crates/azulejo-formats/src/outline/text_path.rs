//! Text along a curve.
//!
//! Letters are not bent: each is turned so that its base line touches the curve below the middle of the letter, as SVG
//! 2 defines it (section 11.8.3, *Text layout on a path*).

use azulejo_scene::figure::Segment;
use azulejo_scene::{Align, Line, PlacedGlyph};
use glam::DVec2;
use kurbo::{CubicBez, Line as KurboLine, ParamCurve, ParamCurveArclen, PathSeg, Point};
use std::fmt;

/// Accuracy of lengths along the path, as a share of its length.
const ACCURACY: f64 = 1e-9;

/// A curve that text follows.
#[derive(Clone, Debug)]
pub struct TextPath {
    /// Segments that have a length.
    segments: Vec<Segment>,
    /// Where each segment ends along the path.
    ends: Vec<f64>,
}

/// Text that is longer than its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathTooShort {
    /// The length of the path, in ems.
    pub path: f64,
    /// The length of the longest line, in ems.
    pub line: f64,
}

impl fmt::Display for PathTooShort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PathTooShort { path, line } = self;
        write!(
            f,
            "the path is {path:.4} ems long, and a line of the text {line:.4}; expected a smaller font size, --size"
        )
    }
}

impl std::error::Error for PathTooShort {}

impl TextPath {
    /// The path of consecutive segments, with `ems` to one of their units.
    pub fn new(segments: &[Segment], ems: f64) -> TextPath {
        let scaled = segments.iter().map(|s| match *s {
            Segment::Line(points) => Segment::Line(points.map(|p| ems * p)),
            Segment::Cubic(points) => Segment::Cubic(points.map(|p| ems * p)),
        });
        let scaled: Vec<Segment> = scaled.collect();
        let size = scaled
            .iter()
            .map(|s| s.bounds().size().length())
            .sum::<f64>();
        let mut path = TextPath {
            segments: Vec::new(),
            ends: Vec::new(),
        };
        for segment in scaled {
            let length = in_kurbo(&segment).arclen(ACCURACY * size);
            if length > 0.0 {
                path.ends.push(path.length() + length);
                path.segments.push(segment);
            }
        }
        path
    }

    /// Its length, ems.
    pub fn length(&self) -> f64 {
        self.ends.last().copied().unwrap_or(0.0)
    }

    /// Places lines along the path: the base line of the first is on it, that of others below, `leading` times their
    /// [size](Line::size) from one to the next.
    ///
    /// # Errors
    /// A line that is longer than the path.
    pub fn place(
        &self,
        lines: Vec<Line>,
        align: Align,
        leading: f64,
    ) -> Result<Vec<PlacedGlyph>, PathTooShort> {
        let (path, longest) = (self.length(), lines.iter().map(|line| line.advance));
        let line = longest.fold(0.0, f64::max);
        if line > (1.0 + 1e-6) * path {
            return Err(PathTooShort { path, line });
        }
        let mut placed = Vec::new();
        let mut below = 0.0;
        for (k, line) in lines.into_iter().enumerate() {
            if k > 0 {
                below += leading * line.size;
            }
            let start = align.before() * (path - line.advance);
            for letter in &line.letters {
                let middle = letter.start + 0.5 * letter.advance;
                let (at, along) = self.at(start + middle);
                let turned = |v: DVec2| v.x * along + v.y * along.perp();
                placed.extend(
                    line.glyphs[letter.glyphs.clone()]
                        .iter()
                        .map(|glyph| PlacedGlyph {
                            pen: at + turned(glyph.pen - DVec2::new(middle, below)),
                            axis: turned(glyph.axis),
                            ..glyph.clone()
                        }),
                );
            }
        }
        Ok(placed)
    }

    /// The point at a length along the path, and the unit direction there.
    fn at(&self, along: f64) -> (DVec2, DVec2) {
        let k = self.ends.partition_point(|end| *end < along);
        let k = k.min(self.segments.len().saturating_sub(1));
        let Some(segment) = self.segments.get(k) else {
            return (DVec2::ZERO, DVec2::X);
        };
        let start = k.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        let curve = in_kurbo(segment);
        let inside = (along - start).clamp(0.0, self.ends[k] - start);
        let t = curve
            .inv_arclen(inside, ACCURACY * self.length())
            .clamp(0.0, 1.0);
        let at = curve.eval(t);
        // Where a control point lies on an end, the curve has no derivative there.
        let direction = segment.derivative(t).try_normalize();
        let chord = || segment.at((t + 1e-3).min(1.0)) - segment.at((t - 1e-3).max(0.0));
        let direction = direction.unwrap_or_else(|| chord().normalize_or(DVec2::X));
        (DVec2::new(at.x, at.y), direction)
    }
}

fn in_kurbo(segment: &Segment) -> PathSeg {
    let point = |p: DVec2| Point::new(p.x, p.y);
    match *segment {
        Segment::Line([a, b]) => PathSeg::Line(KurboLine::new(point(a), point(b))),
        Segment::Cubic(points) => {
            let [a, b, c, d] = points.map(point);
            PathSeg::Cubic(CubicBez::new(a, b, c, d))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Figure, Letter};
    use std::f64::consts::{FRAC_1_SQRT_2, PI};
    use std::sync::Arc;

    /// A line of letters that are one em wide.
    fn line(letters: usize) -> Line {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
        let figure = Arc::new(Figure::polygon(square));
        let pens = (0..letters).map(|k| k as f64);
        Line {
            glyphs: pens
                .clone()
                .map(|x| PlacedGlyph::new(Arc::clone(&figure), DVec2::new(x, 0.0)))
                .collect(),
            letters: pens
                .enumerate()
                .map(|(k, start)| Letter {
                    glyphs: k..k + 1,
                    start,
                    advance: 1.0,
                    is_blank: false,
                })
                .collect(),
            advance: letters as f64,
            ..Line::default()
        }
    }

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    #[test]
    fn straight_paths_change_nothing() {
        let path = TextPath::new(&[Segment::Line([v(0.0, 0.0), v(8.0, 0.0)])], 0.5);
        assert_eq!(path.length(), 4.0);
        for (align, start) in [
            (Align::Left, 0.0),
            (Align::Center, 0.5),
            (Align::Right, 1.0),
        ] {
            let placed = path.place(vec![line(3), line(3)], align, 1.5).unwrap();
            for (k, glyph) in placed.iter().enumerate() {
                let expected = v(start + (k % 3) as f64, -1.5 * (k / 3) as f64);
                assert!(glyph.pen.distance(expected) < 1e-9, "{glyph:?}");
                assert!(glyph.axis.distance(DVec2::X) < 1e-12);
            }
        }
    }

    /// On a circle, the middle of each letter's base touches it, and all are equally far apart.
    #[test]
    fn circles_are_followed() {
        // Four arcs, clockwise from the left: letters stand outside.
        let kappa = 4.0 / 3.0 * (PI / 8.0).tan();
        let corner = |k: i32| DVec2::from_angle(PI - 0.5 * PI * f64::from(k));
        let arc = |k: i32| {
            let (a, b) = (corner(k), corner(k + 1));
            let [forward, back] = [-a.perp(), b.perp()].map(|d| kappa * d);
            Segment::Cubic([a, a + forward, b + back, b])
        };
        let radius = 5.0;
        let path = TextPath::new(&[0, 1, 2, 3].map(arc), radius);
        assert!((path.length() - 2.0 * PI * radius).abs() < 1e-2);
        let placed = path.place(vec![line(20)], Align::Left, 1.0).unwrap();
        for (k, glyph) in placed.iter().enumerate() {
            let middle = glyph.pen + 0.5 * glyph.axis;
            assert!((middle.length() - radius).abs() < 2e-3, "{middle}");
            assert!((glyph.axis.length() - 1.0).abs() < 1e-12);
            assert!(glyph.axis.dot(middle).abs() < 1e-2, "letters stand upright");
            assert!(glyph.axis.perp().dot(middle) > 0.0, "outside");
            let angle = PI - (k as f64 + 0.5) / radius;
            let expected = radius * DVec2::from_angle(angle);
            assert!(middle.distance(expected) < 5e-3, "{k} {middle} {expected}");
        }
    }

    #[test]
    fn texts_turn_with_the_path_and_must_fit() {
        let corner = [v(0.0, 0.0), v(2.0, 2.0), v(2.0, 2.0), v(4.0, 0.0)];
        let path = TextPath::new(
            &[0, 1, 2].map(|k| Segment::Line([corner[k], corner[k + 1]])),
            1.0,
        );
        let placed = path.place(vec![line(5)], Align::Left, 1.0).unwrap();
        assert!(placed[0].axis.distance(FRAC_1_SQRT_2 * v(1.0, 1.0)) < 1e-12);
        assert!(placed[4].axis.distance(FRAC_1_SQRT_2 * v(1.0, -1.0)) < 1e-12);
        let error = path.place(vec![line(6)], Align::Left, 1.0).unwrap_err();
        assert_eq!(error.line, 6.0);
        let nowhere = TextPath::new(&[], 1.0);
        assert!(nowhere.place(vec![line(1)], Align::Left, 1.0).is_err());
        assert_eq!(
            nowhere.place(vec![Line::default()], Align::Left, 1.0),
            Ok(vec![])
        );
    }
}
