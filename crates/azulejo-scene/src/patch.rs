//! A bicubic surface.

use crate::MaterialId;
use crate::math::Aabb;
use glam::{DAffine3, DVec3};

/// A bicubic Bézier patch. Its front is on the side to which ∂u × ∂v points.
#[derive(Clone, Debug, PartialEq)]
pub struct BicubicPatch {
    /// World control points: `points[row][column]`, `u` along the columns, `v` along the rows.
    pub points: Box<[[DVec3; 4]; 4]>,
    /// Its one material.
    pub material: MaterialId,
}

impl BicubicPatch {
    /// The point at `(u, v)`, both 0..=1, and its derivatives by `u` and by `v`.
    pub fn at(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let rows = self.points.map(|row| curve(row, u));
        let (p, dv) = curve(rows.map(|r| r.0), v);
        let (du, _) = curve(rows.map(|r| r.1), v);
        (p, du, dv)
    }

    /// The box around the control points, which holds the patch.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.points.iter().flatten().copied())
    }

    /// Transforms the patch by an affine map. A map that mirrors also reverses `u`, so that the
    /// front stays the front.
    pub fn transform(&mut self, map: &DAffine3) {
        let points = self.points.iter_mut().flatten();
        points.for_each(|p| *p = map.transform_point3(*p));
        if map.matrix3.determinant() < 0.0 {
            self.points.iter_mut().for_each(|row| row.reverse());
        }
    }
}

/// Point and derivative of a cubic Bézier curve.
fn curve([a, b, c, d]: [DVec3; 4], t: f64) -> (DVec3, DVec3) {
    let s = 1.0 - t;
    (
        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d,
        3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c)),
    )
}
