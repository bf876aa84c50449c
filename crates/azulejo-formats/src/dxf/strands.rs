//! Stretches of outlines, and the loops that they form where their ends meet.

use azulejo_scene::figure::{Rectangle, Segment};
use azulejo_scene::{Contour, Curve};
use glam::{DAffine2, DVec2};
use std::collections::{HashMap, HashSet};

/// Ends that are nearer than this, relative to the diagonal of the drawing, are one point: files keep six digits or more.
const MEETING: f64 = 1e-5;

/// Strands between the same ends that are compared to find those drawn twice.
const COMPARED: usize = 8;

/// Corners of a hull that are looked at.
const MOST_CORNERS: usize = 256;

/// Curves one after another, from one end to another.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Strand {
    /// At least one.
    pub segments: Vec<Segment>,
    /// Where it is in the file.
    pub offset: usize,
}

/// What strands become.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// Closed outlines.
    pub loops: Vec<Contour>,
    /// The others.
    pub open: Vec<OpenOutline>,
}

/// Strands that meet, but enclose nothing.
#[derive(Debug)]
pub(super) struct OpenOutline {
    /// The strands.
    pub strands: Vec<Strand>,
    /// Where it ends, or branches.
    pub place: DVec2,
    /// Whether more than two strands meet somewhere.
    pub branches: bool,
}

impl Strand {
    fn start(&self) -> DVec2 {
        self.segments.first().map_or(DVec2::ZERO, Segment::start)
    }

    fn end(&self) -> DVec2 {
        self.segments.last().map_or(DVec2::ZERO, Segment::end)
    }

    /// All points that define it.
    pub fn points(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.segments.iter().flat_map(|s| points(s).iter().copied())
    }

    /// The strand under a map.
    pub fn mapped(&self, map: &DAffine2) -> Strand {
        let place = |p: DVec2| map.transform_point2(p);
        let segments = self.segments.iter().map(|segment| match *segment {
            Segment::Line(ends) => Segment::Line(ends.map(place)),
            Segment::Cubic(controls) => Segment::Cubic(controls.map(place)),
        });
        Strand {
            segments: segments.collect(),
            offset: self.offset,
        }
    }

    fn reversed(&self) -> Strand {
        let segments = self.segments.iter().rev().map(|segment| match *segment {
            Segment::Line([a, b]) => Segment::Line([b, a]),
            Segment::Cubic([a, b, c, d]) => Segment::Cubic([d, c, b, a]),
        });
        Strand {
            segments: segments.collect(),
            offset: self.offset,
        }
    }

    /// Whether it is the same curve, in the same direction.
    fn is_near(&self, other: &Strand, tolerance: f64) -> bool {
        self.segments.len() == other.segments.len()
            && self.points().count() == other.points().count()
            && (self.points().zip(other.points())).all(|(a, b)| a.distance(b) <= tolerance)
    }
}

fn points(segment: &Segment) -> &[DVec2] {
    match segment {
        Segment::Line(ends) => ends,
        Segment::Cubic(controls) => controls,
    }
}

/// The smallest rectangle around all of some strands.
pub(super) fn bounds<'s>(strands: impl IntoIterator<Item = &'s Strand>) -> Rectangle {
    let all = strands.into_iter().flat_map(Strand::points);
    let none = Rectangle {
        min: DVec2::INFINITY,
        max: DVec2::NEG_INFINITY,
    };
    all.fold(none, |r, p| Rectangle {
        min: r.min.min(p),
        max: r.max.max(p),
    })
}

/// How near ends must be to meet, in a drawing of these bounds.
pub(super) fn tolerance(bounds: Rectangle) -> f64 {
    let diagonal = (bounds.max - bounds.min).length();
    if diagonal.is_finite() {
        MEETING * diagonal
    } else {
        0.0
    }
}

/// Joins strands. What is drawn twice counts once; what ends in nothing is open, and so are lines of which an odd
/// number meets: which of them bound something is not known. Where four or more meet they may be joined in any way, as
/// figures are filled by the even-odd rule.
pub(super) fn join(strands: Vec<Strand>, tolerance: f64) -> Joined {
    let mut joined = Joined::default();
    let mut apart = Vec::new();
    for strand in strands {
        let is_closed = strand.start().distance(strand.end()) <= tolerance;
        let around = bounds([&strand]);
        let size = (around.max - around.min).length();
        match is_closed {
            true if size > tolerance => joined.loops.push(contour(&[strand])),
            // A point.
            true => {}
            false => apart.push(strand),
        }
    }
    let mut graph = StrandGraph::new(apart, tolerance);
    graph.drop_doubles(tolerance);
    let ending = graph.prune();
    joined.open = graph.components(&ending, false);
    let branching = graph.branching();
    joined.open.extend(graph.components(&branching, true));
    joined.loops.extend(graph.loops());
    joined
}

/// A closed outline of strands, each of which begins where the one before it ends.
fn contour(strands: &[Strand]) -> Contour {
    let segments = strands.iter().flat_map(|s| &s.segments);
    let curves = segments.map(|segment| match *segment {
        Segment::Line([start, _]) => Curve::Line { start },
        Segment::Cubic([start, control1, control2, _]) => Curve::Cubic {
            start,
            control1,
            control2,
        },
    });
    Contour {
        curves: curves.collect(),
    }
}

/// Strands between the points at which their ends meet.
struct StrandGraph {
    strands: Vec<Strand>,
    /// The numbers of the points at the ends of each strand.
    ends: Vec<[usize; 2]>,
    places: Vec<DVec2>,
    /// The strands at each point; a strand whose ends are the same point is there twice.
    at: Vec<Vec<usize>>,
    /// Whether a strand is still to be joined.
    is_left: Vec<bool>,
}

impl StrandGraph {
    fn new(strands: Vec<Strand>, tolerance: f64) -> StrandGraph {
        let mut places: Vec<DVec2> = Vec::new();
        // Points in cells of twice the tolerance: those that are near are in the same or in one beside it.
        let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
        let cell = |p: DVec2| (p / (2.0 * tolerance)).floor().to_array().map(|x| x as i64);
        let mut numbered = |p: DVec2| {
            let [x, y] = cell(p);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let near = cells.get(&[x.saturating_add(dx), y.saturating_add(dy)]);
                let mut near = near.into_iter().flatten();
                if let Some(&known) = near.find(|&&k: &&usize| places[k].distance(p) <= tolerance) {
                    return known;
                }
            }
            cells.entry([x, y]).or_default().push(places.len());
            places.push(p);
            places.len() - 1
        };
        let ends: Vec<[usize; 2]> = strands
            .iter()
            .map(|s| [numbered(s.start()), numbered(s.end())])
            .collect();
        let mut at = vec![Vec::new(); places.len()];
        for (k, ends) in ends.iter().enumerate() {
            ends.iter().for_each(|&place| at[place].push(k));
        }
        StrandGraph {
            is_left: vec![true; strands.len()],
            strands,
            ends,
            places,
            at,
        }
    }

    fn degree(&self, place: usize) -> usize {
        self.at[place].iter().filter(|&&k| self.is_left[k]).count()
    }

    /// Leaves out strands that are drawn twice.
    fn drop_doubles(&mut self, tolerance: f64) {
        let mut known: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
        for k in 0..self.strands.len() {
            let [a, b] = self.ends[k];
            let before = known.entry([a.min(b), a.max(b)]).or_default();
            let is_double = before.iter().rev().take(COMPARED).any(|&other| {
                let other = &self.strands[other];
                let strand = &self.strands[k];
                strand.is_near(other, tolerance) || strand.reversed().is_near(other, tolerance)
            });
            if is_double {
                self.is_left[k] = false;
            } else {
                before.push(k);
            }
        }
    }

    /// Takes away, one after another, strands with an end at which there is no other.
    fn prune(&mut self) -> Vec<usize> {
        let mut degrees: Vec<usize> = (0..self.places.len()).map(|p| self.degree(p)).collect();
        let mut ends: Vec<usize> = (0..degrees.len()).filter(|&p| degrees[p] == 1).collect();
        let mut pruned = Vec::new();
        while let Some(place) = ends.pop() {
            let strand = self.at[place].iter().find(|&&k| self.is_left[k]);
            let Some(&strand) = strand else { continue };
            self.is_left[strand] = false;
            pruned.push(strand);
            for place in self.ends[strand] {
                degrees[place] -= 1;
                if degrees[place] == 1 {
                    ends.push(place);
                }
            }
        }
        pruned.sort_unstable();
        pruned
    }

    /// Takes away all strands that are connected with a point at which an odd number of them meets.
    fn branching(&mut self) -> Vec<usize> {
        let mut places: Vec<usize> = (0..self.places.len())
            .filter(|&p| self.degree(p) % 2 == 1)
            .collect();
        let mut found = Vec::new();
        while let Some(place) = places.pop() {
            // No point is looked at twice.
            for k in std::mem::take(&mut self.at[place]) {
                if std::mem::replace(&mut self.is_left[k], false) {
                    found.push(k);
                    places.extend(self.ends[k]);
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// Some strands by which of them are connected.
    fn components(&self, chosen: &[usize], branches: bool) -> Vec<OpenOutline> {
        let mut at: HashMap<usize, Vec<usize>> = HashMap::new();
        for &k in chosen {
            self.ends[k]
                .iter()
                .for_each(|&place| at.entry(place).or_default().push(k));
        }
        let counts: HashMap<usize, usize> = at.iter().map(|(&p, list)| (p, list.len())).collect();
        let mut left: HashSet<usize> = chosen.iter().copied().collect();
        let mut found = Vec::new();
        for &first in chosen {
            if !left.remove(&first) {
                continue;
            }
            let (mut strands, mut places) = (vec![first], self.ends[first].to_vec());
            while let Some(place) = places.pop() {
                for k in at.remove(&place).unwrap_or_default() {
                    if left.remove(&k) {
                        strands.push(k);
                        places.extend(self.ends[k]);
                    }
                }
            }
            strands.sort_unstable();
            // The first point in the order of the file that is an end, or at which it branches.
            let mut in_order = strands.iter().flat_map(|&k| self.ends[k]);
            let all = strands.iter().flat_map(|&k| self.ends[k]);
            let most = all.map(|place| counts[&place]).max().unwrap_or(0);
            let is_odd = |place: &usize| counts[place] % 2 == 1 && (!branches || counts[place] > 2);
            let place = in_order.find(is_odd).unwrap_or(self.ends[first][0]);
            found.push(OpenOutline {
                place: self.places[place],
                branches: branches || most > 2,
                strands: strands.iter().map(|&k| self.strands[k].clone()).collect(),
            });
        }
        found
    }

    /// What is left, of which an even number meets everywhere, as loops.
    fn loops(&mut self) -> Vec<Contour> {
        let mut loops = Vec::new();
        let mut next = vec![0; self.places.len()];
        for first in 0..self.strands.len() {
            if !self.is_left[first] {
                continue;
            }
            // Walk on until a point of the way is reached again, cut off that loop, and go on.
            let mut way: Vec<(usize, Strand)> = Vec::new();
            let mut step_of: HashMap<usize, usize> = HashMap::new();
            let mut place = self.ends[first][0];
            loop {
                if let Some(&step) = step_of.get(&place) {
                    let cut: Vec<(usize, Strand)> = way.drain(step..).collect();
                    cut.iter().for_each(|(from, _)| _ = step_of.remove(from));
                    let strands: Vec<Strand> = cut.into_iter().map(|(_, strand)| strand).collect();
                    loops.push(contour(&strands));
                }
                let at = &self.at[place];
                while next[place] < at.len() && !self.is_left[at[next[place]]] {
                    next[place] += 1;
                }
                let Some(&k) = at.get(next[place]) else { break };
                self.is_left[k] = false;
                let [from, to] = self.ends[k];
                let (strand, other) = if from == place {
                    (self.strands[k].clone(), to)
                } else {
                    (self.strands[k].reversed(), from)
                };
                step_of.insert(place, way.len());
                way.push((place, strand));
                place = other;
            }
        }
        loops
    }
}

impl OpenOutline {
    /// Whether it goes around one of some rectangles, as far as its convex hull says.
    pub fn surrounds(&self, inner: &[Rectangle]) -> bool {
        let hull = convex_hull(self.strands.iter().flat_map(Strand::points).collect());
        // Part of the corners of a round one will do.
        let step = hull.len().div_ceil(MOST_CORNERS).max(1);
        let hull: Vec<DVec2> = hull.into_iter().step_by(step).collect();
        let sides = || hull.iter().zip(hull.iter().cycle().skip(1));
        let has = |p: DVec2| sides().all(|(a, b)| (b - a).perp_dot(p - a) >= 0.0);
        let is_in = |r: &Rectangle| {
            has(r.min)
                && has(r.max)
                && has(DVec2::new(r.max.x, r.min.y))
                && has(DVec2::new(r.min.x, r.max.y))
        };
        hull.len() > 2 && inner.iter().any(is_in)
    }
}

/// Counter-clockwise, by Andrew's monotone chain (1979).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut hull: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = hull[..]
                && (b - a).perp_dot(p - a) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Figure, FillRule};

    fn line(a: [f64; 2], b: [f64; 2]) -> Strand {
        Strand {
            segments: vec![Segment::Line([a.into(), b.into()])],
            offset: 0,
        }
    }

    fn lines(ends: &[[f64; 4]]) -> Vec<Strand> {
        let all = ends.iter().map(|[a, b, c, d]| line([*a, *b], [*c, *d]));
        all.collect()
    }

    /// Numbers of loops and of open outlines, and the area.
    fn check(ends: &[[f64; 4]], loops: usize, open: usize, area: f64) -> Joined {
        let strands = lines(ends);
        let near = tolerance(bounds(&strands));
        let joined = join(strands, near);
        assert_eq!(
            (joined.loops.len(), joined.open.len()),
            (loops, open),
            "{ends:?}"
        );
        let figure = Figure {
            contours: joined.loops.clone(),
            rule: FillRule::EvenOdd,
        };
        let sum: f64 = (figure.contours.iter())
            .map(|c| {
                Figure {
                    contours: vec![c.clone()],
                    rule: FillRule::EvenOdd,
                }
                .signed_area()
                .abs()
            })
            .sum();
        assert!((sum - area).abs() < 1e-3, "{sum}");
        joined
    }

    const SQUARE: [[f64; 4]; 4] = [
        [0.0, 0.0, 2.0, 0.0],
        [2.0, 2.0, 2.0, 0.0],
        [0.0, 2.0, 0.0, 0.0],
        [2.0, 2.0, 0.0, 2.0],
    ];

    #[test]
    fn lines_in_any_order_and_direction() {
        check(&SQUARE, 1, 0, 4.0);
        // Ends that are apart by rounding.
        let mut rounded = SQUARE;
        rounded[2][0] = 1e-5;
        check(&rounded, 1, 0, 4.0);
        // One side is drawn twice.
        let mut doubled = SQUARE.to_vec();
        doubled.push([2.0, 0.0, 0.0, 0.0]);
        check(&doubled, 1, 0, 4.0);
        // A line that ends in nothing is left out alone.
        doubled.push([2.0, 2.0, 5.0, 3.0]);
        let joined = check(&doubled, 1, 1, 4.0);
        assert!(!joined.open[0].branches);
        // Two squares that share a corner.
        let mut two = SQUARE.to_vec();
        two.extend(SQUARE.map(|side| side.map(|x| x + 2.0)));
        check(&two, 2, 0, 8.0);
    }

    #[test]
    fn what_encloses_nothing_is_open() {
        let gap = check(&SQUARE[..3], 0, 1, 0.0);
        assert_eq!(gap.open[0].place, DVec2::new(2.0, 2.0));
        assert_eq!(gap.open[0].strands.len(), 3);
        let inner = |x: f64, y: f64| Rectangle {
            min: DVec2::new(x, y),
            max: DVec2::new(x + 0.5, y + 0.5),
        };
        assert!(gap.open[0].surrounds(&[inner(1.8, 0.5), inner(0.5, 0.5)]));
        assert!(!gap.open[0].surrounds(&[inner(1.8, 0.5)]));
        // A square with a wall between two corners, of which it is not known whether it is one.
        let mut divided = SQUARE.to_vec();
        divided.push([0.0, 0.0, 2.0, 2.0]);
        let divided = check(&divided, 0, 1, 0.0);
        assert!(divided.open[0].branches);
        assert_eq!(divided.open[0].place, DVec2::ZERO);
        // A cross is no outline around anything.
        let cross = [
            [-3.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 3.0, 0.0],
            [0.0, 0.0, 0.0, 3.0],
            [0.0, 0.0, 0.0, -3.0],
        ];
        assert!(check(&cross, 0, 1, 0.0).open[0].branches);
        check(&[[1.0, 1.0, 1.0, 1.0]], 0, 0, 0.0);
    }
}
