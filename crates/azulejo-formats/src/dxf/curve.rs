//! Arcs divided into straight segments.

use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Segments of a full circle. They deviate by at most 1 − cos(π/32), or 0.5 % of the
/// radius; a multiple of four preserves the extents of a circle.
pub(super) const PIECES: f64 = 32.0;

/// Number of segments of an arc, for an angle in radians.
pub(super) fn pieces(angle: f64) -> usize {
    // The margin keeps rounding from adding a segment.
    (angle.abs() * PIECES / TAU - 1e-9)
        .ceil()
        .clamp(1.0, PIECES) as usize
}

/// The arc counter-clockwise from `start` to `end`, in degrees: start and angle in radians. The angle
/// is above 0 and at most a full turn, which it also is if both are equal up to rounding.
pub(super) fn sweep(start: f64, end: f64) -> (f64, f64) {
    let angle = (end - start).rem_euclid(360.0);
    let angle = if angle < 1e-7 { 360.0 } else { angle };
    (start.to_radians(), angle.to_radians())
}

/// An arc of an ellipse around `centre`: the points `centre + cos t·x + sin t·y`, `t` from
/// `start` over `angle`. A full turn does not repeat its first point.
pub(super) fn ellipse(centre: DVec3, x: DVec3, y: DVec3, (start, angle): (f64, f64)) -> Vec<DVec3> {
    let count = pieces(angle);
    let points = count + usize::from(!is_full(angle));
    let at = |i| {
        let (sin, cos) = (start + angle * i as f64 / count as f64).sin_cos();
        centre + cos * x + sin * y
    };
    (0..points).map(at).collect()
}

/// Whether an angle is a full turn.
pub(super) fn is_full(angle: f64) -> bool {
    angle > TAU - 1e-9
}

/// A point of an arc, and the unit tangent there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Station {
    /// The point.
    pub point: DVec2,
    /// The tangent.
    pub tangent: DVec2,
}

/// The segment from `from` to `to`, which must differ: straight for a bulge of 0, otherwise an
/// arc of the angle 4·atan(bulge), counter-clockwise if that is positive.
pub(super) fn bulged(from: DVec2, to: DVec2, bulge: f64) -> Vec<Station> {
    let chord = to - from;
    let along = chord.normalize();
    // Beyond this it is a full circle to the last digit, and its sine is too small to divide by.
    let half = 2.0 * bulge.clamp(-1e6, 1e6).atan();
    if half.abs() < 1e-9 {
        return [from, to]
            .map(|point| Station {
                point,
                tangent: along,
            })
            .to_vec();
    }
    let count = pieces(2.0 * half);
    // The centre lies to the left of the chord for less than half a turn.
    let centre = from + 0.5 * chord + 0.5 * chord.perp() / half.tan();
    let at = |i: usize| {
        let turned = 2.0 * half * i as f64 / count as f64;
        let point = match i {
            0 => from,
            i if i == count => to,
            _ => centre + DVec2::from_angle(turned).rotate(from - centre),
        };
        let tangent = DVec2::from_angle(turned - half).rotate(along);
        Station { point, tangent }
    };
    (0..=count).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn numbers_of_pieces() {
        assert_eq!((pieces(TAU), pieces(-PI), pieces(PI / 2.0)), (32, 16, 8));
        assert_eq!((pieces(0.0), pieces(0.2), pieces(1e9)), (1, 2, 32));
        assert!(1.0 - (PI / PIECES).cos() < 0.005);
    }

    #[test]
    fn sweeps() {
        let check = |start: f64, end: f64, expected: f64| {
            let (from, angle) = sweep(start, end);
            assert_eq!((from, angle), (start.to_radians(), expected.to_radians()));
        };
        check(0.0, 90.0, 90.0);
        check(270.0, 90.0, 180.0);
        check(90.0, -90.0, 180.0);
        check(0.0, 360.0, 360.0);
        check(30.0, 30.0, 360.0);
    }

    fn check_bulge(bulge: f64, count: usize, middle: [f64; 2], tangents: [[f64; 2]; 2]) {
        let stations = bulged(DVec2::new(1.0, 0.0), DVec2::new(3.0, 0.0), bulge);
        assert_eq!(stations.len(), count + 1, "{bulge}");
        let near = |a: DVec2, b: [f64; 2]| {
            assert!((a - DVec2::from_array(b)).length() < 1e-12, "{bulge}: {a}")
        };
        if count > 1 {
            near(stations[count / 2].point, middle);
        }
        near(stations[0].tangent, tangents[0]);
        near(stations[count].tangent, tangents[1]);
        near(stations[count].point, [3.0, 0.0]);
    }

    #[test]
    fn bulges() {
        check_bulge(0.0, 1, [2.0, 0.0], [[1.0, 0.0], [1.0, 0.0]]);
        // Half a circle, counter-clockwise: below the chord.
        check_bulge(1.0, 16, [2.0, -1.0], [[0.0, -1.0], [0.0, 1.0]]);
        check_bulge(-1.0, 16, [2.0, 1.0], [[0.0, 1.0], [0.0, -1.0]]);
        // A quarter: its sagitta is half the chord times the bulge.
        let (quarter, s) = ((PI / 8.0).tan(), 0.5f64.sqrt());
        check_bulge(quarter, 8, [2.0, -quarter], [[s, -s], [s, s]]);
        // Three quarters.
        check_bulge(
            1.0 / quarter,
            24,
            [2.0, -1.0 / quarter],
            [[-s, -s], [-s, s]],
        );
    }
}
