//! Conversion between the format's Coons patches, which are bicubic, and Bézier patches.

use azulejo_scene::{BicubicPatch, MaterialId};
use glam::DVec3;

/// Bernstein coefficients of t²(3 − 2t), which blends opposite borders.
const BLEND: [f64; 4] = [0.0, 0.0, 1.0, 1.0];

/// Indices of the corners among the twelve points: both ends of the bottom, then of the top.
const CORNERS: [usize; 4] = [3, 4, 7, 8];

/// The points around the corners on the bottom, top, left and right border.
const BORDERS: [[usize; 4]; 4] = [[2, 3, 4, 5], [6, 7, 8, 9], [0, 3, 7, 10], [1, 4, 8, 11]];

/// The Coons patch over four corners, whose borders are Catmull–Rom curves through twelve points.
///
/// Both are cubic in each parameter, hence the patch is, too, and its control points are exact.
pub(super) fn patch(points: &[DVec3; 12], material: MaterialId) -> BicubicPatch {
    let [bottom, top, left, right] = BORDERS.map(|border| bezier(border.map(|k| points[k])));
    let [a, b, c, d] = CORNERS.map(|k| points[k]);
    let control = |i: usize, j: usize| {
        let (u, v) = (BLEND[i], BLEND[j]);
        let borders = bottom[i] * (1.0 - v) + top[i] * v + left[j] * (1.0 - u) + right[j] * u;
        let low = a * (1.0 - u) + b * u;
        let high = c * (1.0 - u) + d * u;
        borders - (low * (1.0 - v) + high * v)
    };
    let row = |j: usize| std::array::from_fn(|i| control(i, j));
    BicubicPatch {
        points: Box::new(std::array::from_fn(row)),
        material,
    }
}

/// The segment of a Catmull–Rom curve between its second and third point.
fn bezier([before, start, end, behind]: [DVec3; 4]) -> [DVec3; 4] {
    [
        start,
        start + (end - before) / 6.0,
        end - (behind - start) / 6.0,
        end,
    ]
}

/// The twelve points from which [`patch`] makes this patch up to rounding; `None` if there are
/// none.
pub(super) fn points(patch: &BicubicPatch) -> Option<[DVec3; 12]> {
    let p = &patch.points;
    let mut points = [DVec3::ZERO; 12];
    let column = |i: usize| [p[0][i], p[1][i], p[2][i], p[3][i]];
    let curves = [p[0], p[3], column(0), column(3)];
    for (border, [start, first, second, end]) in BORDERS.into_iter().zip(curves) {
        points[border[0]] = end - 6.0 * (first - start);
        points[border[1]] = start;
        points[border[2]] = end;
        points[border[3]] = start + 6.0 * (end - second);
    }
    let again = self::patch(&points, patch.material);
    let pairs = p.iter().flatten().zip(again.points.iter().flatten());
    let size = patch.bounds().diagonal();
    let same = pairs
        .into_iter()
        .all(|(a, b)| a.distance(*b) <= 1e-9 * size);
    same.then_some(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve points of a curved patch.
    fn bent() -> [DVec3; 12] {
        let places = [
            (1.0, 0.0),
            (2.1, 0.2),
            (0.0, 1.0),
            (1.1, 1.0),
            (2.0, 0.9),
            (3.0, 1.2),
            (0.1, 2.0),
            (0.9, 2.2),
            (2.3, 2.0),
            (3.2, 1.9),
            (1.0, 3.0),
            (2.0, 3.3),
        ];
        places.map(|(x, y)| DVec3::new(x, y, 0.3 * x * y - 0.1 * x * x))
    }

    /// A Coons patch evaluated by its definition.
    fn by_definition(p: &[DVec3; 12], u: f64, v: f64) -> DVec3 {
        let hermite = |[before, start, end, behind]: [usize; 4], t: f64| {
            let (m0, m1) = (0.5 * (p[end] - p[before]), 0.5 * (p[behind] - p[start]));
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * p[start]
                + (t3 - 2.0 * t2 + t) * m0
                + (3.0 * t2 - 2.0 * t3) * p[end]
                + (t3 - t2) * m1
        };
        let b = |t: f64| t * t * (3.0 - 2.0 * t);
        let (bu, bv) = (b(u), b(v));
        let ruled = hermite([2, 3, 4, 5], u) * (1.0 - bv)
            + hermite([6, 7, 8, 9], u) * bv
            + hermite([0, 3, 7, 10], v) * (1.0 - bu)
            + hermite([1, 4, 8, 11], v) * bu;
        let corners = p[3] * (1.0 - bu) * (1.0 - bv)
            + p[4] * bu * (1.0 - bv)
            + p[7] * (1.0 - bu) * bv
            + p[8] * bu * bv;
        ruled - corners
    }

    #[test]
    fn control_points_are_exact() {
        let points = bent();
        let patch = patch(&points, 0);
        for k in 0..=10 {
            for l in 0..=10 {
                let (u, v) = (f64::from(k) / 10.0, f64::from(l) / 10.0);
                let (p, du, dv) = patch.at(u, v);
                assert!(p.distance(by_definition(&points, u, v)) < 1e-13, "{u} {v}");
                assert!(du.cross(dv).z > 0.0, "the front is up");
            }
        }
    }

    #[test]
    fn points_come_back() {
        let expected = bent();
        let mut patch = patch(&expected, 0);
        let actual = points(&patch).unwrap();
        let far = actual.iter().zip(&expected).map(|(a, b)| a.distance(*b));
        assert!(far.fold(0.0, f64::max) < 1e-13);
        patch.points[1][1].x += 0.1;
        assert_eq!(points(&patch), None);
    }
}
