//! Converts overlapping contours to the outline of their union.

use azulejo_scene::figure::Segment;
use azulejo_scene::{Contour, Curve, Figure, FillRule};
use glam::DVec2;
use std::collections::HashMap;

/// Largest figure that is converted: every pair of curves is tested.
const MOST_CURVES: usize = 2000;

/// Most steps toward the crossings of one pair of curves; coincident curves would take more.
const MOST_STEPS: usize = 20_000;

/// Accuracy of the parameters of crossings.
const NEAR: f64 = 1e-11;

/// Parameters this near to an end are at the end.
const AT_END: f64 = 1e-7;

/// Negligible differences: see [`difference`].
const UNSEEN: f64 = 1e-4;

/// The inside of a figure, as contours that do not cross, for which both fill rules agree.
/// `None` if curves coincide, or touch without crossing.
///
/// Every curve is cut where others cross it, and only the pieces are kept that have the inside on
/// exactly one side.
pub(super) fn union(figure: &Figure) -> Option<Figure> {
    let segments: Vec<Segment> = figure.segments().collect();
    if segments.len() > MOST_CURVES {
        return None;
    }
    let cuts = all_cuts(&segments)?;
    let mut edges = Vec::new();
    for (segment, cuts) in segments.iter().zip(cuts) {
        for piece in pieces(segment, cuts) {
            edges.extend(oriented(figure, piece)?);
        }
    }
    let united = Figure {
        contours: chained(edges)?,
        rule: FillRule::EvenOdd,
    };
    (difference(figure, &united) < UNSEEN).then_some(united)
}

/// A point where a curve is cut: the parameter there, and the point, which is the same to the bit
/// for both curves.
type Cut = (f64, DVec2);

fn all_cuts(segments: &[Segment]) -> Option<Vec<Vec<Cut>>> {
    let mut cuts = vec![Vec::new(); segments.len()];
    for i in 0..segments.len() {
        for j in 0..i {
            let mut search = Search {
                curves: [&segments[i], &segments[j]],
                found: Vec::new(),
                steps: 0,
            };
            search.run([0.0, 1.0], [0.0, 1.0])?;
            for (s, t) in search.found {
                match (at_end(s), at_end(t)) {
                    // Neighbours meet, and contours may touch at corners.
                    (true, true) => {}
                    // A corner on another curve cuts only that curve.
                    (true, false) => cuts[j].push((t, corner(&segments[i], s))),
                    (false, true) => cuts[i].push((s, corner(&segments[j], t))),
                    (false, false) => {
                        let point = 0.5 * (segments[i].at(s) + segments[j].at(t));
                        cuts[i].push((s, point));
                        cuts[j].push((t, point));
                    }
                }
            }
        }
    }
    Some(cuts)
}

fn at_end(t: f64) -> bool {
    !(AT_END..=1.0 - AT_END).contains(&t)
}

/// The end of a curve at a parameter.
fn corner(segment: &Segment, t: f64) -> DVec2 {
    if t < 0.5 {
        segment.start()
    } else {
        segment.end()
    }
}

/// Searches the crossings of two curves by bisecting both.
struct Search<'a> {
    curves: [&'a Segment; 2],
    found: Vec<(f64, f64)>,
    steps: usize,
}

impl Search<'_> {
    fn run(&mut self, s: [f64; 2], t: [f64; 2]) -> Option<()> {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return None;
        }
        let [a, b] = [(self.curves[0], s), (self.curves[1], t)]
            .map(|(curve, [from, to])| part(curve, from, to).bounds());
        let apart = a.max.cmplt(b.min).any() || b.max.cmplt(a.min).any();
        if apart {
            return Some(());
        }
        if s[1] - s[0] < NEAR && t[1] - t[0] < NEAR {
            let crossing = (0.5 * (s[0] + s[1]), 0.5 * (t[0] + t[1]));
            let is_new = |&(u, v): &(f64, f64)| {
                (u - crossing.0).abs() > 1e3 * NEAR || (v - crossing.1).abs() > 1e3 * NEAR
            };
            if self.found.iter().all(is_new) {
                self.found.push(crossing);
            }
            return Some(());
        }
        let halves = |[from, to]: [f64; 2]| {
            let middle = 0.5 * (from + to);
            [[from, middle], [middle, to]]
        };
        for s in halves(s) {
            for t in halves(t) {
                self.run(s, t)?;
            }
        }
        Some(())
    }
}

/// A curve between two of its parameters.
fn part(segment: &Segment, from: f64, to: f64) -> Segment {
    let (start, end) = (segment.at(from), segment.at(to));
    match segment {
        Segment::Line(_) => Segment::Line([start, end]),
        Segment::Cubic(_) => {
            let reach = (to - from) / 3.0;
            let control1 = start + reach * segment.derivative(from);
            let control2 = end - reach * segment.derivative(to);
            Segment::Cubic([start, control1, control2, end])
        }
    }
}

/// A curve cut into pieces, whose ends are the points of the cuts.
fn pieces(segment: &Segment, mut cuts: Vec<Cut>) -> Vec<Segment> {
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Both curves at a corner cut there.
    cuts.dedup_by(|a, b| a.0 - b.0 < AT_END);
    let mut from = (0.0, segment.start());
    let mut pieces = Vec::new();
    for to in cuts.into_iter().chain([(1.0, segment.end())]) {
        pieces.push(match part(segment, from.0, to.0) {
            Segment::Line(_) => Segment::Line([from.1, to.1]),
            Segment::Cubic([_, control1, control2, _]) => {
                Segment::Cubic([from.1, control1, control2, to.1])
            }
        });
        from = to;
    }
    pieces
}

/// A piece oriented with the inside on its left; `Some(None)` if both sides are the same, and `None`
/// if that cannot be determined.
fn oriented(figure: &Figure, piece: Segment) -> Option<Option<Segment>> {
    const ASIDE: f64 = 1e-6;
    if piece.start() == piece.end() && matches!(piece, Segment::Line(_)) {
        return Some(None);
    }
    let aside = ASIDE * piece.derivative(0.5).try_normalize()?.perp();
    let middle = piece.at(0.5);
    let [left, right] = [aside, -aside].map(|side| figure.contains(middle + side));
    Some(match (left, right) {
        (true, false) => Some(piece),
        (false, true) => Some(reversed(piece)),
        _ => None,
    })
}

fn reversed(piece: Segment) -> Segment {
    match piece {
        Segment::Line([a, b]) => Segment::Line([b, a]),
        Segment::Cubic([a, b, c, d]) => Segment::Cubic([d, c, b, a]),
    }
}

/// Joins pieces end to end. The choice where several chains meet does not affect the inside.
fn chained(edges: Vec<Segment>) -> Option<Vec<Contour>> {
    let key = |p: DVec2| (p + DVec2::ZERO).to_array().map(f64::to_bits);
    let mut by_start: HashMap<_, Vec<usize>> = HashMap::new();
    for (i, edge) in edges.iter().enumerate().rev() {
        by_start.entry(key(edge.start())).or_default().push(i);
    }
    let mut is_used = vec![false; edges.len()];
    let mut contours = Vec::new();
    for first in 0..edges.len() {
        let mut curves = Vec::new();
        let mut at = key(edges[first].start());
        while !is_used[first] || !curves.is_empty() {
            let next = by_start.get_mut(&at)?.pop()?;
            is_used[next] = true;
            curves.push(curve(&edges[next]));
            at = key(edges[next].end());
            if at == key(edges[first].start()) {
                break;
            }
        }
        if !curves.is_empty() {
            contours.push(Contour { curves });
        }
    }
    Some(contours)
}

fn curve(edge: &Segment) -> Curve {
    match *edge {
        Segment::Line([start, _]) => Curve::Line { start },
        Segment::Cubic([start, control1, control2, _]) => Curve::Cubic {
            start,
            control1,
            control2,
        },
    }
}

/// By how much the insides of two figures differ, each by its own fill rule: the mean difference of
/// their widths along scan lines.
///
/// It is exact for figures with the same contours. For others it has the errors of chords, which are
/// largest where a curve runs along a scan line: about 1e-5 in all.
pub(super) fn difference(a: &Figure, b: &Figure) -> f64 {
    const LINES: u32 = 400;
    let bounds = a.bounds().union(b.bounds());
    let polygons = [a, b].map(|figure| figure.flatten(1e-5));
    let at = |k: u32| {
        let y = bounds.min.y + bounds.size().y * (f64::from(k) + 0.5) / f64::from(LINES);
        let of_a = width_inside(&polygons[0], a.rule, y);
        (of_a - width_inside(&polygons[1], b.rule, y)).abs()
    };
    (0..LINES).map(at).sum::<f64>() / f64::from(LINES)
}

/// The length of the horizontal line at `y` that is inside.
fn width_inside(polygons: &[Vec<DVec2>], rule: FillRule, y: f64) -> f64 {
    let mut crossings = Vec::new();
    for corners in polygons {
        let next = corners.iter().cycle().skip(1);
        for (a, b) in corners.iter().zip(next) {
            let sense = i32::from(b.y >= y) - i32::from(a.y >= y);
            if sense != 0 {
                crossings.push((a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), sense));
            }
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut winding = 0;
    let inside = crossings.windows(2).map(|pair| {
        winding += pair[0].1;
        if rule.is_inside(winding) {
            pair[1].0 - pair[0].0
        } else {
            0.0
        }
    });
    inside.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::pen::{Ellipse, Pen};
    use std::f64::consts::PI;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    fn square(pen: &mut Pen, corner: DVec2, side: f64) {
        pen.move_to(corner);
        pen.line_to(corner + v(side, 0.0));
        pen.line_to(corner + v(side, side));
        pen.line_to(corner + v(0.0, side));
        pen.close();
    }

    fn disc(pen: &mut Pen, centre: DVec2, radius: f64) {
        pen.ellipse(Ellipse {
            centre,
            x: v(radius, 0.0),
            y: v(0.0, radius),
        });
    }

    fn check(draw: impl Fn(&mut Pen), contours: usize, area: f64) {
        let mut pen = Pen::default();
        draw(&mut pen);
        let figure = pen.finish(FillRule::NonZero);
        let united = union(&figure).unwrap();
        assert_eq!(united.contours.len(), contours);
        assert!(
            (united.signed_area() - area).abs() < 1e-4,
            "{}",
            united.signed_area()
        );
        assert!(difference(&figure, &united) < 2e-5);
    }

    #[test]
    fn overlapping_contours_are_merged() {
        check(|pen| square(pen, v(0.0, 0.0), 1.0), 1, 1.0);
        let two = |pen: &mut Pen| {
            square(pen, v(0.0, 0.0), 1.0);
            square(pen, v(0.5, 0.5), 1.0);
        };
        check(two, 1, 1.75);
        // Half of a disc protrudes from a square.
        let knob = |pen: &mut Pen| {
            square(pen, v(0.0, 0.0), 1.0);
            disc(pen, v(1.0, 0.51), 0.25);
        };
        check(knob, 1, 1.0 + 0.5 * PI / 16.0);
        let inner = |pen: &mut Pen| {
            square(pen, v(0.0, 0.0), 1.0);
            disc(pen, v(0.5, 0.5), 0.25);
        };
        check(inner, 1, 1.0);
        let apart = |pen: &mut Pen| {
            square(pen, v(0.0, 0.0), 1.0);
            disc(pen, v(3.0, 0.5), 1.0);
        };
        check(apart, 2, 1.0 + PI);
    }

    #[test]
    fn holes_stay() {
        let ring = |pen: &mut Pen| {
            disc(pen, v(0.0, 0.0), 1.0);
            pen.ellipse(Ellipse {
                centre: v(0.0, 0.0),
                x: v(0.5, 0.0),
                y: v(0.0, -0.5),
            });
            square(pen, v(0.9, -0.05), 0.3);
        };
        let mut pen = Pen::default();
        ring(&mut pen);
        let united = union(&pen.finish(FillRule::NonZero)).unwrap();
        assert_eq!(united.contours.len(), 2);
        assert!(!united.contains(v(0.1, 0.1)) && united.contains(v(1.1, 0.01)));
    }

    #[test]
    fn coincident_sides_are_not_merged() {
        let mut pen = Pen::default();
        square(&mut pen, v(0.0, 0.0), 1.0);
        square(&mut pen, v(0.5, 0.0), 1.0);
        assert_eq!(union(&pen.finish(FillRule::NonZero)), None);
    }
}
