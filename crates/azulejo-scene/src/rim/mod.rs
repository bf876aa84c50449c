//! The border of a figure, and how far points inside are from it.
//!
//! | module | content |
//! |---|---|
//! | `border` | the pieces of a figure's curves that bound its inside |
//! | `nearest` | the point of a cubic curve that is nearest to a point |
//! | `pieces_tree` | pieces sorted for queries |

mod border;
mod nearest;
mod pieces_tree;

use crate::Figure;
use crate::figure::{Rectangle, Segment};
use glam::DVec2;
use nearest::nearest_parameter;
use pieces_tree::PiecesTree;

/// The border of a figure: those pieces of its curves with the inside on one side only.
#[derive(Clone, Debug, Default)]
pub struct Rim {
    /// The pieces, contour by contour.
    pub pieces: Vec<RimPiece>,
    tree: PiecesTree,
}

/// A piece of a curve on the border.
#[derive(Clone, Debug)]
pub struct RimPiece {
    /// Index of the curve in the figure.
    pub curve: u32,
    /// The parameters of its ends on the curve.
    pub range: [f64; 2],
    /// The piece as a curve of its own.
    pub segment: Segment,
    /// 1 if the inside is on its left, −1 if on its right.
    pub inner: f64,
    /// The largest curvature with which it bulges into the inside, 0 if it nowhere does: an upper
    /// bound, infinite at cusps.
    pub bulge: f64,
    /// Whether it starts, and ends, at a reflex corner: one to which a whole sector of the inside is
    /// nearest.
    pub is_reflex: [bool; 2],
    bounds: Rectangle,
}

/// The point of the border that is nearest to a point inside.
#[derive(Clone, Copy, Debug)]
pub struct RimPoint {
    /// Its distance.
    pub distance: f64,
    /// Unit direction in which the distance grows.
    pub inward: DVec2,
    /// Index of the piece.
    pub piece: u32,
    /// Parameter of the point on the piece, 0..=1.
    pub parameter: f64,
}

impl RimPiece {
    /// `is_reflex` is found later.
    fn new(curve: u32, range: [f64; 2], segment: Segment, inner: f64) -> RimPiece {
        RimPiece {
            curve,
            range,
            segment,
            inner,
            bulge: nearest::bulge(&segment, inner),
            is_reflex: [false; 2],
            bounds: segment.bounds(),
        }
    }

    /// The parameter on the whole curve at one on the piece.
    pub fn on_curve(&self, parameter: f64) -> f64 {
        let [first, last] = self.range;
        first + parameter * (last - first)
    }

    /// The parameter on the piece at one on the whole curve, clamped to 0..=1.
    pub fn parameter(&self, on_curve: f64) -> f64 {
        let [first, last] = self.range;
        ((on_curve - first) / (last - first)).clamp(0.0, 1.0)
    }

    /// Unit normal toward the inside, at a parameter on the piece.
    pub fn inward(&self, parameter: f64) -> DVec2 {
        let tangent = self.segment.tangent(parameter);
        self.inner * tangent.perp().normalize_or_zero()
    }

    /// The nearest point if it is nearer than the one known so far.
    #[inline]
    fn approach(&self, piece: u32, point: DVec2, best: &mut Option<RimPoint>, reach: &mut f64) {
        if self.bounds.distance_squared(point) > *reach * *reach {
            return;
        }
        let parameter = nearest_parameter(&self.segment, point);
        let way = point - self.segment.at(parameter);
        let distance = way.length();
        if distance > *reach {
            return;
        }
        // On the border itself the way has no direction.
        let is_way_long = distance > 1e-9 * self.bounds.size().max_element();
        *best = Some(RimPoint {
            distance,
            inward: if is_way_long {
                way / distance
            } else {
                self.inward(parameter)
            },
            piece,
            parameter,
        });
        *reach = distance;
    }
}

impl Rim {
    /// The border of a figure. Curves are divided where they cross; pieces with the inside, or the outside, on
    /// both sides are left out.
    pub fn new(figure: &Figure) -> Rim {
        Rim::of(border::pieces(figure))
    }

    /// The border that consists of these straight sides, with the inside on their left.
    pub(crate) fn of_sides(sides: impl Iterator<Item = [DVec2; 2]>) -> Rim {
        let piece = |(k, side)| RimPiece::new(k, [0.0, 1.0], Segment::Line(side), 1.0);
        Rim::of((0..).zip(sides).map(piece).collect())
    }

    fn of(mut pieces: Vec<RimPiece>) -> Rim {
        border::find_reflex_corners(&mut pieces);
        let bounds: Vec<Rectangle> = pieces.iter().map(|p| p.bounds).collect();
        Rim {
            tree: PiecesTree::new(&bounds),
            pieces,
        }
    }

    /// The nearest point of the border to `point`, which is inside; `None` if it is farther than `reach`.
    pub fn nearest(&self, point: DVec2, reach: f64) -> Option<RimPoint> {
        let mut best = None;
        self.tree.around(point, reach, |piece, reach| {
            self.pieces[piece as usize].approach(piece, point, &mut best, reach);
        });
        best
    }

    /// [`nearest`](Rim::nearest) among these pieces alone.
    #[inline]
    pub fn nearest_of(&self, pieces: &[u32], point: DVec2, reach: f64) -> Option<RimPoint> {
        let (mut best, mut reach) = (None, reach);
        for &piece in pieces {
            self.pieces[piece as usize].approach(piece, point, &mut best, &mut reach);
        }
        best
    }

    /// Visits the pieces that may be as near as `reach` to the straight line between two points.
    pub fn along(&self, line: [DVec2; 2], reach: f64, visit: impl FnMut(u32)) {
        self.tree.along(line, reach, visit);
    }
}
