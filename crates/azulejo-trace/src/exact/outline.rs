//! A plane figure prepared for queries: the curves that a line crosses, and the winding number of a
//! point.

use crate::kernel::{Vectorized, vectorized};
use azulejo_scene::figure::{Rectangle, Segment, bernstein, crossings};
use azulejo_scene::{Contour, Figure, FillRule};
use glam::DVec2;

/// Children of one node.
const WIDTH: usize = 4;

/// Size of the stack of nodes: the tree's depth is at most 16 levels over the contours and 16
/// within one, and each level leaves [`WIDTH`] − 1 siblings.
const STACK: usize = 2 * 16 * WIDTH;

/// See [`Outline::sliver`]; relative to the figure's size.
const SLIVER: f64 = 1e-10;

/// A figure with its curves in a tree of runs: consecutive curves of a contour, and above them
/// whole contours.
///
/// A line has two sides, and points on it belong to one of them. The signed number of crossings of
/// a run with the line depends only on the sides of the run's two ends; so a run entirely beyond
/// the relevant part of the line need not be visited. Sides are evaluated at the joints of curves
/// only, by the one expression [`Line2::side`]: both neighbours agree on it, and all crossings of a
/// closed contour sum to zero in spite of rounding. A line that enters also leaves.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub rule: FillRule,
    pub bounds: Rectangle,
    /// Crossings closer than this have nothing between them: they come from the rounding of
    /// coincident contours.
    pub sliver: f64,
    /// Control points; those of a straight line divide it into thirds.
    curves: Vec<[DVec2; 4]>,
    nodes: Vec<RunNode>,
    /// The root of the tree, if the figure has any curve.
    root: Option<u32>,
}

/// Four runs in SIMD layout. Unused ones hold NaN, which no line crosses.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
struct RunNode {
    /// Lowest and highest x, lowest and highest y.
    sides: [[f64; WIDTH]; 4],
    /// x and y of the runs' starts.
    starts: [[f64; WIDTH]; 2],
    /// x and y of the runs' ends.
    ends: [[f64; WIDTH]; 2],
    /// A node, or a curve with one of the flags below.
    children: [u32; WIDTH],
}

/// Flag of a child that is a curve.
const CUBIC: u32 = 1 << 31;
/// Flag, together with [`CUBIC`], of a curve that is a straight line.
const STRAIGHT: u32 = 1 << 30;
const INDEX: u32 = STRAIGHT - 1;

/// One or more consecutive curves, or whole contours.
#[derive(Clone, Copy)]
struct CurveRun {
    bounds: Rectangle,
    start: DVec2,
    end: DVec2,
    child: u32,
}

/// A line in the figure's plane, with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line2 {
    direction: DVec2,
    normal: DVec2,
    /// Products of `normal` and `direction` with the line's origin.
    offset: f64,
    start: f64,
}

/// A crossing of a line with a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Distance along the line.
    pub s: f64,
    /// How much farther the crossing may be; 0 where the curve was solved for it.
    pub spread: f64,
    /// Whether the contour crosses to the line's left (1) or from there (−1).
    pub sense: i32,
    /// Index of the curve.
    pub curve: u32,
    /// Parameter of the crossing on the curve, 0..=1.
    pub parameter: f64,
}

impl Line2 {
    /// A line with a unit `direction`.
    pub(crate) fn new(origin: DVec2, direction: DVec2) -> Line2 {
        let normal = direction.perp();
        Line2 {
            direction,
            normal,
            offset: normal.x * origin.x + normal.y * origin.y,
            start: direction.x * origin.x + direction.y * origin.y,
        }
    }

    /// Signed distance of a point, left positive. Monotonic in each coordinate in spite of
    /// rounding.
    #[inline(always)]
    fn distance(&self, p: DVec2) -> f64 {
        self.normal.x * p.x + self.normal.y * p.y - self.offset
    }

    /// Which side a point is on: 1 on the left and on the line itself, 0 on the right.
    #[inline(always)]
    fn side(&self, p: DVec2) -> i32 {
        i32::from(self.distance(p) >= 0.0)
    }

    /// The position of a point along the line.
    #[inline(always)]
    fn along(&self, p: DVec2) -> f64 {
        self.direction.x * p.x + self.direction.y * p.y - self.start
    }
}

/// The runs of a node that a line crosses.
struct RunsCrossed {
    /// Runs to visit, one bit per run.
    open: u32,
    /// Signed crossings of the runs that are entirely ahead.
    beyond: i32,
}

impl Outline {
    pub(crate) fn new(figure: &Figure) -> Outline {
        let mut outline = Outline {
            rule: figure.rule,
            bounds: Rectangle::EMPTY,
            sliver: 0.0,
            curves: Vec::with_capacity(figure.curve_count()),
            nodes: Vec::with_capacity(figure.curve_count() / 2),
            root: None,
        };
        let contours = figure.contours.iter();
        let whole = contours.filter_map(|c| outline.add_contour(c)).collect();
        if let Some(run) = outline.pack(whole) {
            outline.bounds = run.bounds;
            outline.sliver = SLIVER * run.bounds.size().max_element();
            outline.root = Some(run.child);
        }
        outline
    }

    /// The control points of the curve of a [`Crossing`].
    pub(crate) fn curve(&self, curve: u32) -> &[DVec2; 4] {
        &self.curves[curve as usize]
    }

    fn add_contour(&mut self, contour: &Contour) -> Option<CurveRun> {
        let runs = contour.segments().map(|s| self.add_curve(s)).collect();
        self.pack(runs)
    }

    fn add_curve(&mut self, segment: Segment) -> CurveRun {
        let index = self.curves.len() as u32;
        assert!(index < INDEX, "a figure has at most 2^30 curves");
        let (points, child) = match segment {
            Segment::Line([a, b]) => {
                let third = (b - a) / 3.0;
                ([a, a + third, b - third, b], CUBIC | STRAIGHT | index)
            }
            Segment::Cubic(points) => (points, CUBIC | index),
        };
        self.curves.push(points);
        CurveRun {
            bounds: segment.bounds(),
            start: points[0],
            end: points[3],
            child,
        }
    }

    /// Joins consecutive runs to one; `None` if there are none.
    fn pack(&mut self, mut runs: Vec<CurveRun>) -> Option<CurveRun> {
        while runs.len() > 1 {
            let groups = runs.len().div_ceil(WIDTH);
            let cut = |k: usize| k * runs.len() / groups;
            let group = |k: usize| self.add_node(&runs[cut(k)..cut(k + 1)]);
            runs = (0..groups).map(group).collect();
        }
        runs.pop()
    }

    fn add_node(&mut self, runs: &[CurveRun]) -> CurveRun {
        if let [alone] = runs {
            return *alone;
        }
        let mut node = RunNode::EMPTY;
        for (k, run) in runs.iter().enumerate() {
            node.set(k, run);
        }
        self.nodes.push(node);
        CurveRun {
            bounds: (runs.iter()).fold(Rectangle::EMPTY, |b, r| b.union(r.bounds)),
            start: runs[0].start,
            // Several whole contours have no ends, because each is closed.
            end: if runs.iter().all(|r| r.start == r.end) {
                runs[0].start
            } else {
                runs[runs.len() - 1].end
            },
            child: self.nodes.len() as u32 - 1,
        }
    }

    /// Visits the crossings between `s0` and `s1`, in any order. The visitor returns the position
    /// up to which further crossings matter, or `None` to stop.
    ///
    /// Returns the winding number of the point at `s0`, with crossings at that very point being
    /// ahead of it; the number is meaningless if the visitor stopped.
    pub(crate) fn cross(
        &self,
        line: &Line2,
        range: [f64; 2],
        visit: impl FnMut(Crossing) -> Option<f64>,
    ) -> i32 {
        vectorized(CrossLine::<true, _> {
            outline: self,
            line,
            range,
            visit,
        })
    }

    /// [`cross`](Outline::cross), but a curve between `s0` and `s1` with its ends on different sides is visited once,
    /// without solving for where the line crosses it. A range visited is where it may do so, and the parameter is
    /// arbitrary.
    pub(crate) fn cross_roughly(
        &self,
        line: &Line2,
        range: [f64; 2],
        visit: impl FnMut(Crossing) -> Option<f64>,
    ) -> i32 {
        vectorized(CrossLine::<false, _> {
            outline: self,
            line,
            range,
            visit,
        })
    }

    /// [`cross`](Outline::cross), compiled for the instruction set of the caller.
    #[inline(always)]
    fn cross_here<const SOLVED: bool>(
        &self,
        line: &Line2,
        [s0, mut s1]: [f64; 2],
        mut visit: impl FnMut(Crossing) -> Option<f64>,
    ) -> i32 {
        let mut winding = 0;
        let mut stack = [0; STACK];
        let mut waiting = 0;
        let Some(mut current) = self.root else {
            return 0;
        };
        loop {
            if current & CUBIC == 0 {
                let node = &self.nodes[current as usize];
                let met = node.meet(line, [s0, s1]);
                winding += met.beyond;
                let mut open = met.open;
                while open != 0 {
                    stack[waiting % STACK] = node.children[open.trailing_zeros() as usize % WIDTH];
                    open &= open - 1;
                    waiting += 1;
                }
            } else {
                for crossing in self
                    .meet::<SOLVED>(line, current, [s0, s1])
                    .into_iter()
                    .flatten()
                {
                    if crossing.s < s0 {
                        continue;
                    }
                    winding += crossing.sense;
                    if crossing.s <= s1 {
                        let Some(last) = visit(crossing) else {
                            return winding;
                        };
                        s1 = last;
                    }
                }
            }
            if waiting == 0 {
                return winding;
            }
            waiting -= 1;
            current = stack[waiting % STACK];
        }
    }

    /// The crossings with one curve. A curve entirely ahead gets a single crossing at infinity for
    /// all.
    #[inline(always)]
    fn meet<const SOLVED: bool>(
        &self,
        line: &Line2,
        child: u32,
        [s0, s1]: [f64; 2],
    ) -> [Option<Crossing>; 3] {
        let curve = child & INDEX;
        let points = &self.curves[curve as usize];
        let d = points.map(|p| line.distance(p));
        let sides = d.map(|d| d >= 0.0);
        if sides[0] == sides[1] && sides[1] == sides[2] && sides[2] == sides[3] {
            return [None; 3];
        }
        let s = points.map(|p| line.along(p));
        if s.iter().all(|&s| s < s0) {
            return [None; 3];
        }
        let crossing = |s: f64, parameter: f64, sense: i32| Crossing {
            s,
            spread: 0.0,
            sense,
            curve,
            parameter,
        };
        if s.iter().all(|&s| s > s1) {
            let sense = i32::from(sides[3]) - i32::from(sides[0]);
            return [Some(crossing(f64::INFINITY, 1.0, sense)), None, None];
        }
        if !SOLVED && sides[0] != sides[3] {
            let low = s[0].min(s[1]).min(s[2].min(s[3]));
            let high = s[0].max(s[1]).max(s[2].max(s[3]));
            if s0 <= low && high <= s1 {
                let sense = i32::from(sides[3]) - i32::from(sides[0]);
                let rough = Crossing {
                    spread: high - low,
                    ..crossing(low, 0.0, sense)
                };
                return [Some(rough), None, None];
            }
        }
        if child & STRAIGHT != 0 {
            // Only its ends are exact; the inner control points are rounded.
            let sense = i32::from(sides[3]) - i32::from(sides[0]);
            let t = (d[0] / (d[0] - d[3])).clamp(0.0, 1.0);
            let at = crossing(s[0] + t * (s[3] - s[0]), t, sense);
            return [(sense != 0).then_some(at), None, None];
        }
        let root = |(t, sense): (f64, i32)| crossing(bernstein(s, t), t, sense);
        crossings(d).map(|r| r.map(root))
    }
}

/// [`Outline::cross`] as vectorized work: the four runs of a node are tested at once.
struct CrossLine<'a, const SOLVED: bool, V> {
    outline: &'a Outline,
    line: &'a Line2,
    range: [f64; 2],
    visit: V,
}

impl<const SOLVED: bool, V> Vectorized for CrossLine<'_, SOLVED, V>
where
    V: FnMut(Crossing) -> Option<f64>,
{
    type Output = i32;

    #[inline(always)]
    fn run(self) -> i32 {
        (self.outline).cross_here::<SOLVED>(self.line, self.range, self.visit)
    }
}

impl RunNode {
    const EMPTY: RunNode = RunNode {
        sides: [[f64::NAN; WIDTH]; 4],
        starts: [[f64::NAN; WIDTH]; 2],
        ends: [[f64::NAN; WIDTH]; 2],
        children: [0; WIDTH],
    };

    fn set(&mut self, slot: usize, run: &CurveRun) {
        let (min, max) = (run.bounds.min, run.bounds.max);
        for axis in 0..2 {
            self.sides[2 * axis][slot] = min[axis];
            self.sides[2 * axis + 1][slot] = max[axis];
            self.starts[axis][slot] = run.start[axis];
            self.ends[axis][slot] = run.end[axis];
        }
        self.children[slot] = run.child;
    }

    /// Tests the rectangles of all four runs.
    ///
    /// The extremes of distance are at two corners of the rectangle, computed by the same
    /// expressions as for points: no point of the run is beyond them.
    #[inline(always)]
    fn meet(&self, line: &Line2, [s0, s1]: [f64; 2]) -> RunsCrossed {
        let (n, u) = (line.normal, line.direction);
        let (nx, ny) = (usize::from(n.x < 0.0), usize::from(n.y < 0.0));
        let (ux, uy) = (usize::from(u.x < 0.0), usize::from(u.y < 0.0));
        let x = |side: usize| &self.sides[side];
        let y = |side: usize| &self.sides[2 + side];
        let mut met = RunsCrossed { open: 0, beyond: 0 };
        let (mut open, mut ahead) = ([false; WIDTH], [false; WIDTH]);
        for k in 0..WIDTH {
            let low = n.x * x(nx)[k] + n.y * y(ny)[k] - line.offset;
            let high = n.x * x(1 - nx)[k] + n.y * y(1 - ny)[k] - line.offset;
            let first = u.x * x(ux)[k] + u.y * y(uy)[k] - line.start;
            let last = u.x * x(1 - ux)[k] + u.y * y(1 - uy)[k] - line.start;
            // Comparisons with NaN are false.
            let matters = (low < 0.0) & (high >= 0.0) & (last >= s0);
            open[k] = matters & (first <= s1);
            ahead[k] = matters & (first > s1);
        }
        for k in 0..WIDTH {
            met.open |= u32::from(open[k]) << k;
            if ahead[k] {
                let point = |of: &[[f64; WIDTH]; 2]| DVec2::new(of[0][k], of[1][k]);
                met.beyond += line.side(point(&self.ends)) - line.side(point(&self.starts));
            }
        }
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Curve;

    /// `count` rings of `curves` waves each, side by side, every other one reversed.
    fn rings(count: usize, curves: usize) -> Figure {
        let ring = |k: usize| {
            let centre = DVec2::new((k % 7) as f64, (k / 7) as f64);
            let at = |j: usize| {
                let angle = std::f64::consts::TAU * j as f64 / (3 * curves) as f64;
                let angle = if k.is_multiple_of(2) { angle } else { -angle };
                centre + (0.6 + 0.1 * (5.0 * angle).sin()) * DVec2::from_angle(angle)
            };
            let curve = |j: usize| match (k + j) % 3 {
                0 => Curve::Line { start: at(3 * j) },
                _ => Curve::Cubic {
                    start: at(3 * j),
                    control1: at(3 * j + 1),
                    control2: at(3 * j + 2),
                },
            };
            Contour {
                curves: (0..curves).map(curve).collect(),
            }
        };
        Figure {
            contours: (0..count).map(ring).collect(),
            rule: FillRule::NonZero,
        }
    }

    fn ray(from: DVec2, angle: f64) -> Line2 {
        Line2::new(from, DVec2::from_angle(angle))
    }

    /// All crossings, by the best instruction set of this machine or in plain Rust.
    fn listed(outline: &Outline, line: &Line2, plain: bool) -> Vec<Crossing> {
        let mut crossings = Vec::new();
        let list = |crossing: Crossing| {
            crossings.push(crossing);
            Some(f64::INFINITY)
        };
        let half = [0.0, f64::INFINITY];
        if plain {
            outline.cross_here::<true>(line, half, list)
        } else {
            outline.cross(line, half, list)
        };
        crossings
    }

    #[test]
    fn windings_are_those_of_the_figure_in_every_direction() {
        for (count, curves) in [(1, 1), (1, 3), (2, 5), (5, 2), (23, 9), (60, 40)] {
            let figure = rings(count, curves);
            let outline = Outline::new(&figure);
            let (low, size) = (outline.bounds.min, outline.bounds.size());
            for k in 0..2000 {
                let at = DVec2::new(f64::from(k % 47) / 46.0, f64::from(k / 47) / 42.0);
                let point = low + at * size;
                let line = ray(point, f64::from(k));
                let none = |crossing: Crossing| Some(crossing.s.min(0.0));
                // With the crossings counted one by one, and with all of them far ahead.
                let winding = outline.cross(&line, [0.0, f64::INFINITY], none);
                assert_eq!(winding, figure.winding(point), "{count} {curves} {point}");
                assert_eq!(winding, outline.cross(&line, [0.0, 0.0], none));
                assert_eq!(
                    listed(&outline, &line, true),
                    listed(&outline, &line, false)
                );
            }
        }
    }

    #[test]
    fn crossings_of_a_whole_line_cancel_also_through_joints() {
        let figure = rings(9, 6);
        let outline = Outline::new(&figure);
        let joints: Vec<DVec2> = figure.segments().map(|s| s.start()).collect();
        for a in &joints {
            for b in joints.iter().filter(|b| *b != a) {
                let line = Line2::new(*a, (*b - *a).normalize());
                let everything = [f64::NEG_INFINITY, f64::INFINITY];
                let mut sum = 0;
                let winding = outline.cross(&line, everything, |crossing| {
                    sum += crossing.sense;
                    Some(f64::INFINITY)
                });
                assert_eq!((winding, sum), (0, 0), "{a} {b}");
            }
        }
    }

    #[test]
    fn a_tangent_crosses_twice_or_not_at_all() {
        let arch = Figure {
            contours: vec![Contour {
                curves: vec![
                    Curve::Cubic {
                        start: DVec2::ZERO,
                        control1: DVec2::Y,
                        control2: DVec2::ONE,
                    },
                    Curve::Line { start: DVec2::X },
                ],
            }],
            rule: FillRule::EvenOdd,
        };
        let outline = Outline::new(&arch);
        // The arch is 3/4 high.
        for shift in [-1e-9, -1e-15, 0.0, 1e-15, 1e-9] {
            let line = ray(DVec2::new(-1.0, 0.75 + shift), 0.0);
            let mut met = 0;
            outline.cross(&line, [0.0, 10.0], |_| {
                met += 1;
                Some(10.0)
            });
            assert!(met == 0 || met == 2, "{met} at {shift}");
        }
    }
}
