//! Set operations on plane figures, which keep their curves.
//!
//! The figures are divided along fine chords (`flat_figure`), where contours that cross, touch or coincide need no
//! special case. The border of what is inside is a chain of pieces of chords; those of one curve become that part of it.

use super::flat_figure::{Delaunay, FlatFigure, Strips, key, point};
use super::uncrossed::add_edges;
use crate::figure::{Rectangle, Segment};
use crate::{Contour, Curve, Figure, FillRule};
use glam::DVec2;
use spade::{Point2, Triangulation};
use std::collections::HashMap;

/// How far chords may be off their curves, as a share of the figures' size: ends of curves that are cut are off by as
/// much.
const CHORD_ERROR: f64 = 1e-5;
/// Most chords; beyond, they may be further off.
const MOST_CHORDS: u64 = 1 << 16;
/// Coordinates are rounded to this share of the size, so that equal ones coincide, and triangles are not so thin that
/// points where chords cross are on the wrong side of them. Ends of curves that are not cut stay exact.
const GRID: f64 = 1.0 / (1u64 << 25) as f64;
/// How far rounding moves a point from its chord, and a parameter from an end.
const NEAR: f64 = 1e-7;

impl Figure {
    /// The points that are inside both figures, each by its own fill rule. Contours do not cross, and have the inside on
    /// their left; curves stay curves. Where curves are cut they end within 1e-5 of the figures' size, more for
    /// figures of very many curves.
    pub fn intersection(&self, other: &Figure) -> Figure {
        combined(&[self, other], |inside| !inside.contains(&false))
    }

    /// The points that are inside at least one of several figures. As [`intersection`](Figure::intersection).
    pub fn union(figures: &[&Figure]) -> Figure {
        combined(figures, |inside| inside.contains(&true))
    }

    /// The points that are inside this figure and outside all `others`. As [`intersection`](Figure::intersection).
    pub fn difference(&self, others: &[&Figure]) -> Figure {
        let figures: Vec<&Figure> = std::iter::once(&self).chain(others).copied().collect();
        combined(&figures, |inside| inside[0] && !inside[1..].contains(&true))
    }

    /// The same inside with contours that do not cross, and have it on their left. Precision as of
    /// [`intersection`](Figure::intersection).
    pub fn outline(&self) -> Figure {
        Figure::union(&[self])
    }
}

/// The figure of the points of which `is_kept` says so, given whether they are inside each of several figures.
fn combined(figures: &[&Figure], is_kept: impl Fn(&[bool]) -> bool) -> Figure {
    let bounds = (figures.iter()).fold(Rectangle::EMPTY, |b, f| b.union(f.bounds()));
    let size = bounds.size().max_element();
    if !(size > 0.0 && size.is_finite()) {
        return Figure::default();
    }
    let chords = Chords::new(figures, bounds.min, size);
    let mesh = chords.triangulated();
    let windings = chords.windings(figures);
    let is_inside = |p: DVec2| {
        let around = |(strips, rule): &(Strips, FillRule)| rule.is_inside(strips.winding(p));
        is_kept(&windings.iter().map(around).collect::<Vec<bool>>())
    };
    // Faces number from 0, the outer one included.
    let mut inside = vec![false; mesh.num_all_faces()];
    for face in mesh.inner_faces() {
        inside[face.fix().index()] = is_inside(point(face.center()));
    }
    let mut flat = FlatFigure::default();
    flat.collect(&mesh, &inside);
    let loops = loops(&flat.border);
    let contours = loops
        .iter()
        .map(|corners| chords.contour(corners, &flat.points));
    Figure {
        contours: contours
            .filter(|contour| !contour.curves.is_empty())
            .collect(),
        rule: FillRule::EvenOdd,
    }
}

/// Part of a curve that is replaced by a straight line.
struct Chord {
    segment: usize,
    /// Parameters of its ends.
    span: [f64; 2],
    ends: [DVec2; 2],
}

/// Flattened figures, rounded, in units of their size.
struct Chords {
    origin: DVec2,
    size: f64,
    segments: Vec<Segment>,
    chords: Vec<Chord>,
    /// The corners of each contour.
    contours: Vec<Vec<DVec2>>,
    /// Number of contours of each figure.
    counts: Vec<usize>,
    /// The exact ends of curves at their rounded places.
    ends: HashMap<[u64; 2], DVec2>,
    /// Chords by their heights.
    by_height: Strips,
}

/// Part of a curve between two of its parameters.
#[derive(Clone, Copy)]
struct CurvePiece {
    segment: Option<usize>,
    span: [f64; 2],
    start: DVec2,
}

impl Chords {
    fn new(figures: &[&Figure], origin: DVec2, size: f64) -> Chords {
        let mut error = CHORD_ERROR * size;
        let segments = || figures.iter().flat_map(|f| f.segments());
        let count = |error: f64| segments().map(|s| u64::from(s.chords(error))).sum::<u64>();
        while count(error) > MOST_CHORDS && error < 1e-3 * size {
            error *= 4.0;
        }
        let mut chords = Chords {
            origin,
            size,
            segments: segments().collect(),
            chords: Vec::new(),
            contours: Vec::new(),
            counts: figures.iter().map(|f| f.contours.len()).collect(),
            ends: HashMap::new(),
            by_height: Strips::new(Vec::new()),
        };
        let mut first = 0;
        for contour in figures.iter().flat_map(|f| &f.contours) {
            let next = first + contour.curves.len();
            chords.flatten(first..next, error);
            first = next;
        }
        let lines = chords.chords.iter().map(|chord| chord.ends);
        chords.by_height = Strips::new(lines.collect());
        chords
    }

    /// Adds the contour of some segments.
    fn flatten(&mut self, segments: std::ops::Range<usize>, error: f64) {
        let round = |p: DVec2| ((p - self.origin) / (self.size * GRID)).round() * GRID;
        let mut corners: Vec<DVec2> = Vec::new();
        for index in segments {
            let segment = self.segments[index];
            let count = segment.chords(error);
            let mut from = (0.0, round(segment.start()));
            corners.push(from.1);
            for step in 1..=count {
                let t = f64::from(step) / f64::from(count);
                let to = round(if step == count {
                    segment.end()
                } else {
                    segment.at(t)
                });
                if to == from.1 {
                    continue;
                }
                self.chords.push(Chord {
                    segment: index,
                    span: [from.0, t],
                    ends: [from.1, to],
                });
                corners.push(to);
                from = (t, to);
            }
            for end in [segment.start(), segment.end()] {
                self.ends.insert(key(round(end)), end);
            }
        }
        corners.dedup();
        self.contours.push(corners);
    }

    /// A triangulation that has all chords as edges, divided where they cross.
    fn triangulated(&self) -> Delaunay {
        let edges: Vec<_> = self.chords.iter().map(|chord| chord.ends).collect();
        let corners = edges.iter().flatten().map(|p| Point2::new(p.x, p.y));
        let mut mesh = Delaunay::bulk_load(corners.collect()).unwrap_or_default();
        add_edges(&mut mesh, edges, GRID);
        mesh
    }

    /// What counts how often each figure winds around a point, and its rule.
    fn windings(&self, figures: &[&Figure]) -> Vec<(Strips, FillRule)> {
        let mut rest = &self.contours[..];
        let strips = |(figure, count): (&&Figure, &usize)| {
            let (own, others) = rest.split_at(*count);
            rest = others;
            let edges = own.iter().flat_map(|corners| {
                let next = corners.iter().cycle().skip(1);
                corners.iter().zip(next).map(|(a, b)| [*a, *b])
            });
            (Strips::new(edges.collect()), figure.rule)
        };
        figures.iter().zip(&self.counts).map(strips).collect()
    }

    /// A closed chain of corners as a contour of the curves that it follows.
    fn contour(&self, corners: &[u32], points: &[DVec2]) -> Contour {
        let place = |k: usize| points[corners[k % corners.len()] as usize];
        let mut pieces: Vec<CurvePiece> = Vec::new();
        for k in 0..corners.len() {
            let piece = self.piece([place(k), place(k + 1)]);
            match pieces.last_mut().filter(|last| last.goes_on(&piece)) {
                Some(last) => last.span[1] = piece.span[1],
                None => pieces.push(piece),
            }
        }
        // The chain may begin within a curve.
        if let [first, .., last] = &mut pieces[..]
            && last.goes_on(first)
        {
            first.span[0] = last.span[0];
            first.start = last.start;
            pieces.pop();
        }
        Contour {
            curves: pieces.iter().map(|piece| self.curve(piece)).collect(),
        }
    }

    /// The part of a curve that an edge of the border lies on.
    fn piece(&self, [from, to]: [DVec2; 2]) -> CurvePiece {
        let middle = 0.5 * (from + to);
        let heights = [-1e-12, 0.0, 1e-12].map(|off| middle.y + off);
        let near = heights.into_iter().flat_map(|y| self.by_height.at(y));
        let off = |chord: &Chord| {
            let [a, b] = chord.ends;
            let along = b - a;
            let share = ((middle - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let slant = along.normalize().perp_dot((to - from).normalize_or_zero());
            (middle - a - share * along).length() + slant.abs() * (to - from).length()
        };
        let near = near.map(|&k| (off(&self.chords[k as usize]), k));
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((_, k)) = nearest.filter(|(off, _)| *off < NEAR) else {
            return CurvePiece {
                segment: None,
                span: [0.0, 1.0],
                start: from,
            };
        };
        let Chord {
            segment,
            span,
            ends,
        } = &self.chords[k as usize];
        let along = ends[1] - ends[0];
        let parameter = |p: DVec2| {
            let share = (p - ends[0]).dot(along) / along.length_squared();
            span[0] + share.clamp(0.0, 1.0) * (span[1] - span[0])
        };
        CurvePiece {
            segment: Some(*segment),
            span: [from, to].map(parameter),
            start: from,
        }
    }

    fn curve(&self, piece: &CurvePiece) -> Curve {
        let exact = self.ends.get(&key(piece.start)).copied();
        let start = exact.unwrap_or(self.origin + self.size * piece.start);
        let segment = piece.segment.map(|k| self.segments[k]);
        match segment {
            Some(segment @ Segment::Cubic([_, b, c, _])) => {
                let [t0, t1] = piece.span;
                let is_whole = (t1 - t0).abs() > 1.0 - NEAR;
                let (control1, control2) = if is_whole && t0 < t1 {
                    (b, c)
                } else if is_whole {
                    (c, b)
                } else {
                    let reach = (t1 - t0) / 3.0;
                    let leave = segment.at(t0) + reach * segment.derivative(t0);
                    (leave, segment.at(t1) - reach * segment.derivative(t1))
                };
                Curve::Cubic {
                    start,
                    control1,
                    control2,
                }
            }
            Some(Segment::Line(_)) | None => Curve::Line { start },
        }
    }
}

impl CurvePiece {
    /// Whether another piece continues this one along the same curve.
    fn goes_on(&self, next: &CurvePiece) -> bool {
        let way = |piece: &CurvePiece| (piece.span[1] - piece.span[0]).signum();
        self.segment.is_some()
            && self.segment == next.segment
            && (self.span[1] - next.span[0]).abs() < NEAR
            && way(self) == way(next)
    }
}

/// Edges as closed chains. Which ones where several meet does not matter to what is inside.
fn loops(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut leaving: HashMap<u32, Vec<u32>> = HashMap::new();
    for [from, to] in edges.iter().rev() {
        leaving.entry(*from).or_default().push(*to);
    }
    let mut loops = Vec::new();
    for [first, _] in edges {
        let mut corners = Vec::new();
        let mut at = *first;
        while let Some(next) = leaving.get_mut(&at).and_then(Vec::pop) {
            corners.push(at);
            at = next;
            if at == *first {
                break;
            }
        }
        if corners.len() > 1 {
            loops.push(corners);
        }
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    fn square(corner: DVec2, side: f64) -> Figure {
        let corners = [v(0.0, 0.0), v(1.0, 0.0), v(1.0, 1.0), v(0.0, 1.0)];
        Figure::polygon(corners.map(|c| corner + side * c))
    }

    /// A circle of four curves, exact to 3e-4 of its radius; its own area by them.
    fn disc(centre: DVec2, radius: f64) -> Figure {
        const REACH: f64 = 0.552_284_749_830_793_4;
        let quarter = |k: u32| {
            let turn = |p: DVec2| {
                centre
                    + radius
                        * DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_2).rotate(p)
            };
            Curve::Cubic {
                start: turn(v(1.0, 0.0)),
                control1: turn(v(1.0, REACH)),
                control2: turn(v(REACH, 1.0)),
            }
        };
        Figure {
            contours: vec![Contour {
                curves: (0..4).map(quarter).collect(),
            }],
            rule: FillRule::NonZero,
        }
    }

    fn area(figure: &Figure) -> f64 {
        figure.signed_area()
    }

    fn check(common: &Figure, curves: usize, expected: f64) {
        assert_eq!(common.curve_count(), curves, "{common:?}");
        let off = (area(common) - expected).abs();
        assert!(off < 1e-4, "{} {expected}", area(common));
    }

    #[test]
    fn figures_have_a_common_inside() {
        let disc_area = area(&disc(v(0.0, 0.0), 1.0));
        let disc = |x: f64, y: f64, r: f64| disc(v(x, y), r);
        let square = |x: f64, y: f64, side: f64| square(v(x, y), side);
        check(
            &square(0.0, 0.0, 2.0).intersection(&square(1.0, 1.0, 2.0)),
            4,
            1.0,
        );
        // Half and a quarter of a disc, whose centre is on a side or a corner.
        check(
            &disc(0.0, 0.0, 1.0).intersection(&square(0.0, -2.0, 4.0)),
            3,
            0.5 * disc_area,
        );
        check(
            &disc(0.0, 0.0, 1.0).intersection(&square(0.0, 0.0, 4.0)),
            3,
            0.25 * disc_area,
        );
        check(
            &disc(0.0, 0.0, 1.0).intersection(&square(-2.0, -2.0, 4.0)),
            4,
            disc_area,
        );
        check(
            &square(0.0, 0.0, 1.0).intersection(&square(5.0, 0.0, 1.0)),
            0,
            0.0,
        );
        // A ring, a disc without the quarter that is in a square, and nothing.
        let ring = disc(0.0, 0.0, 1.0).difference(&[&disc(0.0, 0.0, 0.5)]);
        check(&ring, 8, 0.75 * disc_area);
        let (quarter, whole) = (square(0.0, 0.0, 4.0), disc(0.0, 0.0, 1.0));
        check(&whole.difference(&[&quarter]), 5, 0.75 * disc_area);
        check(
            &whole.difference(&[&quarter, &square(-2.0, -2.0, 4.0)]),
            0,
            0.0,
        );
        // Two discs through each other's centres: 2π/3 − √3/2.
        let lens = 2.0 * std::f64::consts::PI / 3.0 - 0.75_f64.sqrt();
        let common = disc(0.0, 0.0, 1.0).intersection(&disc(1.0, 0.0, 1.0));
        assert!((area(&common) - lens).abs() < 1e-3, "{}", area(&common));
    }

    /// What other methods find hard: figures that repeat each other, or share part of a side.
    #[test]
    fn coinciding_curves_are_no_problem() {
        let whole = disc(v(3.0, 2.0), 0.7);
        check(&whole.intersection(&whole), 4, area(&whole));
        let side = square(v(0.0, 0.0), 2.0).intersection(&square(v(1.0, 0.0), 2.0));
        check(&side, 4, 2.0);
        let touching = square(v(0.0, 0.0), 1.0).intersection(&square(v(1.0, 0.0), 1.0));
        check(&touching, 0, 0.0);
        // Exactly the same numbers, where nothing is cut.
        let kept = whole.intersection(&square(v(0.0, 0.0), 9.0));
        let starts = |figure: &Figure| {
            let mut starts: Vec<_> = figure
                .segments()
                .map(|s| s.start().to_array().map(f64::to_bits))
                .collect();
            starts.sort_unstable();
            starts
        };
        assert_eq!(starts(&kept), starts(&whole));
    }

    #[test]
    fn rules_decide_what_is_inside() {
        let mut twice = square(v(0.0, 0.0), 3.0);
        twice.contours.extend(square(v(1.0, 1.0), 1.0).contours);
        let window = square(v(-1.0, -1.0), 9.0);
        let ring = twice.intersection(&window);
        check(&ring, 8, 8.0);
        assert!(!ring.contains(v(1.5, 1.5)) && ring.contains(v(0.5, 0.5)));
        twice.rule = FillRule::NonZero;
        check(&twice.outline(), 4, 9.0);
        let others = [square(v(2.0, 2.0), 2.0), square(v(9.0, 0.0), 1.0)];
        check(&Figure::union(&[&twice, &others[0], &others[1]]), 12, 13.0);
    }

    fn blob() -> impl Strategy<Value = Figure> {
        let place = || (0..5000i32).prop_map(|x| 1e-3 * f64::from(x));
        let point = || (place(), place()).prop_map(|(x, y)| v(x, y));
        let curve = (point(), point(), point(), any::<bool>()).prop_map(
            |(start, control1, control2, bends)| {
                if bends {
                    Curve::Cubic {
                        start,
                        control1,
                        control2,
                    }
                } else {
                    Curve::Line { start }
                }
            },
        );
        let contour = prop::collection::vec(curve, 2..7).prop_map(|curves| Contour { curves });
        let rule = prop_oneof![Just(FillRule::EvenOdd), Just(FillRule::NonZero)];
        (prop::collection::vec(contour, 1..4), rule)
            .prop_map(|(contours, rule)| Figure { contours, rule })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn points_are_inside_where_they_are_in_both(a in blob(), b in blob()) {
            let common = a.intersection(&b);
            let mut wrong = 0;
            for k in 0..400u32 {
                let share = f64::from(k) * v(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
                let p = 5.0 * share.fract();
                wrong += usize::from(common.contains(p) != (a.contains(p) && b.contains(p)));
            }
            // Points on curves may be on either side.
            prop_assert!(wrong <= 1, "{wrong} of 400");
        }
    }
}
