//! Conversion of each type of entity.

use super::*;
use crate::dxf::curve::PIECES;
use azulejo_scene::{LightKind, Rgb};
use std::f64::consts::PI;

/// Area of the polygon that approximates a circle of radius 1.
fn disc() -> f64 {
    0.5 * PIECES * (2.0 * PI / PIECES).sin()
}

#[test]
fn faces() {
    let quad = only_mesh(&entities(
        "0 3DFACE; @10 0 0 1; @11 2 0 1; @12 2 3 1; @13 0 3 1; 70 15",
    ));
    check_polygons(
        &quad,
        &[&[
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [2.0, 3.0, 1.0],
            [0.0, 3.0, 1.0],
        ]],
    );
    let triangle: &[&[[f64; 3]]] = &[&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    for text in [
        "0 3DFACE; @10 0 0 0; @11 1 0 0; @12 0 1 0; @13 0 1 0",
        "0 3DFACE; @10 0 0 0; @11 1 0 0; @12 0 1 0",
        "0 3DFACE; @10 0 0 0; @11 0 0 0; @12 1 0 0; @13 0 1 0",
        "0 3DFACE; @10 0 0 0; @11 1 0 0; @12 0 1 0; @13 0 0 0",
    ] {
        check_polygons(&only_mesh(&entities(text)), triangle);
    }
    check_warnings(
        entities("0 3DFACE; @10 0 0 0; @11 1 0 0; @12 1 0 0; @13 0 0 0"),
        &[
            ":5:1: 3DFACE with fewer than three different corners: skipped",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn lines() {
    let wall = only_mesh(&entities("0 LINE; @10 1 0 2; @11 1 3 2; 39 4"));
    check_polygons(
        &wall,
        &[&[
            [1.0, 0.0, 2.0],
            [1.0, 3.0, 2.0],
            [1.0, 3.0, 6.0],
            [1.0, 0.0, 6.0],
        ]],
    );
    // End points are in the drawing's axes, thickness is along the extrusion direction.
    let tilted = only_mesh(&entities(
        "0 LINE; @10 1 0 2; @11 1 3 2; 39 5; @210 0.6 0 0.8",
    ));
    check_polygons(
        &tilted,
        &[&[
            [1.0, 0.0, 2.0],
            [1.0, 3.0, 2.0],
            [4.0, 3.0, 6.0],
            [4.0, 0.0, 6.0],
        ]],
    );
    // Release 10 stores the elevation once.
    let old = only_mesh(&entities("0 LINE; 38 7; @10 0 0; @11 1 0; 39 1"));
    assert_eq!(old.positions[0], DVec3::new(0.0, 0.0, 7.0));
    check_warnings(
        entities("0 LINE; @10 0 0 0; @11 1 0 0"),
        &[
            ":5:1: LINE without thickness or width: has no surface",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn filled_areas() {
    let corners = "@10 0 0 1; @11 2 0 1; @12 0 3 1; @13 2 3 1";
    let flat = only_mesh(&entities(&format!("0 SOLID; {corners}")));
    check_polygons(
        &flat,
        &[&[
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [2.0, 3.0, 1.0],
            [0.0, 3.0, 1.0],
        ]],
    );
    for thickness in [4.0, -4.0] {
        let body = only_mesh(&entities(&format!("0 TRACE; {corners}; 39 {thickness}")));
        assert_eq!((body.faces.len(), body.positions.len()), (6, 8));
        check_body(&body, 24.0);
        assert_eq!(body.bounds().max.z, if thickness > 0.0 { 5.0 } else { 1.0 });
    }
    // A triangle, clockwise and counter-clockwise, faces up.
    for text in [
        "@10 0 0 0; @11 1 0 0; @12 0 1 0; @13 0 1 0",
        "@10 0 0 0; @11 0 1 0; @12 1 0 0",
    ] {
        let triangle = only_mesh(&entities(&format!("0 SOLID; {text}")));
        assert_eq!(triangle.face_area_vector(0), 0.5 * DVec3::Z, "{text}");
    }
    check_warnings(
        entities("0 SOLID; @10 0 0 0; @11 1 0 0; @12 0 0 0; @13 1 0 0"),
        &[
            ":5:1: SOLID with fewer than three different corners: skipped",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn flat_entities_have_axes_of_their_own() {
    // Their x is the drawing's y, their y its z, their z its x.
    let along_x = only_mesh(&entities(
        "0 SOLID; @10 1 2 5; @11 3 2 5; @12 1 4 5; @13 3 4 5; @210 1 0 0",
    ));
    check_polygons(
        &along_x,
        &[&[
            [5.0, 1.0, 2.0],
            [5.0, 3.0, 2.0],
            [5.0, 3.0, 4.0],
            [5.0, 1.0, 4.0],
        ]],
    );
    // Mirrored: x is −x, z is −z.
    let below = only_mesh(&entities(
        "0 TRACE; @10 1 0 5; @11 2 0 5; @12 1 1 5; @13 2 1 5; @210 0 0 -1",
    ));
    check_polygons(
        &below,
        &[&[
            [-1.0, 0.0, -5.0],
            [-2.0, 0.0, -5.0],
            [-2.0, 1.0, -5.0],
            [-1.0, 1.0, -5.0],
        ]],
    );
    assert_eq!(below.face_area_vector(0), DVec3::NEG_Z);
}

#[test]
fn circles_arcs_and_ellipses() {
    let cylinder = only_mesh(&entities("0 CIRCLE; @10 5 6 7; 40 2; 39 -3"));
    assert_eq!((cylinder.faces.len(), cylinder.positions.len()), (34, 64));
    check_body(&cylinder, 4.0 * 3.0 * disc());
    let (low, high) = (cylinder.bounds().min, cylinder.bounds().max);
    assert!((low - DVec3::new(3.0, 4.0, 4.0)).length() < 1e-12, "{low}");
    assert!(
        (high - DVec3::new(7.0, 8.0, 7.0)).length() < 1e-12,
        "{high}"
    );
    // The side is smooth, top and bottom are flat.
    assert_eq!(cylinder.smoothing[..32], [1; 32]);
    assert_eq!(cylinder.smoothing[32..], [0; 2]);

    let arc = only_mesh(&entities("0 ARC; @10 0 0 0; 40 1; 50 270; 51 90; 39 2"));
    assert_eq!((arc.faces.len(), arc.positions.len()), (16, 34));
    assert!((arc.positions[0] - DVec3::NEG_Y).length() < 1e-12);
    assert!((arc.positions[32] - DVec3::Y).length() < 1e-12);
    assert!((arc.positions[16] - DVec3::X).length() < 1e-12);

    let tube = only_mesh(&entities(
        "0 ELLIPSE; @10 0 0 1; @11 0 4 0; 40 0.5; 41 0; 42 6.283185307179586; 39 1",
    ));
    check_body(&tube, 8.0 * disc());
    assert!((tube.positions[0] - DVec3::new(0.0, 4.0, 1.0)).length() < 1e-12);
    // The minor half axis is to the left of the major.
    assert!((tube.positions[16] - DVec3::new(-2.0, 0.0, 1.0)).length() < 1e-12);

    check_warnings(
        entities("0 CIRCLE; @10 0 0 0; 40 1; 0 ARC; @10 0 0 0; 40 1; 0 CIRCLE; 40 1"),
        &[
            ":5:1: CIRCLE without thickness or width: has no surface (2 times)",
            ":15:1: ARC without thickness or width: has no surface",
            ": the drawing contains no surfaces",
        ],
    );
}

#[test]
fn thin_polylines() {
    let open = only_mesh(&entities(
        "0 LWPOLYLINE; 90 3; 70 0; 38 1; 39 2; @10 0 0; @10 4 0; @10 4 3",
    ));
    check_polygons(
        &open,
        &[
            &[
                [0.0, 0.0, 1.0],
                [4.0, 0.0, 1.0],
                [4.0, 0.0, 3.0],
                [0.0, 0.0, 3.0],
            ],
            &[
                [4.0, 0.0, 1.0],
                [4.0, 3.0, 1.0],
                [4.0, 3.0, 3.0],
                [4.0, 0.0, 3.0],
            ],
        ],
    );
    assert_eq!(open.positions.len(), 6);
    // Closed, in either direction, the front is outside; a repeated point counts once.
    for points in [
        "@10 0 0; @10 1 0; @10 1 0; @10 1 1; @10 0 1",
        "@10 0 0; @10 0 1; @10 1 1; @10 1 0",
    ] {
        for thickness in [2.0, -2.0] {
            let text = format!("0 LWPOLYLINE; 70 1; 39 {thickness}; {points}");
            let room = only_mesh(&entities(&text));
            assert_eq!(room.faces.len(), 4, "{text}");
            for f in 0..4 {
                let middle = room.face_positions(f).into_iter().sum::<DVec3>() / 4.0;
                let outside = middle - DVec3::new(0.5, 0.5, 0.5 * thickness);
                assert!(room.face_area_vector(f).dot(outside) > 0.0, "{text}");
            }
        }
    }
}

#[test]
fn bulges_are_smooth_and_stay_within_the_tolerance() {
    // A slot: two straight sides and two half circles.
    let text = "0 LWPOLYLINE; 70 1; 39 1; @10 0 0; @10 4 0; 42 1; @10 4 2; @10 0 2; 42 1";
    let slot = only_mesh(&entities(text));
    assert_eq!((slot.faces.len(), slot.positions.len()), (34, 68));
    assert_eq!(slot.smoothing[0], 0);
    assert_eq!(slot.smoothing[1..17], [1; 16]);
    assert_eq!(slot.smoothing[17], 0);
    assert_eq!(slot.smoothing[18..], [2; 16]);
    assert!((slot.bounds().min - DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-12);
    assert!((slot.bounds().max - DVec3::new(5.0, 2.0, 1.0)).length() < 1e-12);
    let centre = DVec3::new(4.0, 1.0, 0.0);
    for f in 1..17 {
        let corners = slot.face_positions(f);
        let middle = 0.5 * (corners[0] + corners[1]);
        assert!((centre - corners[0]).length() < 1.0 + 1e-12);
        assert!((centre - middle).length() > 1.0 - 0.005);
    }
}

#[test]
fn wide_polylines() {
    // Flat, with a mitre: the outer corner is half a width beyond both sides.
    let band = only_mesh(&entities("0 LWPOLYLINE; 43 2; @10 0 0; @10 9 0; @10 9 5"));
    check_polygons(
        &band,
        &[
            &[
                [0.0, -1.0, 0.0],
                [10.0, -1.0, 0.0],
                [8.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ],
            &[
                [10.0, -1.0, 0.0],
                [10.0, 5.0, 0.0],
                [8.0, 5.0, 0.0],
                [8.0, 1.0, 0.0],
            ],
        ],
    );
    assert_eq!(band.positions.len(), 6);
    // With thickness: solids, open and closed.
    let wall = only_mesh(&entities(
        "0 LWPOLYLINE; 43 2; 39 3; @10 0 0; @10 9 0; @10 9 5",
    ));
    check_body(&wall, 3.0 * (2.0 * 9.0 + 2.0 * 5.0));
    let frame = only_mesh(&entities(
        "0 LWPOLYLINE; 70 1; 43 2; 39 -3; @10 0 0; @10 9 0; @10 9 5; @10 0 5",
    ));
    check_body(&frame, 3.0 * (11.0 * 7.0 - 7.0 * 3.0));
    assert_eq!((frame.faces.len(), frame.positions.len()), (16, 16));
    // A ring of two half circles, as DONUT makes it.
    let ring = only_mesh(&entities(
        "0 LWPOLYLINE; 70 1; 43 1; 39 1; @10 -1 0; 42 1; @10 1 0; 42 1",
    ));
    check_body(&ring, disc() * (1.5 * 1.5 - 0.5 * 0.5));
    assert_eq!(ring.smoothing.iter().filter(|g| **g == 1).count(), 64);
}

#[test]
fn widths_may_change() {
    // An arrow: a shaft of one width and a head that ends in a point.
    let arrow = only_mesh(&entities(
        "0 LWPOLYLINE; @10 0 0; 40 1; 41 1; @10 4 0; 40 3; 41 0; @10 6 0",
    ));
    check_polygons(
        &arrow,
        &[
            &[
                [0.0, -0.5, 0.0],
                [4.0, -0.5, 0.0],
                [4.0, 0.5, 0.0],
                [0.0, 0.5, 0.0],
            ],
            &[
                [4.0, -1.5, 0.0],
                [6.0, 0.0, 0.0],
                [6.0, 0.0, 0.0],
                [4.0, 1.5, 0.0],
            ],
        ],
    );
    // A segment that turns back on itself has no mitre.
    let back = only_mesh(&entities(
        "0 LWPOLYLINE; 43 2; 39 1; @10 0 0; @10 5 0; @10 1 0",
    ));
    assert_eq!(back.bounds().max.x, 5.0);
    assert_eq!(back.faces.len(), 12);
}

#[test]
fn old_polylines() {
    // The same band as an LWPOLYLINE; elevations of vertices and control points are ignored.
    let text = "0 POLYLINE; 66 1; @10 0 0 4; 70 0; 40 2; 41 2;
        0 VERTEX; @10 0 0 4; 0 VERTEX; @10 9 0 4; 0 VERTEX; @10 7 7 4; 70 16;
        0 VERTEX; @10 9 5 4; 40 1; 41 1; 0 SEQEND";
    let band = only_mesh(&entities(text));
    check_polygons(
        &band,
        &[
            &[
                [0.0, -1.0, 4.0],
                [10.0, -1.0, 4.0],
                [8.0, 1.0, 4.0],
                [0.0, 1.0, 4.0],
            ],
            &[
                [10.0, -1.0, 4.0],
                [10.0, 5.0, 4.0],
                [8.0, 5.0, 4.0],
                [8.0, 1.0, 4.0],
            ],
        ],
    );
    check_warnings(
        entities(
            "0 POLYLINE; 70 8; 0 VERTEX; @10 0 0 1; 0 VERTEX; @10 1 0 1; 0 SEQEND;
            0 POLYLINE; 0 VERTEX; @10 0 0 1; 0 VERTEX; @10 1 0 1; 0 SEQEND",
        ),
        &[
            ":5:1: spatial POLYLINE: has no surface",
            ":27:1: POLYLINE without thickness or width: has no surface",
            ": the drawing contains no surfaces",
        ],
    );
}

/// A polygon mesh of three rows and two columns, with additional flags and groups.
fn polygon_mesh(flags: i32, more: &str) -> String {
    let vertex = |(x, y): (i32, i32)| format!("0 VERTEX; @10 {x} {y} 0; 70 64;");
    let places = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)];
    let vertices: String = places.into_iter().map(vertex).collect();
    format!(
        "0 POLYLINE; 66 1; 70 {}; {more} {vertices} 0 SEQEND",
        flags | 16
    )
}

#[test]
fn meshes_of_rows_and_columns() {
    let open = only_mesh(&entities(&polygon_mesh(0, "71 3; 72 2;")));
    assert_eq!(open.positions.len(), 6);
    assert_eq!(
        open.faces.iter().collect::<Vec<_>>(),
        [[0, 2, 3, 1], [2, 4, 5, 3]]
    );
    let closed = only_mesh(&entities(&polygon_mesh(1, "71 3; 72 2;")));
    assert_eq!(closed.faces.get(2), [4, 0, 1, 5]);
    let closed = only_mesh(&entities(&polygon_mesh(33, "71 2; 72 3;")));
    assert_eq!(closed.faces.len(), 6);
    assert_eq!(closed.faces.get(2), [2, 5, 3, 0]);
    // Smoothed: control points are left out, and the dimensions differ.
    let control = "71 9; 72 9; 73 3; 74 2; 75 6; 0 VERTEX; @10 9 9 9; 70 80;";
    let smooth = only_mesh(&entities(&polygon_mesh(4, control)));
    assert_eq!((smooth.faces.len(), smooth.positions.len()), (2, 6));

    let message = "polygon mesh whose vertex count is not rows × columns: complete rows are kept";
    let short = load(entities(&polygon_mesh(0, "71 4; 72 2;")));
    assert_eq!(warnings(&short), [format!(":5:1: {message}")]);
    assert_eq!(mesh(&short, 0).faces.len(), 2);
    let none = load(entities(&polygon_mesh(0, "71 1; 72 0;")));
    assert_eq!(
        warnings(&none),
        [
            format!(":5:1: {message}"),
            ": the drawing contains no surfaces".into()
        ]
    );
}

#[test]
fn meshes_of_faces() {
    let text = "0 POLYLINE; 8 wall; 66 1; 70 64; 62 3;
        0 VERTEX; @10 0 0 0; 70 192; 0 VERTEX; @10 1 0 0; 70 192;
        0 VERTEX; @10 1 1 0; 70 192; 0 VERTEX; @10 0 1 0; 70 192;
        0 VERTEX; @10 0 0 0; 70 128; 71 1; 72 -2; 73 3; 74 -4;
        0 VERTEX; 70 128; 62 1; 71 1; 72 2; 73 3; 0 VERTEX; 70 128; 71 1; 72 2; 73 3; 74 3;
        0 VERTEX; 70 128; 71 1; 72 2; 73 5; 0 VERTEX; 70 128; 71 1; 72 2; 0 SEQEND; 8 wall";
    let loaded = load(entities(text));
    assert_eq!(
        warnings(&loaded),
        [":5:1: face of a polyface mesh with too few or invalid corners: skipped (2 times)",]
    );
    let mesh = mesh(&loaded, 0);
    assert_eq!(
        mesh.faces.iter().collect::<Vec<_>>(),
        [&[0, 1, 2, 3][..], &[0, 1, 2], &[0, 1, 2]]
    );
    // A face may have a colour of its own.
    assert_eq!(mesh.face_materials, [0, 1, 0]);
    assert_eq!(materials(&loaded), ["wall/3", "wall/1"]);
    assert_eq!(loaded.scene.materials[1].diffuse, Rgb::new(1.0, 0.0, 0.0));
}

#[test]
fn cages() {
    let text = "0 MESH; 100 AcDbSubDMesh; 71 2; 72 0; 91 LEVEL; 92 4;
        @10 0 0 0; @10 1 0 0; @10 1 1 0; @10 0 1 0;
        93 8; 90 4; 90 0; 90 1; 90 2; 90 3; 90 3; 90 0; 90 1; 90 2;
        94 1; 90 0; 90 1; 95 1; 140 0; 90 1; 91 5; 92 1";
    let cage = only_mesh(&entities(
        &text.replace("LEVEL", "0").replace("93 8", "93 9"),
    ));
    assert_eq!(
        cage.faces.iter().collect::<Vec<_>>(),
        [&[0, 1, 2, 3][..], &[0, 1, 2]]
    );
    let smooth = load(entities(
        &text.replace("LEVEL", "2").replace("93 8", "93 9"),
    ));
    assert_eq!(
        warnings(&smooth),
        [":5:1: MESH of smoothness 2: its control cage is used without subdivision"]
    );
    assert_eq!(mesh(&smooth, 0).positions, cage.positions);
    // Corners that do not exist, and a list that ends inside a face.
    let lost = |faces: &str| {
        let text = format!("0 MESH; 92 3; @10 0 0 0; @10 1 0 0; @10 1 1 0; {faces}");
        let loaded = load(entities(&text));
        (loaded.scene.objects.len(), loaded.warnings[0].count)
    };
    assert_eq!(
        lost("93 8; 90 3; 90 0; 90 1; 90 2; 90 3; 90 0; 90 1; 90 3"),
        (1, 1)
    );
    assert_eq!(lost("93 4; 90 3; 90 0; 90 1"), (0, 1));
    assert_eq!(lost("93 1; 90 -1"), (0, 1));
    assert_eq!(lost("93 3; 90 2; 90 0; 90 1"), (0, 1));
}

#[test]
fn lights() {
    let text = "0 LIGHT; 1 bulb; 70 2; 290 1; 40 100; @10 1 2 3; 72 2; 421 16711680;
        0 LIGHT; 1 lamp; 70 3; 40 8; @10 0 0 3; @11 0 0 1; 50 40; 51 60; 72 2;
        0 LIGHT; 1 sun; 70 1; 63 7; 40 2; @10 0 0 1; @11 3 0 5; 72 2;
        0 LIGHT; 70 2; 290 0; 0 LIGHT; 70 3; 0 LIGHT; 70 2; 72 0";
    let loaded = load(entities(text));
    let lights = &loaded.scene.lights;
    assert_eq!(lights.len(), 4);
    assert_eq!(lights[0].name, "bulb");
    let bulb = LightKind::Point {
        position: DVec3::new(1.0, 2.0, 3.0),
        intensity: Rgb::new(100.0, 0.0, 0.0),
    };
    assert_eq!(lights[0].kind, bulb);
    let lamp = LightKind::Spot {
        position: DVec3::new(0.0, 0.0, 3.0),
        direction: DVec3::NEG_Z,
        intensity: Rgb::grey(8.0),
        inner: 20f64.to_radians(),
        outer: 30f64.to_radians(),
    };
    assert_eq!(lights[1].kind, lamp);
    let LightKind::Directional {
        direction,
        irradiance,
        ..
    } = lights[2].kind
    else {
        panic!("{:?}", lights[2]);
    };
    assert!((direction - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
    assert_eq!(irradiance, Rgb::grey(2.0));
    let messages = warnings(&loaded);
    assert!(
        messages[0].ends_with("LIGHT that is off: left out"),
        "{messages:?}"
    );
    assert!(
        messages[1].ends_with("LIGHT without a direction: left out"),
        "{messages:?}"
    );
    assert!(
        messages[2].contains("falls off with the inverse square of the distance"),
        "{messages:?}"
    );
}

#[test]
fn other_entities_are_reported() {
    check_warnings(
        entities(
            "0 TEXT; 1 a; 0 3DSOLID; 1 xyz; 0 TEXT; 1 b; 0 VERTEX; 0 ATTRIB; 0 SEQEND;
            0 LINE; 67 1; 0 3DFACE; 60 1; 0 MESH; 93 0; 440 33554559",
        ),
        &[
            ":5:1: TEXT: not read or without a surface: skipped (2 times)",
            ":9:1: 3DSOLID: ACIS solid, whose data format is undocumented: skipped; export it as a mesh",
            ":17:1: VERTEX without a POLYLINE: skipped",
            ":23:1: entity in paper space: left out",
            ":27:1: invisible entity: left out",
            ":31:1: transparent entity: opaque",
            ": the drawing contains no surfaces",
        ],
    );
}
