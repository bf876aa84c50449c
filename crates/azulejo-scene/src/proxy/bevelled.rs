//! Bevels as polygons: a flat figure, divided along lines at which its bevel bends, whose points have heights.
//!
//! The points lie on the surface itself: on parallel lines of the sides, at the steps of the profile, clipped where
//! other sides are nearer, and on the medial axis where the figure is narrower than its bevel. The latter is found with
//! shrinking balls: Ma, Bae and Choi, *3D medial axis point approximation using nearest neighbors and the
//! normal field*, The Visual Computer 28, 2012.

use super::flat_figure::FlatFigure;
use crate::Bevel;
use crate::rim::Rim;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Most steps of a profile.
const MOST_STEPS: f64 = 64.0;
/// Most times that a stretch of the medial axis is halved, but for figures of very many sides.
const DEEPEST: u32 = 6;
const MANY_SIDES: usize = 1 << 14;
/// How near to the ends of sides the medial axis is looked for, as a share of their length.
const NEAR_END: f64 = 0.02;
/// Cosine of the turn below which a convex joint is a corner, to which the medial axis leads.
const CORNER: f64 = 0.9;
/// Lengths below this share of the inset are none: more than the rounding of the flat figure.
const SAME: f64 = 1e-6;
/// How much nearer other sides may be than a line that is clipped: so little that lines from two sides still end in one
/// place.
const CLIPPED: f64 = 1e-9;

/// The front of a bevelled prism, as a graph over its figure.
pub(super) struct BevelledFigure {
    pub flat: FlatFigure,
    /// How far up the bevel each point of the figure is, 0 on its border, 1 where the plane is.
    pub rises: Vec<f64>,
    /// Triangles of the bevel, with the outward normals of their corners: away from the inside, and
    /// towards the plane, for a unit length of the extrusion.
    pub slopes: Vec<[(u32, DVec3); 3]>,
    /// Triangles of the plane.
    pub plane: Vec<[u32; 3]>,
}

/// The number of steps of a profile whose chords deviate by at most `tolerance`, if its inset or depth, whichever is
/// larger, is `radius`.
pub(super) fn steps(bevel: &Bevel, radius: f64, tolerance: f64) -> u32 {
    match bevel.profile {
        crate::BevelProfile::Chamfer => 1,
        crate::BevelProfile::Round => {
            let half_step = (1.0 - tolerance / radius).clamp(0.0, 1.0).acos();
            (std::f64::consts::FRAC_PI_4 / half_step)
                .ceil()
                .clamp(2.0, MOST_STEPS) as u32
        }
    }
}

impl BevelledFigure {
    /// `normals` are those of the sides of `flat` at both of their ends, `tolerance` is that of the figure.
    pub fn new(
        flat: &FlatFigure,
        normals: &[[DVec2; 2]],
        bevel: &Bevel,
        steps: u32,
        tolerance: f64,
    ) -> BevelledFigure {
        let terraces = Terraces::new(flat, bevel, tolerance);
        let mut lines = Vec::new();
        for k in 1..=steps {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(steps);
            let across = if k == steps { 1.0 } else { 1.0 - angle.cos() };
            terraces.add_parallels(across * bevel.inset, &mut lines);
        }
        terraces.add_ridges(&mut lines);
        let divided = flat.divided(&lines);
        terraces.lift(divided, normals)
    }
}

/// The sides of a flat figure, and how far its bevel reaches.
struct Terraces<'a> {
    bevel: &'a Bevel,
    tolerance: f64,
    sides: Vec<[DVec2; 2]>,
    rim: Rim,
    /// The side that continues each side, where it is the only one.
    next: Vec<Option<usize>>,
}

/// A line, and the sides that it belongs to.
struct ParallelLine {
    ends: [DVec2; 2],
    of: [usize; 2],
}

impl<'a> Terraces<'a> {
    fn new(flat: &FlatFigure, bevel: &'a Bevel, tolerance: f64) -> Terraces<'a> {
        let at = |k: u32| flat.points[k as usize];
        let sides: Vec<[DVec2; 2]> = flat.border.iter().map(|side| side.map(at)).collect();
        let mut starts: HashMap<u32, Option<usize>> = HashMap::new();
        for (k, side) in flat.border.iter().enumerate() {
            let only = |start: &mut Option<usize>| *start = None;
            starts.entry(side[0]).and_modify(only).or_insert(Some(k));
        }
        let next = |side: &[u32; 2]| starts.get(&side[1]).copied().flatten();
        Terraces {
            next: flat.border.iter().map(next).collect(),
            rim: Rim::of_sides(sides.iter().copied()),
            bevel,
            tolerance,
            sides,
        }
    }

    /// Unit normal of a side toward the inside.
    fn inward(&self, side: usize) -> DVec2 {
        let [a, b] = self.sides[side];
        (b - a).perp().normalize_or_zero()
    }

    /// Adds the parts of the parallel curve at a distance from the border: lines beside sides, and chords of arcs about
    /// reflex corners.
    fn add_parallels(&self, distance: f64, lines: &mut Vec<[DVec2; 2]>) {
        for (k, side) in self.sides.iter().enumerate() {
            let aside = distance * self.inward(k);
            let ends = side.map(|p| p + aside);
            self.add_clipped(&ParallelLine { ends, of: [k; 2] }, distance, lines);
            let Some(next) = self.next[k] else { continue };
            let turns = self.fan(k, next, distance);
            for pair in turns.windows(2) {
                let ends = [pair[0], pair[1]].map(|n| side[1] + distance * n);
                self.add_clipped(
                    &ParallelLine {
                        ends,
                        of: [k, next],
                    },
                    distance,
                    lines,
                );
            }
        }
    }

    /// Unit directions from the normal of a side to that of the next one about the reflex corner between them; none
    /// where there is none. Chords at the distance deviate by the tolerance.
    fn fan(&self, side: usize, next: usize, distance: f64) -> Vec<DVec2> {
        let (from, to) = (self.inward(side), self.inward(next));
        let angle = from.angle_to(to);
        if angle >= -SAME {
            return Vec::new();
        }
        let half_step = (1.0 - self.tolerance / distance).clamp(0.5, 1.0).acos();
        let count = (-angle / (2.0 * half_step)).ceil().clamp(1.0, MOST_STEPS) as u32;
        let turn = |k: u32| DVec2::from_angle(angle * f64::from(k) / f64::from(count)).rotate(from);
        (0..=count).map(turn).collect()
    }

    /// Adds the parts of a line at a distance from its own sides to which no other side is nearer.
    fn add_clipped(&self, line: &ParallelLine, distance: f64, lines: &mut Vec<[DVec2; 2]>) {
        let [a, b] = line.ends;
        if a == b {
            return;
        }
        let nearer = distance * (1.0 - CLIPPED);
        let mut covered = Vec::new();
        self.rim.along(line.ends, distance, |other| {
            if !line.of.contains(&(other as usize)) {
                covered.extend(stretch_within(
                    line.ends,
                    self.sides[other as usize],
                    nearer,
                ));
            }
        });
        covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut free = 0.0;
        for [first, last] in covered.into_iter().chain([[1.0, 1.0]]) {
            let first = first.min(1.0);
            if first - free > SAME {
                lines.push([free, first].map(|t| a + t * (b - a)));
            }
            free = last.max(free);
        }
    }

    /// Adds chords of the medial axis where it is nearer to the border than the bevel reaches.
    fn add_ridges(&self, lines: &mut Vec<[DVec2; 2]>) {
        let depth = if self.sides.len() > MANY_SIDES {
            1
        } else {
            DEEPEST
        };
        for k in 0..self.sides.len() {
            let [a, b] = self.sides[k];
            let ball = |t: f64| self.ball(a + t * (b - a), self.inward(k));
            // Not at the ends themselves: where sides join smoothly, the balls there are those of the joint.
            let [first, last] = [NEAR_END, 1.0 - NEAR_END].map(ball);
            self.add_ridge(
                [first, last],
                [NEAR_END, 1.0 - NEAR_END],
                &ball,
                depth,
                lines,
            );
            if let Some(next) = self.next[k] {
                let way = self.ridge_about(k, next, last);
                way.windows(2)
                    .for_each(|pair| self.join([pair[0], pair[1]], lines));
            }
        }
    }

    /// The balls from the last one of a side to the first one of the next: to a convex corner and back, or all about a
    /// reflex one.
    fn ridge_about(&self, side: usize, next: usize, last: (DVec2, f64)) -> Vec<(DVec2, f64)> {
        let [corner, end] = self.sides[next];
        let start = self.ball(corner + NEAR_END * (end - corner), self.inward(next));
        let (from, to) = (self.inward(side), self.inward(next));
        let between = if from.perp_dot(to) > 0.0 && from.dot(to) < CORNER {
            vec![(corner, 0.0)]
        } else {
            let turns = self.fan(side, next, self.bevel.inset).into_iter();
            turns.map(|inward| self.ball(corner, inward)).collect()
        };
        [vec![last], between, vec![start]].concat()
    }

    /// Adds a stretch of the medial axis between two balls of a side, divided until it hardly bends.
    fn add_ridge(
        &self,
        [a, b]: [(DVec2, f64); 2],
        [first, last]: [f64; 2],
        ball: &impl Fn(f64) -> (DVec2, f64),
        depth: u32,
        lines: &mut Vec<[DVec2; 2]>,
    ) {
        let middle = ball(0.5 * (first + last));
        let inset = self.bevel.inset;
        let bend = middle.0.distance(0.5 * (a.0 + b.0));
        let narrow = [a, middle, b].map(|at| at.1 < inset);
        let is_even = narrow == [narrow[0]; 3] && bend <= self.tolerance;
        if depth == 0 || is_even || narrow == [false; 3] {
            self.join([a, middle], lines);
            self.join([middle, b], lines);
            return;
        }
        let half = 0.5 * (first + last);
        self.add_ridge([a, middle], [first, half], ball, depth - 1, lines);
        self.add_ridge([middle, b], [half, last], ball, depth - 1, lines);
    }

    /// Adds a chord between two balls that are both smaller than the bevel reaches.
    fn join(&self, [a, b]: [(DVec2, f64); 2], lines: &mut Vec<[DVec2; 2]>) {
        let is_narrow = a.1.max(b.1) < self.bevel.inset * (1.0 - SAME);
        if is_narrow && a.0.distance(b.0) > SAME * self.bevel.inset {
            lines.push([a.0, b.0]);
        }
    }

    /// The largest disc inside that touches the border at a point, no larger than the bevel reaches: centre and
    /// radius.
    fn ball(&self, touch: DVec2, inward: DVec2) -> (DVec2, f64) {
        let mut radius = self.bevel.inset;
        for _ in 0..32 {
            let centre = touch + radius * inward;
            let Some(at) = self.rim.nearest(centre, radius * (1.0 - SAME)) else {
                break;
            };
            let way = centre - at.distance * at.inward - touch;
            let smaller = way.length_squared() / (2.0 * way.dot(inward));
            if !(smaller > 0.0 && smaller < radius) {
                break;
            }
            radius = smaller;
        }
        (touch + radius * inward, radius)
    }

    /// Gives the points of the divided figure their heights, and its triangles normals.
    fn lift(&self, flat: FlatFigure, normals: &[[DVec2; 2]]) -> BevelledFigure {
        let Bevel {
            profile,
            inset,
            depth,
            ..
        } = *self.bevel;
        let mut across: Vec<f64> = (flat.points.iter())
            .map(|&p| {
                self.rim
                    .nearest(p, inset)
                    .map_or(1.0, |at| at.distance / inset)
            })
            .collect();
        // Near 0 rounding would count for much more.
        flat.border
            .iter()
            .flatten()
            .for_each(|&p| across[p as usize] = 0.0);
        let across: Vec<f64> = across
            .into_iter()
            .map(|x| if x > 1.0 - SAME { 1.0 } else { x })
            .collect();
        let rises: Vec<f64> = across.iter().map(|&x| profile.rise(x)).collect();
        let (mut slopes, mut plane) = (Vec::new(), Vec::new());
        for triangle in flat.tiles.iter().flat_map(|tile| &tile.triangles) {
            if triangle.iter().all(|&p| across[p as usize] == 1.0) {
                plane.push(*triangle);
                continue;
            }
            let at = |p: u32| flat.points[p as usize];
            let middle = triangle.iter().map(|&p| at(p)).sum::<DVec2>() / 3.0;
            let side = self
                .rim
                .nearest(middle, f64::INFINITY)
                .map_or(0, |n| n.piece as usize);
            slopes.push(triangle.map(|p| {
                let k = p as usize;
                let outward = self.outward(side, at(p), normals[side]);
                let [_, by_across, by_rise] = profile.equation(across[k], rises[k]);
                (p, (by_across / inset * outward).extend(-by_rise / depth))
            }));
        }
        BevelledFigure {
            flat,
            rises,
            slopes,
            plane,
        }
    }

    /// Unit direction away from the inside at a point to which a side is nearest; `normals` are the side's at its ends.
    fn outward(&self, side: usize, point: DVec2, normals: [DVec2; 2]) -> DVec2 {
        let [a, b] = self.sides[side];
        let share = (b - a).dot(point - a) / (b - a).length_squared();
        let own = -self.inward(side);
        for (corner, normal, is_beyond) in
            [(a, normals[0], share < 0.0), (b, normals[1], share > 1.0)]
        {
            let is_corner = normal.normalize_or_zero().dot(own) > 1.0 - SAME;
            if is_beyond && is_corner && point.distance(corner) > SAME * self.bevel.inset {
                return (corner - point).normalize_or(own);
            }
        }
        let share = share.clamp(0.0, 1.0);
        let [first, last] = normals.map(|n| n.normalize_or(own));
        ((1.0 - share) * first + share * last).normalize_or(own)
    }
}

/// The shares of a line at which it is nearer than `distance` to a side. Points that near to a side are a convex set.
fn stretch_within([p, q]: [DVec2; 2], [a, b]: [DVec2; 2], distance: f64) -> Option<[f64; 2]> {
    let way = q - p;
    let disc = |centre: DVec2| {
        let (to, square) = (centre - p, way.length_squared());
        let middle = to.dot(way) / square;
        let half = middle * middle - (to.length_squared() - distance * distance) / square;
        (half > 0.0).then(|| [middle - half.sqrt(), middle + half.sqrt()])
    };
    let side = b - a;
    let length = side.length();
    let along = side / length;
    let strip = |direction: DVec2, low: f64, high: f64| {
        let (start, speed) = (direction.dot(p - a), direction.dot(way));
        let (s, t) = ((low - start) / speed, (high - start) / speed);
        let everywhere = if start > low && start < high {
            f64::INFINITY
        } else {
            f64::NEG_INFINITY
        };
        if speed == 0.0 {
            [-everywhere, everywhere]
        } else {
            [s.min(t), s.max(t)]
        }
    };
    let ([s0, s1], [t0, t1]) = (
        strip(along, 0.0, length),
        strip(along.perp(), -distance, distance),
    );
    let between = Some([s0.max(t0), s1.min(t1)]).filter(|[first, last]| first < last);
    let parts = [disc(a), disc(b), between].into_iter().flatten();
    let all = parts.reduce(|x, y| [x[0].min(y[0]), x[1].max(y[1])])?;
    let [first, last] = [all[0].max(0.0), all[1].min(1.0)];
    (first < last).then_some([first, last])
}
