//! SPLINE: B-splines converted to Bézier curves.

use super::record::Record;
use glam::{DVec2, DVec3};

/// The consecutive cubic pieces of a flat spline of degree 1 to 3, or the reason why there are none.
pub(super) fn curves(record: &Record) -> Result<Vec<[DVec2; 4]>, &'static str> {
    // Group code 71 is the degree, 10 a control point, 40 a knot and 41 a weight.
    let degree = record.integer(71, 3);
    let controls = points(record, 10);
    let numbers = |code: i16| -> Vec<f64> {
        let of_code = record.pairs.iter().filter(|p| p.code == code);
        of_code.filter_map(|p| record.finite(p.value)).collect()
    };
    let (knots, weights) = (numbers(40), numbers(41));
    // Refuse what cubic Bézier curves in a plane cannot represent, and knots that do not fit.
    if !(1..=3).contains(&degree) {
        return Err("of a degree above 3");
    }
    let degree = degree as usize;
    if weights.windows(2).any(|w| w[0] != w[1]) {
        return Err("with weights");
    }
    if controls.len() <= degree || knots.len() != controls.len() + degree + 1 {
        return Err("without control points, or with the wrong number of knots");
    }
    if !knots.is_sorted() {
        return Err("whose knots are out of order");
    }
    if controls.windows(2).any(|w| w[0].z != w[1].z) {
        return Err("that does not lie flat");
    }
    let controls: Vec<DVec2> = controls.iter().map(|p| p.truncate()).collect();
    // Each span between different knots is one polynomial; repeated knots enclose none.
    let mut pieces = Vec::new();
    for span in degree..controls.len() {
        let (a, b) = (knots[span], knots[span + 1]);
        if b > a {
            pieces.push(piece(&controls, &knots, degree, span));
        }
    }
    if pieces.is_empty() {
        return Err("whose knots are all the same");
    }
    Ok(pieces)
}

/// The Bézier curve between two knots, raised to a cubic.
fn piece(controls: &[DVec2], knots: &[f64], degree: usize, span: usize) -> [DVec2; 4] {
    let (a, b) = (knots[span], knots[span + 1]);
    let at = |arguments: [f64; 3]| blossom(controls, knots, degree, span, arguments);
    match degree {
        1 => {
            let (p, q) = (at([a; 3]), at([b; 3]));
            [p, p.lerp(q, 1.0 / 3.0), p.lerp(q, 2.0 / 3.0), q]
        }
        2 => {
            let (p, c, q) = (at([a; 3]), at([a, b, b]), at([b; 3]));
            [p, p.lerp(c, 2.0 / 3.0), q.lerp(c, 2.0 / 3.0), q]
        }
        _ => [at([a; 3]), at([a, a, b]), at([a, b, b]), at([b; 3])],
    }
}

/// The polar form of the spline's polynomial in a span, by de Boor's algorithm: Ramshaw,
/// *Blossoms are polar forms* (1989). Only the first `degree` arguments are used.
fn blossom(
    controls: &[DVec2],
    knots: &[f64],
    degree: usize,
    span: usize,
    arguments: [f64; 3],
) -> DVec2 {
    let mut points = [DVec2::ZERO; 4];
    points[..=degree].copy_from_slice(&controls[span - degree..=span]);
    for level in 1..=degree {
        for i in (level..=degree).rev() {
            let left = knots[span - degree + i];
            let right = knots[span + 1 + i - level];
            let t = (arguments[level - 1] - left) / (right - left);
            points[i] = points[i - 1].lerp(points[i], t);
        }
    }
    points[degree]
}

/// The points of a record projected to the xy plane: x of `code`, y of `code` + 10.
fn points(record: &Record, code: i16) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = Vec::new();
    for pair in &record.pairs {
        let number = || record.finite(pair.value).unwrap_or(0.0);
        match (pair.code - code, points.last_mut()) {
            (0, _) => points.push(DVec3::new(number(), 0.0, 0.0)),
            (10, Some(point)) => point.y = number(),
            (20, Some(point)) => point.z = number(),
            _ => {}
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::super::record::Records;
    use super::*;

    fn spline(
        degree: usize,
        knots: &[f64],
        controls: &[[f64; 2]],
    ) -> Result<Vec<[DVec2; 4]>, &'static str> {
        let mut text = format!("0\nSPLINE\n71\n{degree}\n");
        knots.iter().for_each(|k| text += &format!("40\n{k}\n"));
        controls
            .iter()
            .for_each(|[x, y]| text += &format!("10\n{x}\n20\n{y}\n"));
        let mut record = Record::default();
        assert!(Records::new(text.as_bytes()).read(&mut record));
        curves(&record)
    }

    #[test]
    fn a_single_piece_has_its_own_points() {
        let controls = [[0.0, 0.0], [1.0, 2.0], [-1.0, 2.0], [0.0, 0.0]];
        let curves = spline(3, &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], &controls).unwrap();
        assert_eq!(curves, [controls.map(DVec2::from)]);
    }

    #[test]
    fn uniform_splines_pass_the_known_points() {
        // A closed uniform cubic: at a knot it passes through (a + 4 b + c) / 6.
        let square = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let controls: Vec<[f64; 2]> = square.iter().chain(&square[..3]).copied().collect();
        let knots: Vec<f64> = (0..11).map(f64::from).collect();
        let curves = spline(3, &knots, &controls).unwrap();
        assert_eq!(curves.len(), 4);
        let expected = DVec2::new(0.0, 4.0 / 6.0);
        assert!(curves[0][0].distance(expected) < 1e-15, "{}", curves[0][0]);
        assert!(curves.windows(2).all(|w| w[0][3].distance(w[1][0]) < 1e-15));
        // Quadratic: the middle of a side.
        let controls: Vec<[f64; 2]> = square.iter().chain(&square[..2]).copied().collect();
        let curves = spline(2, &knots[..9], &controls).unwrap();
        assert!(curves[0][0].distance(DVec2::new(0.5, 0.5)) < 1e-15);
        let controls: Vec<[f64; 2]> = square.iter().chain(&square[..1]).copied().collect();
        let curves = spline(1, &knots[..7], &controls).unwrap();
        assert_eq!((curves.len(), curves[0][0]), (4, DVec2::new(1.0, 0.0)));
    }

    #[test]
    fn other_splines_are_reported() {
        let clamped = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let open = [[0.0, 0.0], [1.0, 2.0], [-1.0, 2.0], [0.0, 1.0]];
        let check = |degree, knots: &[f64], why| assert_eq!(spline(degree, knots, &open), Err(why));
        assert!(spline(3, &clamped, &open).is_ok());
        check(5, &clamped, "of a degree above 3");
        let count = "without control points, or with the wrong number of knots";
        check(3, &clamped[1..], count);
        check(3, &[0.0; 8], "whose knots are all the same");
        check(
            3,
            &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0],
            "whose knots are out of order",
        );
    }
}
