//! Geometry.

use super::*;
use glam::DVec2;
use std::f64::consts::PI;

#[test]
fn exact_solids() {
    let text = [
        "Box { size 1 2 3 }",
        "Sphere { radius 2 }",
        "Cylinder { radius 2 height 6 }",
        "Cone { bottomRadius 2 height 6 }",
    ];
    let objects = [
        ": Cuboid, -0.5 -1 -1.5 to 0.5 1 1.5",
        ": Sphere, -2 -2 -2 to 2 2 2",
        ": Cylinder, -2 -3 -2 to 2 3 2",
        ": Cone { top: 0.0 }, -2 -3 -2 to 2 3 2",
    ];
    check(&text.map(shape).join("\n"), &objects);
    let (scene, _) = load(&shape("Cone { }"));
    let Shape::Primitive(cone) = &scene.objects[0].shape else {
        panic!("a cone is exact");
    };
    // The apex is above.
    assert!((cone.point(0, 0.0, 1.0).position - DVec3::Y).length() < 1e-12);
    assert!(cone.world_from_object.matrix3.determinant() > 0.0);
}

#[test]
fn open_solids() {
    let check = |geometry: &str, area: f64| {
        let mesh = mesh(&shape(geometry));
        let actual = mesh.area();
        assert!((actual / area - 1.0).abs() < 1e-2, "{geometry}: {actual}");
        for face in 0..mesh.faces.len() {
            let (p, n) = (mesh.face_positions(face)[0], mesh.face_area_vector(face));
            assert!(p.dot(n) >= 0.0, "{geometry}, face {face} looks inside");
        }
    };
    check(
        "Cylinder { radius 2 height 3 top FALSE bottom FALSE }",
        12.0 * PI,
    );
    check("Cylinder { radius 2 height 3 side FALSE }", 8.0 * PI);
    check("Cylinder { radius 2 height 3 top FALSE }", 16.0 * PI);
    check("Cone { bottomRadius 3 height 4 bottom FALSE }", 15.0 * PI);
    check("Cone { bottomRadius 3 height 4 side FALSE }", 9.0 * PI);
    let side = mesh(&shape("Cylinder { radius 2 bottom FALSE top FALSE }"));
    let normals = side.normals.unwrap();
    assert!(
        normals.values.iter().all(|n| n.y.abs() < 1e-12),
        "sides are smooth"
    );
}

#[test]
fn solids_that_show_a_picture_are_polygons() {
    let picture = "texture PixelTexture { image 1 1 3 0xFF0000 } textureTransform TextureTransform { translation 3 0 }";
    let text = format!(
        "Shape {{ appearance Appearance {{ material Material {{ }} {picture} }} geometry Sphere {{ }} }}"
    );
    let ball = mesh(&text);
    assert!((volume(&ball) / (4.0 / 3.0 * PI) - 1.0).abs() < 0.02);
    let uvs = ball.uvs.unwrap().values;
    for (p, uv) in ball.positions.iter().zip(uvs) {
        // The texture begins at the back and wraps to the left, as seen from the front.
        let (sin, cos) = (2.0 * PI * (uv.x - 3.0)).sin_cos();
        let expected = p.x.hypot(p.z) * DVec2::new(-sin, -cos);
        assert!(
            (DVec2::new(p.x, p.z) - expected).length() < 1e-12,
            "{p} {uv}"
        );
    }
}

#[test]
fn solids_without_size_or_thickness() {
    let text = format!(
        "{} Transform {{ scale 1 0 1 children {} }}",
        shape("Sphere { radius 0 }"),
        shape("Box { }")
    );
    let objects = [": 24 vertices 6 faces, -1 0 -1 to 1 0 1"];
    check_lossy(
        &text,
        &objects,
        &[":2:66: Sphere with a singular or overflowing"],
    );
}

#[test]
fn face_sets() {
    let coord = "coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 2 0 1, 2 1 1 ] }";
    let text = shape(&format!(
        "IndexedFaceSet {{ {coord} coordIndex [ 0 1 2 3 -1 1 4 5 2 -1 ] creaseAngle 1 }}"
    ));
    let smooth = mesh(&text);
    assert_eq!((smooth.positions.len(), smooth.faces.len()), (6, 2));
    let normals = smooth.normals.as_ref().unwrap();
    let middle = (DVec3::Z + DVec3::new(-1.0, 0.0, 1.0).normalize()).normalize();
    assert!((normals.at(1, 1) - middle).length() < 1e-12);
    let clockwise = mesh(&text.replace("creaseAngle 1", "ccw FALSE"));
    assert!(clockwise.normals.is_none());
    assert_eq!(clockwise.face_area_vector(0), DVec3::NEG_Z);
    let own = text.replace(
        "creaseAngle 1",
        "normalPerVertex FALSE normal Normal { vector [ 0 3 0, 1 0 0 ] } normalIndex [ 1 0 ]",
    );
    let own = mesh(&own).normals.unwrap();
    assert_eq!((own.at(0, 0), own.at(4, 1)), (DVec3::X, DVec3::Y));
}

#[test]
fn shared_coordinates_are_not_all_copied() {
    let set = |coord: &str, index: &str| {
        shape(&format!(
            "IndexedFaceSet {{ coord {coord} coordIndex [ {index} ] }}"
        ))
    };
    let first = set(
        "DEF c Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }",
        "0 1 2",
    );
    let objects = [
        ": 3 vertices 1 faces, 0 0 0 to 1 1 0",
        ": 3 vertices 1 faces, 0 0 0 to 1 1 0",
    ];
    check(&format!("{first} {}", set("USE c", "0 2 3")), &objects);
}

#[test]
fn sets_of_triangles_and_quadrilaterals() {
    let points = "0 0 0, 1 0 0, 1 1 0, 0 1 0";
    let check = |head: &str, points: &str, faces: usize, lost: usize| {
        let text = shape(&format!(
            "{head} coord Coordinate {{ point [ {points} ] }} }}"
        ));
        let text = format!("#X3D V3.3 utf8\n{text}");
        let mesh = mesh(&text);
        assert_eq!(mesh.faces.len(), faces, "{head}");
        let area: DVec3 = (0..faces).map(|f| mesh.face_area_vector(f)).sum();
        assert!((area - DVec3::Z).length() < 1e-12, "{head}: {area}");
        let (_, warnings) = load(&text);
        assert_eq!(warnings.len(), lost.min(1), "{head}: {warnings:?}");
    };
    check("QuadSet {", &format!("{points}, 5 5 5"), 1, 1);
    check("IndexedQuadSet { index [ 0 1 2 3 ]", points, 1, 0);
    check(
        "TriangleSet {",
        "0 0 0, 1 0 0, 1 1 0, 0 0 0, 1 1 0, 0 1 0",
        2,
        0,
    );
    check("IndexedTriangleSet { index [ 0 1 2 0 2 3 1 ]", points, 2, 1);
    check("TriangleFanSet { fanCount 4", points, 2, 0);
    check(
        "IndexedTriangleFanSet { index [ 0 1 2 3 -1 7 -1 ]",
        points,
        2,
        1,
    );
    let strip = "0 0 0, 1 0 0, 0 1 0, 1 1 0";
    check("TriangleStripSet { stripCount [ 4 9 ]", strip, 2, 0);
    check("IndexedTriangleStripSet { index [ 0 1 2 3 ]", strip, 2, 0);
    check(
        "IndexedTriangleStripSet { ccw FALSE index [ 1 0 3 2 ]",
        strip,
        2,
        0,
    );
}

#[test]
fn elevation_grids() {
    let text =
        shape("ElevationGrid { xDimension 3 zDimension 2 xSpacing 2 height [ 0 0 0, 1 1 1 ] }");
    check(&text, &[": 6 vertices 2 faces, 0 0 0 to 4 1 1"]);
    let mesh = mesh(&text);
    assert!(mesh.face_area_vector(0).y > 0.0);
    let uvs = mesh.uvs.unwrap();
    assert_eq!(uvs.values[1], DVec2::new(0.5, 0.0));
    let colored = shape(
        "ElevationGrid { xDimension 2 zDimension 3 height [ 0 0 0 0 0 0 ] colorPerVertex FALSE color Color { color [ 1 0 0, 0 0 1 ] } }",
    );
    let (scene, _) = load(&colored);
    let colors: Vec<_> = scene
        .materials
        .iter()
        .map(|m| m.diffuse.to_array())
        .collect();
    assert_eq!(colors, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn extrusions_are_closed_and_look_outside() {
    let square = "crossSection [ 1 1, 1 -1, -1 -1, -1 1, 1 1 ]";
    let check = |geometry: &str, expected: f64, faces: usize| {
        let mesh = mesh(&shape(&format!("Extrusion {{ {geometry} }}")));
        assert_eq!(mesh.faces.len(), faces, "{geometry}");
        let actual = volume(&mesh);
        assert!(
            (actual - expected).abs() < 1e-9 * expected.abs().max(1.0),
            "{geometry}: {actual}"
        );
    };
    check("", 4.0, 6);
    check("spine [ 5 1 0, 5 0 0 ]", 4.0, 6);
    check("spine [ 0 0 0, 0 0 3 ]", 12.0, 6);
    check(
        "spine [ 0 0 0, 1 1 1, 1 1 1, 2 2 2 ]",
        8.0 * 3f64.sqrt(),
        14,
    );
    check("scale [ 1 1, 0 0 ] spine [ 0 0 0, 0 3 0 ]", 4.0, 6);
    check("scale 2 3", 24.0, 6);
    check("orientation [ 0 1 0 0.5 ]", 4.0, 6);
    check("ccw FALSE", -4.0, 6);
    // A ring with a square cross-section, in the plane y = 0; and one that bends back.
    let ring = format!("{square} spine [ 4 0 4, 4 0 -4, -4 0 -4, -4 0 4, 4 0 4 ]");
    let mesh_of_ring = mesh(&shape(&format!("Extrusion {{ {ring} }}")));
    assert_eq!(mesh_of_ring.faces.len(), 16);
    assert!(volume(&mesh_of_ring) > 0.0);
    let bent = format!("{square} spine [ 0 0 0, 0 4 0, 4 4 0, 4 8 0 ] beginCap FALSE endCap FALSE");
    let bent = mesh(&shape(&format!("Extrusion {{ {bent} }}")));
    assert_eq!((bent.positions.len(), bent.faces.len()), (16, 12));
    // There is no twist: opposite edges of each side are parallel.
    for face in 0..bent.faces.len() {
        let p = bent.face_positions(face);
        assert!((p[1] - p[0]).dot(p[2] - p[3]) > 0.0, "{p:?}");
    }
}

#[test]
fn flat_geometry() {
    let check = |geometry: &str, area: f64| {
        let mesh = mesh(&format!("#X3D V3.3 utf8\n{}", shape(geometry)));
        assert!(
            (mesh.area() / area - 1.0).abs() < 5e-3,
            "{geometry}: {}",
            mesh.area()
        );
        assert!(
            (0..mesh.faces.len()).all(|f| mesh.face_area_vector(f).z > 0.0),
            "{geometry}"
        );
    };
    check("Rectangle2D { size 2 3 }", 6.0);
    check("Disk2D { outerRadius 2 }", 4.0 * PI);
    check("Disk2D { innerRadius 1 outerRadius 2 }", 3.0 * PI);
    check("ArcClose2D { radius 2 }", PI);
    check("ArcClose2D { radius 2 closureType \"CHORD\" }", PI - 2.0);
    check("ArcClose2D { startAngle 0 endAngle 0 }", PI);
    check("TriangleSet2D { vertices [ 0 0, 1 0, 0 1, 9 ] }", 0.5);
}
