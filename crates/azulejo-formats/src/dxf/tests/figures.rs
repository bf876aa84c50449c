//! Closed outlines as figures.

use super::super::read_figures;
use crate::outline::Drawing;
use crate::{Memory, ReadOptions};
use glam::DVec2;
use std::f64::consts::PI;

/// Reads a whole file without errors.
fn read_text(text: &str) -> Drawing {
    let options = ReadOptions::default();
    read_figures(text.as_bytes(), "a.dxf", &Memory::new(), &options).unwrap()
}

fn drawing(entities: &str) -> Drawing {
    let text = format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    );
    read_text(&text)
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
    check(&light(0, &open), "open outline: left out");
    check(
        &(light(1, &open) + "210\n1\n220\n0\n230\n0\n"),
        "LWPOLYLINE that does not lie flat: left out",
    );
    check("0\nLINE\n10\n0\n11\n1\n", "open outline: left out");
    check(
        "0\nELLIPSE\n11\n1\n40\n1\n41\n0\n42\n1\n",
        "open outline: left out",
    );
    check(
        "0\nTEXT\n1\nx\n",
        "text \"x\": no font to set it in (install or name one), left out",
    );
    check("0\nHATCH\n", "HATCH: no outline, left out");
    check(
        "0\nINSERT\n2\nnone\n",
        "INSERT of a block that is missing: left out",
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

/// A rectangle with round corners of four lines and four arcs in any order and direction, as OpenSCAD 2021.01 has it.
#[test]
fn pieces_whose_ends_meet_are_outlines() {
    let line = |a: [f64; 2], b: [f64; 2]| {
        format!(
            "0\nLINE\n8\nx\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n",
            a[0], a[1], b[0], b[1]
        )
    };
    let arc = |c: [f64; 2], from: f64, to: f64| {
        format!(
            "0\nARC\n8\nx\n10\n{}\n20\n{}\n40\n10\n50\n{from}\n51\n{to}\n",
            c[0], c[1]
        )
    };
    let plate = [
        line([10.0, 0.0], [90.0, 0.0]),
        arc([90.0, 50.0], 0.0, 90.0),
        line([90.0, 60.0], [10.0, 60.0]),
        arc([10.0, 10.0], 180.0, 270.0),
        line([100.0, 50.0], [100.0, 10.0]),
        arc([10.0, 50.0], 90.0, 180.0),
        arc([90.0, 10.0], 270.0, 360.0),
        line([0.0, 10.0], [0.0, 50.0]),
    ];
    let hole = "0\nCIRCLE\n8\nx\n10\n50\n20\n30\n40\n8\n";
    let rounded = 6000.0 - (4.0 - PI) * 100.0;
    let area = |drawing: &Drawing| -> f64 {
        let flat = drawing.shapes[0].figure.flatten(1e-4);
        let areas = flat.iter().map(|loop_| {
            let next = loop_.iter().cycle().skip(1);
            0.5 * loop_
                .iter()
                .zip(next)
                .map(|(a, b)| a.perp_dot(*b))
                .sum::<f64>()
        });
        // The hole is inside.
        let mut areas: Vec<f64> = areas.map(f64::abs).collect();
        areas.sort_by(f64::total_cmp);
        areas.pop().unwrap() - areas.iter().sum::<f64>()
    };
    let whole = drawing(&(plate.concat() + hole));
    assert!(whole.warnings.is_empty() && whole.shapes.len() == 1);
    let expected = rounded - 64.0 * PI;
    assert!(
        (area(&whole) / expected - 1.0).abs() < 1e-5,
        "{}",
        area(&whole)
    );
    // On two layers they are one outline, too.
    let mut layers = plate.clone();
    layers[3] = layers[3].replace("\nx\n", "\ny\n");
    let layers = drawing(&(layers.concat() + hole));
    assert!(layers.warnings.is_empty(), "{:?}", layers.warnings);
    assert!((area(&layers) / expected - 1.0).abs() < 1e-5);
    // Without one piece the hole would be all there is.
    let text = format!(
        "0\nSECTION\n2\nENTITIES\n{}{hole}0\nENDSEC\n0\nEOF\n",
        plate[1..].concat()
    );
    let error = read_figures(
        text.as_bytes(),
        "a.dxf",
        &Memory::new(),
        &ReadOptions::default(),
    )
    .unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("a.dxf:5:"), "{message}");
    assert!(
        message.contains("an outline around others that is open at (10, 0)"),
        "{message}"
    );
    // A stroke inside, or one that crosses, is none around others.
    let centre_line = line([30.0, 30.0], [70.0, 30.0]);
    let marked = drawing(&(plate.concat() + hole + &centre_line));
    assert_eq!(marked.warnings[0].message, "open outline: left out");
    assert!((area(&marked) / expected - 1.0).abs() < 1e-5);
}

#[test]
fn blocks_are_put_in_their_places() {
    // A half disc of a line and a spline-free arc, around its base point, twice as wide, turned and mirrored, in a row.
    let block = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nHalf\n10\n1\n20\n0\n\
        0\nARC\n8\n0\n10\n1\n20\n0\n40\n1\n50\n0\n51\n180\n\
        0\nPOLYLINE\n8\n0\n70\n0\n0\nVERTEX\n10\n0\n0\nVERTEX\n10\n2\n0\nSEQEND\n0\nENDBLK\n\
        0\nBLOCK\n2\nself\n0\nINSERT\n2\nSELF\n0\nENDBLK\n0\nENDSEC\n";
    let read = |entities: &str| {
        let text = format!("{block}0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
        read_text(&text)
    };
    let placed =
        read("0\nINSERT\n8\ncut\n2\nhalf\n10\n5\n20\n5\n41\n2\n42\n-1\n50\n90\n70\n3\n44\n10\n");
    assert!(placed.warnings.is_empty(), "{:?}", placed.warnings);
    assert_eq!(placed.shapes.len(), 1);
    assert_eq!(placed.shapes[0].name, "cut");
    let figure = &placed.shapes[0].figure;
    assert_eq!(figure.contours.len(), 3);
    assert!((figure.signed_area().abs() - 3.0 * PI).abs() < 1e-4);
    // Turned by 90 degrees, the flat side is along y, and the mirrored bow is to the right; the row goes upward.
    let bounds = figure.bounds();
    assert!(
        bounds.min.distance(DVec2::new(5.0, 3.0)) < 1e-9,
        "{bounds:?}"
    );
    assert!(
        bounds.max.distance(DVec2::new(6.0, 27.0)) < 1e-9,
        "{bounds:?}"
    );
    let inside = read("0\nINSERT\n2\nself\n");
    assert_eq!(inside.warnings[0].message, "block inside itself: left out");
}
