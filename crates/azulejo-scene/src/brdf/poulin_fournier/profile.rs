//! The section through the cylinders, and its visible parts by direction.

use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// One period of the section across parallel cylinders of radius 1 along x, axes `d` apart. The
/// visible part of the surface is an arc of each, and a floor between them unless they touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    pub d: f64,
    /// Height of the floor above the axes.
    h: f64,
    /// The ends of the arc on both sides, as an angle from the top.
    arc: f64,
    floor: Range,
}

/// Lower and upper end; empty if the second is not greater.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range(f64, f64);

impl Range {
    const EMPTY: Range = Range(0.0, 0.0);

    pub fn and(&self, other: &Range) -> Range {
        Range(self.0.max(other.0), self.1.min(other.1))
    }

    pub fn length(&self) -> f64 {
        (self.1 - self.0).max(0.0)
    }

    /// Its ends as offsets from an angle, within a quarter turn.
    pub fn offsets(&self, from: f64) -> [f64; 2] {
        [self.0, self.1].map(|angle| (angle - from).clamp(-FRAC_PI_2, FRAC_PI_2))
    }

    /// The mirror image, in half of `about`.
    fn mirrored(&self, about: f64) -> Range {
        Range(about - self.1, about - self.0)
    }
}

/// Points of the section: angles of the arc, and y along the floor from the axis at 0 to the one
/// at `d`.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleSection {
    pub arc: Range,
    pub floor: Range,
}

/// The normal at an angle of the arc.
pub(super) fn normal(angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    DVec3::new(0.0, sin, cos)
}

/// The normal that is nearest to a direction.
pub(super) struct NearestNormal {
    /// Its angle.
    pub angle: f64,
    /// Cosine between the two. That of a normal at an offset x from here is `cos` cos x.
    pub cos: f64,
    y: f64,
    z: f64,
}

impl NearestNormal {
    pub fn of(w: DVec3) -> NearestNormal {
        let cos = w.y.hypot(w.z);
        NearestNormal {
            angle: w.y.atan2(w.z),
            cos,
            y: w.y / cos,
            z: w.z / cos,
        }
    }

    /// c and s, for which the normal at an offset x has the cosine c cos x + s sin x to a direction.
    pub fn components(&self, w: DVec3) -> [f64; 2] {
        [w.y * self.y + w.z * self.z, w.y * self.z - w.z * self.y]
    }
}

/// A direction's elevation in the section, from the y axis, 0..π.
fn elevation(w: DVec3) -> f64 {
    w.z.atan2(w.y)
}

impl Profile {
    /// `d` > 0; 0 ≤ `h` < 1.
    pub fn new(d: f64, h: f64) -> Profile {
        let arc = h.acos();
        let meet = d < 2.0 * arc.sin();
        let (arc, floor) = if meet {
            ((0.5 * d).asin(), Range::EMPTY)
        } else {
            (arc, Range(arc.sin(), d - arc.sin()))
        };
        Profile { d, h, arc, floor }
    }

    /// The parts that are visible from `w`, above the horizon.
    pub fn seen(&self, w: DVec3) -> VisibleSection {
        let everything = VisibleSection {
            arc: Range(-self.arc, self.arc),
            floor: self.floor,
        };
        let slope = w.z.atan2(w.y.abs());
        if slope >= self.arc {
            return everything;
        }
        // From the side of larger y, the next cylinder hides the lower parts.
        let (sin, cos) = slope.sin_cos();
        let shaded = (1.0 - self.d * sin).clamp(-1.0, 1.0).acos() - slope;
        let edge = self.d - (1.0 - self.h * cos) / sin;
        let seen = VisibleSection {
            arc: everything.arc.and(&Range(-slope, shaded)),
            floor: everything.floor.and(&Range(f64::NEG_INFINITY, edge)),
        };
        if w.y >= 0.0 {
            return seen;
        }
        VisibleSection {
            arc: seen.arc.mirrored(0.0),
            floor: seen.floor.mirrored(self.d),
        }
    }

    /// The parts that face `w`, in shadow or not.
    pub fn facing(&self, w: DVec3) -> VisibleSection {
        let e = elevation(w);
        VisibleSection {
            arc: Range(-e, std::f64::consts::PI - e),
            floor: self.floor,
        }
    }
}

impl VisibleSection {
    /// The parts visible from both.
    pub fn and(&self, other: &VisibleSection) -> VisibleSection {
        VisibleSection {
            arc: self.arc.and(&other.arc),
            floor: self.floor.and(&other.floor),
        }
    }

    /// ∫ (n·a)(n·b) ds over the parts visible from both.
    pub fn product(&self, a: DVec3, b: DVec3) -> f64 {
        let flat = self.floor.length() * a.z * b.z;
        if self.arc.length() <= 0.0 {
            return flat;
        }
        // n·w is the length of w's projection times the sine of angle + elevation.
        let (ea, eb) = (elevation(a), elevation(b));
        let (length, middle) = (self.arc.length(), self.arc.0 + self.arc.1 + ea + eb);
        let arc = length * (ea - eb).cos() - length.sin() * middle.cos();
        flat + (0.5 * arc * a.y.hypot(a.z) * b.y.hypot(b.z)).max(0.0)
    }

    /// ∫ n·w ds: the projected width of the parts visible from `w`.
    pub fn projected(&self, w: DVec3) -> f64 {
        self.arc_projected(w) + self.floor.length() * w.z
    }

    fn arc_projected(&self, w: DVec3) -> f64 {
        let middle = 0.5 * (self.arc.0 + self.arc.1) + elevation(w);
        w.y.hypot(w.z) * 2.0 * middle.sin() * (0.5 * self.arc.length()).sin()
    }

    /// The normal at a random point, with probability by projected width from `w`.
    pub fn normal(&self, w: DVec3, u: f64) -> DVec3 {
        let target = u * self.projected(w);
        if target >= self.arc_projected(w) {
            return DVec3::Z;
        }
        let e = elevation(w);
        let cos = (self.arc.0 + e).cos() - target / w.y.hypot(w.z);
        normal((cos.clamp(-1.0, 1.0).acos() - e).clamp(self.arc.0, self.arc.1))
    }
}
