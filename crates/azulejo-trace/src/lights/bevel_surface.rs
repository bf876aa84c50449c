//! The surface of bevels, for lamps in the form of letters.
//!
//! A bevel is sampled along its curves and along its profile, and about reflex corners by the angle. Points to which
//! another part of the border is nearer are not on it.

use super::prism_emitters::PIECES;
use azulejo_scene::rim::{Rim, RimPiece};
use azulejo_scene::{Bevel, BevelClimb, BevelEnds, Prism};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Distances that differ by less than this share are equal.
const SAME: f64 = 1e-6;

/// The bevels of a prism in strips: those of each piece of the border, then those about reflex corners, at the front
/// and at the back.
#[derive(Clone, Debug)]
pub(super) struct BevelSurface<'a> {
    prism: &'a Prism,
    bevel: Bevel,
    rim: Rim,
    corners: Vec<DVec2>,
    ends: Vec<BevelClimb>,
    figure_from_world: DAffine3,
}

/// A point of a strip.
pub(super) struct StripPoint {
    /// In figure space.
    pub position: DVec3,
    /// Outward, any length.
    pub normal: DVec3,
    /// World area per unit of the strip's two parameters.
    pub stretch: f64,
}

impl<'a> BevelSurface<'a> {
    pub fn new(prism: &'a Prism, bevel: &Bevel) -> BevelSurface<'a> {
        let rim = Rim::new(&prism.figure);
        let reflex = rim.pieces.iter().filter(|p| p.is_reflex[0]);
        let mut corners: Vec<DVec2> = reflex.map(|p| p.segment.start()).collect();
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        corners.dedup();
        let ends: &[f64] = match bevel.ends {
            BevelEnds::Front => &[0.0],
            BevelEnds::Both => &[0.0, 1.0],
        };
        BevelSurface {
            prism,
            bevel: *bevel,
            rim,
            corners,
            ends: ends.iter().filter_map(|&z| bevel.climb(z)).collect(),
            figure_from_world: prism.world_from_figure.inverse(),
        }
    }

    pub fn bevel(&self) -> &Bevel {
        &self.bevel
    }

    /// The number of strips at each end.
    fn strips_each(&self) -> usize {
        self.rim.pieces.len() * PIECES + self.corners.len()
    }

    /// The rough areas of all strips.
    pub fn areas(&self) -> impl Iterator<Item = f64> + '_ {
        let strips = 0..self.ends.len() * self.strips_each();
        strips.map(|k| self.strip(k, [0.5, 0.5]).map_or(0.0, |at| at.stretch))
    }

    /// A point of a strip; `None` if it is not on the surface.
    pub fn point(&self, strip: usize, at: [f64; 2]) -> Option<StripPoint> {
        let point = self.strip(strip, at)?;
        let p = point.position;
        let is_nearer = self.is_set_back(p.truncate(), self.bevel.setback(p.z) * (1.0 - SAME));
        (is_nearer && self.prism.figure.contains(p.truncate())).then_some(point)
    }

    /// Whether a point is at least that far from the border.
    pub fn is_set_back(&self, p: DVec2, setback: f64) -> bool {
        self.rim.nearest(p, setback).is_none()
    }

    /// A point of a strip as if there were no others: at a share along its curve or around its corner, and along the
    /// profile.
    fn strip(&self, strip: usize, [along, share]: [f64; 2]) -> Option<StripPoint> {
        let (end, within) = (strip / self.strips_each(), strip % self.strips_each());
        let [(across, over_across), (rise, over_rise)] = self.bevel.profile.point(share);
        let (setback, climb) = (across * self.bevel.inset, self.ends[end]);
        let (foot, inward, way) = match self.rim.pieces.get(within / PIECES) {
            Some(piece) => {
                let t = ((within % PIECES) as f64 + along) / PIECES as f64;
                let way = piece.segment.derivative(t) * shrinkage(piece, t, setback);
                (piece.segment.at(t), piece.inward(t), way / PIECES as f64)
            }
            None => {
                let corner = within - self.rim.pieces.len() * PIECES;
                let inward = DVec2::from_angle(TAU * along);
                (self.corners[corner], inward, TAU * setback * inward.perp())
            }
        };
        let over = (over_across * self.bevel.inset * inward).extend(over_rise / climb.slope);
        let axes = self.prism.world_from_figure.matrix3;
        let stretch = (axes * way.extend(0.0)).cross(axes * over).length();
        let [_, by_across, by_rise] = self.bevel.profile.equation(across, rise);
        Some(StripPoint {
            position: (foot + setback * inward).extend(climb.height(rise)),
            normal: (-by_across / self.bevel.inset * inward).extend(-by_rise * climb.slope),
            stretch,
        })
        .filter(|at| at.stretch.is_finite() && at.stretch > 0.0)
    }

    /// The strip at a world point of a bevel, and its stretch there; `None` between the bevels.
    pub fn locate(&self, position: DVec3) -> Option<(usize, f64)> {
        let p = self.figure_from_world.transform_point3(position);
        let climb = self.bevel.climb(p.z)?;
        let end = self.ends.iter().position(|e| *e == climb)?;
        let nearest = self.rim.nearest(p.truncate(), f64::INFINITY)?;
        let share = self.bevel.profile.share(climb.at(p.z).clamp(0.0, 1.0));
        let piece = &self.rim.pieces[nearest.piece as usize];
        let across = nearest.inward.dot(piece.inward(nearest.parameter));
        let corner = piece.point(nearest.parameter);
        let corner = self.corners.iter().position(|c| *c == corner);
        let (within, along) = match corner.filter(|_| across < 1.0 - SAME * SAME) {
            Some(corner) => {
                let turn = nearest.inward.to_angle() / TAU;
                (
                    self.rim.pieces.len() * PIECES + corner,
                    turn.rem_euclid(1.0),
                )
            }
            None => {
                let place = nearest.parameter * PIECES as f64;
                let part = (place as usize).min(PIECES - 1);
                (nearest.piece as usize * PIECES + part, place - part as f64)
            }
        };
        let strip = end * self.strips_each() + within;
        Some((strip, self.strip(strip, [along, share])?.stretch))
    }
}

/// How much shorter a parallel curve is at a distance inside: 1 less the distance times the curvature.
fn shrinkage(piece: &RimPiece, t: f64, distance: f64) -> f64 {
    let (first, second) = (
        piece.segment.derivative(t),
        piece.segment.second_derivative(t),
    );
    let curvature = first.perp_dot(second) / first.length().powi(3);
    1.0 - piece.inner * curvature * distance
}
