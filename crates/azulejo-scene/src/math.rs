//! Rays, boxes and frames.

use glam::{DMat3, DVec3};

/// A half-open segment of a line: the points `origin + t direction` for `t_min <= t < t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at `t` = 0.
    pub origin: DVec3,
    /// Direction, any length but zero; `t` is in units of it.
    pub direction: DVec3,
    /// The smallest parameter included, at least 0.
    pub t_min: f64,
    /// The end of the parameter range, excluded; infinity for a whole half-line.
    pub t_max: f64,
}

impl Ray {
    /// The whole half-line from `origin`.
    pub const fn new(origin: DVec3, direction: DVec3) -> Ray {
        Ray {
            origin,
            direction,
            t_min: 0.0,
            t_max: f64::INFINITY,
        }
    }

    /// The open segment between two points, for visibility tests.
    pub fn between(from: DVec3, to: DVec3) -> Ray {
        Ray {
            origin: from,
            direction: to - from,
            t_min: 0.0,
            t_max: 1.0,
        }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// An axis-aligned box. The empty box has `min` = +∞ and `max` = −∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The lowest corner.
    pub min: DVec3,
    /// The highest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The empty box.
    pub const EMPTY: Aabb = Aabb {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, Aabb::with_point)
    }

    /// The smallest box around this one and a point.
    pub fn with_point(self, p: DVec3) -> Aabb {
        Aabb {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// The smallest box around both.
    pub fn union(self, o: Aabb) -> Aabb {
        Aabb {
            min: self.min.min(o.min),
            max: self.max.max(o.max),
        }
    }

    /// Whether no point is inside.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// The middle; zero for the empty box.
    pub fn centre(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (self.min + self.max)
        }
    }

    /// Corner-to-corner vector; zero for the empty box.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            self.max - self.min
        }
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }
}

/// A right-handed orthonormal frame around a normal.
///
/// Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017: continuous but for
/// one seam, exact to rounding for every unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: DVec3,
    /// Second tangent.
    pub y: DVec3,
    /// The normal.
    pub z: DVec3,
}

impl Frame {
    /// A frame whose third axis is the unit vector `n`.
    pub fn from_normal(n: DVec3) -> Frame {
        let sign = 1f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            x: DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            y: DVec3::new(b, sign + n.y * n.y * a, -n.y),
            z: n,
        }
    }

    /// From coordinates in this frame to the world.
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        v.x * self.x + v.y * self.y + v.z * self.z
    }

    /// From the world to coordinates in this frame.
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }
}

/// Area vector of a polygon: its length is the area, its direction the normal of the front.
///
/// Newell's sum, so it holds for concave and slightly bent polygons; the origin is moved to the
/// first vertex, so that polygons far away lose no precision. Zero for fewer than three vertices.
pub fn area_vector(polygon: &[DVec3]) -> DVec3 {
    let Some((&first, rest)) = polygon.split_first() else {
        return DVec3::ZERO;
    };
    let sum: DVec3 = rest
        .windows(2)
        .map(|w| (w[0] - first).cross(w[1] - first))
        .sum();
    0.5 * sum
}

/// The mirror image of a direction in the plane with unit normal `n`.
pub fn reflect(direction: DVec3, n: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(n) * n
}

/// The matrix that transforms normals when `m` transforms points: its inverse transpose,
/// unnormalized.
pub fn normal_matrix(m: DMat3) -> DMat3 {
    // Cofactors instead of the inverse: a flattened object keeps a usable normal.
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let cofactor = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    if m.determinant() < 0.0 {
        cofactor * -1.0
    } else {
        cofactor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_is_orthonormal_for_every_octant() {
        for n in [
            DVec3::Z,
            -DVec3::Z,
            DVec3::new(1.0, -2.0, 3.0),
            DVec3::new(-1.0, 5.0, -2e-9),
        ] {
            let f = Frame::from_normal(n.normalize());
            assert!((f.x.cross(f.y) - f.z).length() < 1e-14, "{n}");
            assert!(
                f.x.dot(f.y).abs() < 1e-14 && (f.x.length() - 1.0).abs() < 1e-14,
                "{n}"
            );
        }
    }

    #[test]
    fn area_vector_of_a_far_concave_polygon() {
        let far = DVec3::new(1e6, -2e6, 3e6);
        let l = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
            .map(|(x, y)| far + DVec3::new(f64::from(x), f64::from(y), 0.0));
        assert!((area_vector(&l) - 3.0 * DVec3::Z).length() < 1e-9);
    }
}
