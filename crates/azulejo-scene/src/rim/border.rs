//! The pieces of a figure's curves that bound its inside.

use super::RimPiece;
use super::pieces_tree::PiecesTree;
use crate::Figure;
use crate::figure::{Rectangle, Segment};
use glam::DVec2;
use std::collections::HashMap;

/// Distance from a curve at which its two sides are told apart, relative to the figure's size.
const BESIDE: f64 = 1e-7;
/// Parameters nearer than this are one.
const SAME: f64 = 1e-9;
/// Parameters nearer to an end than this are at a joint.
const JOINT: f64 = 1e-6;
/// Points nearer than this are one, relative to the curves' size.
const MARGIN: f64 = 1e-12;
/// Most tests of two curves; those that coincide would need more.
const MOST_TESTS: u32 = 4096;
/// Turns below this sine are smooth.
const SMOOTH_SINE: f64 = 1e-9;

/// The pieces, contour by contour. Those between two crossings lie on one side of all others, which one point of them
/// shows.
pub(super) fn pieces(figure: &Figure) -> Vec<RimPiece> {
    let segments: Vec<Segment> = figure.segments().collect();
    let cuts = Cuts::new(&segments);
    let beside = BESIDE * figure.bounds().size().max_element();
    let mut pieces = Vec::new();
    let mut first = 0;
    for contour in &figure.contours {
        let mut inner = None;
        let end = first + contour.curves.len();
        for (curve, segment) in (first..end).zip(&segments[first..end]) {
            for part in cuts.parts(curve) {
                let piece = segment.part(part.range);
                if part.begins_anew {
                    inner = None;
                }
                let inner = *inner.get_or_insert_with(|| inner_side(figure, &piece, beside));
                if inner != 0.0 && piece != Segment::Line([piece.start(); 2]) {
                    pieces.push(RimPiece::new(curve as u32, part.range, piece, inner));
                }
            }
        }
        first = end;
    }
    pieces
}

/// 1 where the inside is on the left of a piece alone, −1 on its right, 0 where it is on both sides or none.
fn inner_side(figure: &Figure, piece: &Segment, beside: f64) -> f64 {
    // Off the middle, where drawings cross themselves more often.
    let (middle, tangent) = (piece.at(0.47), piece.tangent(0.47));
    let aside = beside * tangent.perp().normalize_or_zero();
    let [left, right] = [middle + aside, middle - aside].map(|p| figure.contains(p));
    f64::from(i8::from(left) - i8::from(right))
}

/// Where curves are divided.
struct Cuts {
    /// The parameters at which others cross or touch each curve, in order, from 0 to 1; 0 and 1 only if
    /// others than its neighbours pass there.
    of_curve: Vec<Vec<f64>>,
}

/// A part of a curve between cuts.
struct CurvePart {
    range: [f64; 2],
    /// Whether it may lie on another side of others than the part before it.
    begins_anew: bool,
}

impl Cuts {
    fn new(segments: &[Segment]) -> Cuts {
        let bounds: Vec<Rectangle> = segments.iter().map(Segment::bounds).collect();
        let tree = PiecesTree::new(&bounds);
        let mut cuts = Cuts {
            of_curve: vec![Vec::new(); segments.len()],
        };
        for (a, around) in bounds.iter().enumerate() {
            let diagonal = [around.min, around.max];
            let mut others = Vec::new();
            let reach = around.size().max_element();
            tree.along(diagonal, reach, |b| others.push(b as usize));
            others.retain(|&b| b > a && around.overlaps(&bounds[b]));
            for b in others {
                cuts.add([a, b], [&segments[a], &segments[b]]);
            }
        }
        for list in &mut cuts.of_curve {
            list.sort_by(f64::total_cmp);
            list.dedup_by(|b, a| *b - *a < SAME);
        }
        cuts
    }

    /// Adds where two curves cross or touch, except for the joint of neighbours.
    fn add(&mut self, [a, b]: [usize; 2], [p, q]: [&Segment; 2]) {
        let size = p.hull().union(q.hull()).size().max_element();
        let mut meetings = Meetings {
            wholes: [*p, *q],
            margin: MARGIN * size,
            found: Vec::new(),
            tests: MOST_TESTS,
        };
        meetings.search([*p, *q], [[0.0, 1.0]; 2]);
        if meetings.tests == 0 {
            // They run along each other: divided where one of them begins or ends.
            meetings.found.clear();
            for (t, end) in [(0.0, q.start()), (1.0, q.end())] {
                meetings.touch([p, q], end, |at| [at, t]);
            }
            for (t, end) in [(0.0, p.start()), (1.0, p.end())] {
                meetings.touch([q, p], end, |at| [t, at]);
            }
        }
        let (is_start, is_end) = (|t: f64| t < JOINT, |t: f64| t > 1.0 - JOINT);
        for [s, t] in meetings.found {
            let joins = is_end(s) && is_start(t) && p.end() == q.start()
                || is_start(s) && is_end(t) && p.start() == q.end();
            if !joins {
                self.of_curve[a].push(s);
                self.of_curve[b].push(t);
            }
        }
    }

    fn parts(&self, curve: usize) -> Vec<CurvePart> {
        let list = &self.of_curve[curve];
        let inner = list
            .iter()
            .copied()
            .filter(|t| (SAME..=1.0 - SAME).contains(t));
        let mut ends: Vec<f64> = [0.0].into_iter().chain(inner).chain([1.0]).collect();
        ends.dedup();
        // A joint at which others pass may count for the curve before it alone.
        let before = curve.checked_sub(1).and_then(|k| self.of_curve[k].last());
        let starts_anew = list.first().is_some_and(|t| *t < JOINT);
        let starts_anew = starts_anew || before.is_some_and(|t| *t > 1.0 - JOINT);
        let begins_anew = |k: usize| k > 0 || starts_anew;
        let part = |(k, w): (usize, &[f64])| CurvePart {
            range: [w[0], w[1]],
            begins_anew: begins_anew(k),
        };
        ends.windows(2).enumerate().map(part).collect()
    }
}

/// The search for the points that two curves share.
struct Meetings {
    wholes: [Segment; 2],
    /// More than rounding moves points.
    margin: f64,
    /// Their parameters on both.
    found: Vec<[f64; 2]>,
    /// How many tests are left.
    tests: u32,
}

impl Meetings {
    /// Halves the larger of both curves as long as the rectangles around their control points overlap.
    fn search(&mut self, curves: [Segment; 2], ranges: [[f64; 2]; 2]) {
        if self.tests == 0 {
            return;
        }
        self.tests -= 1;
        let [p, q] = curves.map(|c| c.hull().enlarged(self.margin));
        if !p.overlaps(&q) {
            return;
        }
        let [of_p, of_q] = [p, q].map(|hull| hull.size().max_element());
        let larger = usize::from(of_q > of_p);
        let middles = ranges.map(|[first, last]| 0.5 * (first + last));
        if of_p.max(of_q) <= 4.0 * self.margin {
            let is_known = |known: &[f64; 2]| (0..2).all(|k| (known[k] - middles[k]).abs() < SAME);
            if !self.found.iter().any(is_known) {
                self.found.push(middles);
            }
            return;
        }
        let [first, last] = ranges[larger];
        for half in [[first, middles[larger]], [middles[larger], last]] {
            let (mut curves, mut ranges) = (curves, ranges);
            curves[larger] = self.wholes[larger].part(half);
            ranges[larger] = half;
            self.search(curves, ranges);
        }
    }

    /// Adds an end of the second curve if it lies on the first one.
    fn touch(&mut self, [p, q]: [&Segment; 2], end: DVec2, pair: impl Fn(f64) -> [f64; 2]) {
        let at = super::nearest_parameter(p, end);
        let size = p.hull().union(q.hull()).size().max_element();
        if p.at(at).distance(end) < SAME * size {
            self.found.push(pair(at));
        }
    }
}

/// Marks the ends of pieces at which the inside is wider than a half-plane.
pub(super) fn find_reflex_corners(pieces: &mut [RimPiece]) {
    // Adding zero turns −0 into 0.
    let key = |p: DVec2| [p.x + 0.0, p.y + 0.0].map(f64::to_bits);
    let mut joints: HashMap<[u64; 2], Vec<(usize, usize)>> = HashMap::new();
    for (k, piece) in pieces.iter().enumerate() {
        for (end, at) in [piece.segment.start(), piece.segment.end()]
            .into_iter()
            .enumerate()
        {
            joints.entry(key(at)).or_default().push((k, end));
        }
    }
    for joint in joints.values() {
        let is_reflex = match joint[..] {
            [(a, 1), (b, 0)] | [(b, 0), (a, 1)] => turns_outwards(&pieces[a], &pieces[b]),
            _ => true,
        };
        for &(k, end) in joint {
            pieces[k].is_reflex[end] = is_reflex;
        }
    }
}

/// Whether the border turns away from its inside where one piece continues in another.
fn turns_outwards(before: &RimPiece, after: &RimPiece) -> bool {
    let arrival = -before.segment.reversed().departure().normalize_or_zero();
    let departure = after.segment.departure().normalize_or_zero();
    let turn = arrival.perp_dot(departure);
    let is_back = arrival.dot(departure) < 0.0 && turn.abs() < SMOOTH_SINE;
    before.inner != after.inner || is_back || before.inner * turn < -SMOOTH_SINE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contour, Curve, FillRule};

    fn square(x: f64, y: f64, size: f64) -> Contour {
        let corners = [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)];
        let at = DVec2::new(x, y);
        Figure::polygon(corners.map(|c| at + DVec2::from(c)))
            .contours
            .remove(0)
    }

    fn length(figure: &Figure) -> f64 {
        pieces(figure)
            .iter()
            .map(|p| (p.segment.end() - p.segment.start()).length())
            .sum()
    }

    #[test]
    fn borders_of_overlapping_squares_are_those_of_their_union() {
        let check = |contours: Vec<Contour>, rule: FillRule, expected: f64| {
            let found = length(&Figure { contours, rule });
            assert!(
                (found - expected).abs() < 1e-9,
                "{rule:?} {found} {expected}"
            );
        };
        let two = || vec![square(0.0, 0.0, 2.0), square(1.0, 1.0, 2.0)];
        check(two(), FillRule::NonZero, 12.0);
        check(two(), FillRule::EvenOdd, 16.0);
        // Side by side: the common edge is inside, also where it is only a part of both edges.
        let beside = || vec![square(0.0, 0.0, 2.0), square(2.0, 0.5, 2.0)];
        check(beside(), FillRule::NonZero, 13.0);
        let twice = || vec![square(0.0, 0.0, 2.0), square(0.0, 0.0, 2.0)];
        check(twice(), FillRule::EvenOdd, 0.0);
        // A hole stays one.
        let holed = || vec![square(0.0, 0.0, 3.0), square(1.0, 1.0, 1.0)];
        check(holed(), FillRule::EvenOdd, 16.0);
        check(holed(), FillRule::NonZero, 12.0);
    }

    #[test]
    fn reflex_corners_are_those_that_turn_outwards() {
        let corners = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (0.0, 2.0),
        ];
        for is_reversed in [false, true] {
            let mut corners = corners.map(DVec2::from);
            if is_reversed {
                corners.reverse();
            }
            let mut pieces = pieces(&Figure::polygon(corners));
            find_reflex_corners(&mut pieces);
            for piece in &pieces {
                for (end, at) in [piece.segment.start(), piece.segment.end()]
                    .into_iter()
                    .enumerate()
                {
                    assert_eq!(piece.is_reflex[end], at == DVec2::ONE, "{at}");
                }
            }
        }
    }

    #[test]
    fn smooth_joints_and_waves_are_no_corners() {
        let at = |k: i32| (1.0 + 0.2 * f64::from(k % 2)) * DVec2::from_angle(0.3 * f64::from(k));
        let curve = |k: i32| Curve::Cubic {
            start: at(3 * k),
            control1: at(3 * k + 1),
            control2: at(3 * k + 2),
        };
        let contours = vec![Contour {
            curves: (0..7).map(curve).collect(),
        }];
        let figure = Figure {
            contours,
            rule: FillRule::NonZero,
        };
        let found = pieces(&figure);
        assert_eq!(found.len(), 7);
        assert!(found.iter().all(|p| p.inner == 1.0));
    }

    /// The letter D of Costa 1992, and a bar with a tooth across it.
    fn crossing(rule: FillRule) -> Figure {
        let v = |x: f64, y: f64| DVec2::new(x, y) / 23.0;
        let cubic = |[a, b, c]: [(f64, f64); 3]| Curve::Cubic {
            start: v(a.0, a.1),
            control1: v(b.0, b.1),
            control2: v(c.0, c.1),
        };
        let line = |x, y| Curve::Line { start: v(x, y) };
        let bow = cubic([(8.0, 23.0), (25.0, 21.0), (23.0, 0.0)]);
        let outer = vec![line(0.0, 0.0), line(0.0, 23.0), bow, line(8.0, 0.0)];
        let hole = vec![cubic([(6.0, 15.0), (4.0, -6.0), (23.0, 17.0)])];
        let bar = [
            (-2.0, 3.0),
            (-2.0, 21.4),
            (18.0, 21.4),
            (9.0, 12.0),
            (17.0, 3.0),
        ];
        let bar = Figure::polygon(bar.map(|(x, y)| v(x, y)))
            .contours
            .remove(0);
        let contours = vec![Contour { curves: outer }, Contour { curves: hole }, bar];
        Figure { contours, rule }
    }

    #[test]
    fn chords_have_the_border_of_their_curves() {
        for rule in [FillRule::EvenOdd, FillRule::NonZero] {
            let curved = crossing(rule);
            let contours = curved.flatten(1e-5).into_iter();
            let contours = contours.flat_map(|c| Figure::polygon(c).contours).collect();
            let chords = Figure { contours, rule };
            let arc = |p: &RimPiece| {
                let at = |k: u32| p.segment.at(f64::from(k) / 200.0);
                (0..200).map(|k| at(k).distance(at(k + 1))).sum::<f64>()
            };
            let lengths = [&curved, &chords].map(|f| pieces(f).iter().map(arc).sum::<f64>());
            assert!(
                (lengths[0] - lengths[1]).abs() < 1e-3,
                "{rule:?} {lengths:?}"
            );
        }
    }
}
