//! Which light leaves a facet upwards.

use super::Facet;
use glam::DVec3;

/// Where a facet lies, as seen from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Elevation {
    /// All of it above the horizon of every point.
    Above,
    /// All of it below.
    Below,
    /// The horizon of some point cuts it.
    Mixed,
}

/// The heights of a facet and its slope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon {
    low: f64,
    high: f64,
    /// Cosine of the angle between its normal and the up direction.
    slope: f64,
    /// Difference of heights that does not count: neighbours in a grid have a height in common, up
    /// to rounding.
    graze: f64,
}

/// Cosine of the slope from which a facet counts as horizontal.
const LEVEL: f64 = 1.0 - 1e-12;

impl Horizon {
    pub(super) fn new(facet: &Facet, up: DVec3, graze: f64) -> Horizon {
        let heights = facet.polygon().iter().map(|p| up.dot(*p));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        Horizon {
            low,
            high,
            slope: facet.normal.dot(up),
            graze,
        }
    }

    /// Where another facet lies, as seen from this one. A horizontal one sees no horizon.
    pub(super) fn elevation(&self, other: &Horizon) -> Elevation {
        if self.slope >= LEVEL {
            Elevation::Above
        } else if self.slope <= -LEVEL {
            Elevation::Below
        } else {
            self.elevation_of_part(other)
        }
    }

    /// The same for parts that were cut, of any slope.
    pub(super) fn elevation_of_part(&self, other: &Horizon) -> Elevation {
        if other.low >= self.high - self.graze {
            Elevation::Above
        } else if other.high <= self.low + self.graze {
            Elevation::Below
        } else {
            Elevation::Mixed
        }
    }

    /// 1 if all of another facet lies above, else 0: what the horizon cuts is counted elsewhere.
    pub fn share_above(&self, other: &Horizon) -> f64 {
        f64::from(u8::from(self.elevation(other) == Elevation::Above))
    }

    /// The view factor of an unobstructed sky: (1 + cos β) / 2 (Liu and Jordan, *The long-term
    /// average performance of flat-plate solar-energy collectors*, Solar Energy 7, 1963).
    pub fn sky(&self) -> f64 {
        if self.slope.abs() >= LEVEL {
            return if self.slope > 0.0 { 1.0 } else { 0.0 };
        }
        0.5 * (1.0 + self.slope)
    }
}
