//! Closed outlines as figures.

use super::super::read_figures;
use crate::ReadOptions;
use crate::outline::Drawing;
use glam::DVec2;
use std::f64::consts::PI;

fn drawing(entities: &str) -> Drawing {
    let text = format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    );
    read_figures(text.as_bytes(), "a.dxf", &ReadOptions::default()).unwrap()
}

fn light(flags: u32, vertices: &[(f64, f64, f64)]) -> String {
    let mut text = format!("0\nLWPOLYLINE\n8\ncut\n70\n{flags}\n");
    for (x, y, bulge) in vertices {
        text += &format!("10\n{x}\n20\n{y}\n42\n{bulge}\n");
    }
    text
}

fn check_area(entities: &str, area: f64) {
    let drawing = drawing(entities);
    assert!(drawing.warnings.is_empty(), "{:?}", drawing.warnings);
    assert_eq!(drawing.shapes.len(), 1, "{entities}");
    let actual = drawing.shapes[0].figure.signed_area().abs();
    assert!(
        (actual - area).abs() < 1e-4 * area,
        "{entities} {actual} {area}"
    );
}

#[test]
fn outlines_have_their_areas() {
    let square = [
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (2.0, 2.0, 0.0),
        (0.0, 2.0, 0.0),
    ];
    check_area(&light(1, &square), 4.0);
    let mut round = square;
    round[1].2 = 1.0;
    check_area(&light(1, &round), 4.0 + 0.5 * PI);
    round[1].2 = -1.0;
    check_area(&light(1, &round), 4.0 - 0.5 * PI);
    // Seen from below it is mirrored, including its bulge.
    round[1].2 = 1.0;
    let below = light(1, &round) + "210\n0\n220\n0\n230\n-1\n";
    check_area(&below, 4.0 + 0.5 * PI);
    assert_eq!(
        drawing(&below).shapes[0].figure.bounds().max,
        DVec2::new(0.0, 2.0)
    );
    let closed = [
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (2.0, 2.0, 0.0),
        (0.0, 0.0, 0.0),
    ];
    check_area(&light(0, &closed), 2.0);
    check_area("0\nCIRCLE\n10\n5\n20\n5\n40\n3\n", 9.0 * PI);
    check_area(
        "0\nELLIPSE\n10\n5\n20\n5\n11\n0\n21\n4\n40\n0.5\n41\n0\n42\n6.283185307179586\n",
        8.0 * PI,
    );
    let old = "0\nPOLYLINE\n66\n1\n70\n1\n0\nVERTEX\n10\n0\n20\n0\n42\n1\n0\nVERTEX\n10\n2\n20\n0\n42\n1\n0\nSEQEND\n";
    check_area(old, PI);
}

#[test]
fn layers_are_figures_with_holes() {
    let ring =
        "0\nCIRCLE\n8\nRing\n40\n3\n0\nCIRCLE\n8\nring\n40\n1\n0\nCIRCLE\n8\nb\n10\n9\n40\n1\n";
    let drawing = drawing(ring);
    let names: Vec<&str> = drawing.shapes.iter().map(|s| &*s.name).collect();
    assert_eq!(names, ["Ring", "b"]);
    let figure = &drawing.shapes[0].figure;
    assert!(figure.contains(DVec2::new(2.0, 0.0)) && !figure.contains(DVec2::ZERO));
    assert_eq!(drawing.metres_per_unit, Some(1e-3));
}

#[test]
fn left_out_outlines_are_reported() {
    let check = |entities: &str, message: &str| {
        let drawing = drawing(entities);
        let messages: Vec<&str> = drawing.warnings.iter().map(|w| &*w.message).collect();
        assert_eq!(
            (drawing.shapes.len(), messages),
            (0, vec![message]),
            "{entities}"
        );
    };
    let open = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 2.0, 0.0)];
    check(&light(0, &open), "open polyline: left out");
    check(
        &(light(1, &open) + "210\n1\n220\n0\n230\n0\n"),
        "LWPOLYLINE that does not lie flat: left out",
    );
    check(
        "0\nLINE\n10\n0\n11\n1\n",
        "LINE: no closed outline, left out",
    );
    check(
        "0\nELLIPSE\n11\n1\n40\n1\n41\n0\n42\n1\n",
        "arc of an ELLIPSE: open, left out",
    );
    check(
        "0\nPOLYLINE\n70\n64\n0\nVERTEX\n10\n1\n0\nSEQEND\n",
        "POLYLINE that is a mesh: left out",
    );
    check(
        "0\nCIRCLE\n40\n1\n67\n1\n",
        "entity in paper space or invisible: left out",
    );
    check(
        "0\nSPLINE\n71\n3\n",
        "SPLINE without control points, or with the wrong number of knots: left out",
    );
}
