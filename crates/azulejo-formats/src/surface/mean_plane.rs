//! The mean planes of polygons.

use azulejo_scene::math::area_vector;
use glam::DVec3;

/// The mean plane of a polygon.
pub(crate) struct MeanPlane {
    centre: DVec3,
    pub normal: DVec3,
    pub area: f64,
    /// The largest distance of a corner from the centre.
    pub radius: f64,
}

impl MeanPlane {
    pub fn of(corners: &[DVec3]) -> MeanPlane {
        let area = area_vector(corners);
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let far = |r: f64, p: &DVec3| r.max(p.distance(centre));
        MeanPlane {
            centre,
            normal: area.normalize_or_zero(),
            area: area.length(),
            radius: corners.iter().fold(0.0, far),
        }
    }

    /// Whether a polygon is convex, and flat up to a bend relative to its radius.
    pub fn is_flat_and_convex(corners: &[DVec3], bend: f64) -> bool {
        let plane = MeanPlane::of(corners);
        plane.bend(corners) <= bend && is_convex(corners, plane.normal)
    }

    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.centre)
    }

    /// The largest distance of a corner from the plane, relative to the radius.
    pub fn bend(&self, corners: &[DVec3]) -> f64 {
        let off = |m: f64, &p: &DVec3| m.max(self.height(p).abs());
        corners.iter().fold(0.0, off) / self.radius
    }
}

/// The edges of a polygon, each with its ends in order.
pub(crate) fn edges(corners: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(next.copied())
}

/// Whether all corners turn left or are straight.
pub(crate) fn is_convex(corners: &[DVec3], normal: DVec3) -> bool {
    let n = corners.len();
    (0..n).all(|k| {
        let (a, b, c) = (corners[k], corners[(k + 1) % n], corners[(k + 2) % n]);
        let (ab, bc) = (b - a, c - b);
        ab.cross(bc).dot(normal) >= -1e-9 * ab.length() * bc.length()
    })
}
