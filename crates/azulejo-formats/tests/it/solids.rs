//! Solids in STL and 3MF: closed as programs see them that merge equal positions, with the volume of the exact shape.

use azulejo_formats::{open_objects, outline::ppf, stl, three_mf};
use azulejo_scene::{
    Bevel, BevelEnds, BevelProfile, Contour, Csg, Exact, Figure, FillRule, Material, Mesh, Object,
    Operation, Primitive, Prism, Rgb, Scene, Shape, Solid, Units, Up,
};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

const FONT: &[u8] = include_bytes!("../../../../examples/fonts/dejavu-serif.ppf");

fn scene(solids: Vec<Solid>) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let exact = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new("solid", exact));
    scene.units = Units {
        metres_per_unit: Some(1e-3),
        up: Up::Z,
        photometric: false,
    };
    scene.validate().unwrap();
    scene
}

fn prism(figure: &Arc<Figure>, world_from_figure: DAffine3, bevel: Option<Bevel>) -> Solid {
    Solid::Prism(Prism {
        figure: Arc::clone(figure),
        world_from_figure,
        material: 0,
        bevel: bevel.map(Arc::new),
    })
}

fn round(inset: f64, depth: f64, ends: BevelEnds) -> Bevel {
    Bevel {
        profile: BevelProfile::Round,
        inset,
        depth,
        ends,
    }
}

/// The triangles of a binary STL.
fn facets(scene: &Scene, tolerance: Option<f64>) -> Vec<[[f32; 3]; 3]> {
    let mut bytes = Vec::new();
    stl::write_within(scene, tolerance, &mut bytes).unwrap();
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let facet = |b: &[u8]| {
        let x: Vec<f32> = b[12..48].chunks(4).map(number).collect();
        [[x[0], x[1], x[2]], [x[3], x[4], x[5]], [x[6], x[7], x[8]]]
    };
    bytes[84..].chunks_exact(50).map(facet).collect()
}

/// Volume of triangles, each edge of which has exactly two, of opposite directions; none is without area.
fn closed_volume(facets: &[[[f32; 3]; 3]], what: &str) -> f64 {
    let key = |p: [f32; 3]| p.map(|x| if x == 0.0 { 0 } else { x.to_bits() });
    let mut edges: HashMap<_, i32> = HashMap::new();
    let mut volume = 0.0;
    for t in facets {
        let [a, b, c] = t.map(|p| DVec3::from_array(p.map(f64::from)));
        assert!((b - a).cross(c - a).length() > 0.0, "{what}: {t:?}");
        volume += a.dot(b.cross(c)) / 6.0;
        for k in 0..3 {
            *edges.entry([key(t[k]), key(t[(k + 1) % 3])]).or_default() += 1;
        }
    }
    let is_closed =
        |(&[a, b], &n): (&[[u32; 3]; 2], &i32)| n == 1 && edges.get(&[b, a]) == Some(&1);
    let open = edges.iter().filter(|e| !is_closed(*e)).count();
    assert_eq!(open, 0, "{what}: edges of {} triangles", facets.len());
    volume
}

fn check(scene: &Scene, tolerance: Option<f64>, what: &str) -> f64 {
    let volume = closed_volume(&facets(scene, tolerance), what);
    assert!(volume > 0.0, "{what}: {volume}");
    let mut package = Vec::new();
    three_mf::write_within(scene, tolerance, &mut package).unwrap();
    volume
}

/// Every glyph of the font in an awkward place, flat and bevelled.
#[test]
fn all_letters_are_closed() {
    let (font, _) = ppf::read(FONT, "dejavu-serif.ppf").unwrap();
    let em = 10.0;
    let turned = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.3);
    let map = DAffine3 {
        matrix3: turned * DMat3::from_diagonal(DVec3::new(em, em, -2.5)),
        translation: DVec3::new(31.7, -12.3, 250.1),
    };
    let edges = [
        None,
        Some(round(0.03, 0.3, BevelEnds::Front)),
        Some(round(0.015, 0.15, BevelEnds::Both)),
        Some(Bevel {
            profile: BevelProfile::Chamfer,
            ..round(0.06, 0.5, BevelEnds::Front)
        }),
    ];
    let mut count = 0;
    for (name, glyph) in &font.glyphs {
        if glyph.figure.contours.is_empty() {
            continue;
        }
        count += 1;
        // Each letter flat, and with one of the bevels.
        for bevel in [edges[0], edges[1 + count % 3]] {
            let scene = scene(vec![prism(&glyph.figure, map, bevel)]);
            check(&scene, None, &format!("{name} {bevel:?}"));
        }
    }
    assert!(count > 90, "{count}");
}

/// The area of a letter, by its curves, times its depth.
#[test]
fn volumes_converge_to_the_exact_ones() {
    let (font, _) = ppf::read(FONT, "dejavu-serif.ppf").unwrap();
    let map = DAffine3::from_scale(DVec3::new(10.0, 10.0, 2.5));
    for name in ["a", "B", "ampersand", "S", "at"] {
        let figure = &font.glyphs[name].figure;
        let exact = figure.signed_area().abs() * 100.0 * 2.5;
        let scene = scene(vec![prism(figure, map, None)]);
        let off = |tolerance: f64| {
            let volume = check(&scene, Some(tolerance), name);
            (volume / exact - 1.0).abs()
        };
        let [coarse, fine, finest] = [0.1, 0.01, 1e-4].map(off);
        assert!(coarse < 0.05, "{name}: {coarse}");
        assert!(fine < 0.2 * coarse, "{name}: {coarse} {fine}");
        // As exact as single precision.
        assert!(finest < 3e-5, "{name}: {finest}");
    }
}

fn square(low: f64, high: f64) -> Contour {
    let corners = [(low, low), (high, low), (high, high), (low, high)];
    Figure::polygon(corners.map(DVec2::from)).contours.remove(0)
}

/// What touches itself, its neighbour, or lies in one place twice: no edge has four triangles.
#[test]
fn what_touches_is_apart() {
    let figure = |contours: Vec<Contour>, rule| Arc::new(Figure { contours, rule });
    let corner = figure(vec![square(0.0, 1.0), square(1.0, 2.0)], FillRule::EvenOdd);
    let one = figure(vec![square(0.0, 1.0)], FillRule::EvenOdd);
    let at = |x: f64, y: f64| DAffine3::from_translation(DVec3::new(x, y, 0.0));
    let cases = [
        ("corner", vec![prism(&corner, at(0.0, 0.0), None)], 2.0),
        (
            "neighbours",
            vec![
                prism(&one, at(0.0, 0.0), None),
                prism(&one, at(1.0, 0.0), None),
            ],
            2.0,
        ),
        (
            "diagonal",
            vec![
                prism(&one, at(0.0, 0.0), None),
                prism(&one, at(1.0, 1.0), None),
            ],
            2.0,
        ),
        (
            "a board of nine, two of them twice",
            (0..11)
                .map(|k| prism(&one, at(f64::from(k % 3), f64::from(k % 9 / 3)), None))
                .collect(),
            11.0,
        ),
        (
            "far away",
            (0..3)
                .map(|k| prism(&one, at(54_321.0 + f64::from(k), 1e5), None))
                .collect(),
            3.0,
        ),
    ];
    for (what, solids, volume) in cases {
        let found = check(&scene(solids), None, what);
        let relative = if what == "far away" { 0.2 } else { 1e-4 };
        assert!((found / volume - 1.0).abs() < relative, "{what}: {found}");
    }
}

#[test]
fn primitives_and_set_operations_are_closed() {
    let turned = |map: DAffine3, mut p: Primitive| {
        p.transform(&map);
        p
    };
    let tilt = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.8);
    let ball = Primitive::sphere(DVec3::new(0.3, 0.2, 0.1), 1.0, 0);
    let cube = Primitive::new(
        azulejo_scene::PrimitiveKind::Cuboid,
        DAffine3::from_translation(DVec3::splat(-0.4)),
        0,
    );
    let rod = Primitive::new(
        azulejo_scene::PrimitiveKind::Cylinder,
        DAffine3::from_scale_rotation_translation(
            DVec3::new(0.35, 0.35, 4.0),
            glam::DQuat::IDENTITY,
            DVec3::new(0.1, 0.05, -2.0),
        ),
        0,
    );
    let all = [&ball, &cube, &rod].map(|p| turned(tilt, p.clone()));
    for p in &all {
        check(&scene(vec![Solid::Primitive(p.clone())]), None, "primitive");
    }
    for operation in [
        Operation::Union,
        Operation::Difference,
        Operation::Intersection,
    ] {
        for (i, a) in all.iter().enumerate() {
            for (k, b) in all.iter().enumerate().filter(|(k, _)| *k != i) {
                for tolerance in [None, Some(0.02), Some(0.001)] {
                    let csg = Solid::Csg(Box::new(Csg {
                        operation,
                        left: vec![Solid::Primitive(a.clone())],
                        right: vec![Solid::Primitive(b.clone())],
                    }));
                    let what = format!("{operation:?} {i} {k} {tolerance:?}");
                    check(&scene(vec![csg]), tolerance, &what);
                }
            }
        }
    }
}

#[test]
fn tolerances_beyond_single_precision_are_refused() {
    let ball = scene(vec![Solid::Primitive(Primitive::sphere(
        DVec3::ZERO,
        1.0,
        0,
    ))]);
    let message = stl::write_within(&ball, Some(1e-9), &mut Vec::new()).unwrap_err();
    let message = message.to_string();
    assert!(
        message.starts_with("object \"solid\": found a tolerance of 1e-9, expected at least"),
        "{message}"
    );
}

/// Meshes are as they are, and the open ones are known by name.
#[test]
fn open_meshes_are_named() {
    let mut sheet = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
        ..Mesh::default()
    };
    sheet.push_face(&[0, 1, 2, 3], 0);
    let mut scene = scene(vec![Solid::Primitive(Primitive::sphere(
        DVec3::ZERO,
        1.0,
        0,
    ))]);
    let before = facets(&scene, None).len();
    scene.objects.push(Object::new("floor", Shape::Mesh(sheet)));
    let square = Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, 0);
    scene
        .objects
        .push(Object::new("lamp", Shape::Primitive(square)));
    assert_eq!(facets(&scene, None).len(), before + 4);
    assert_eq!(open_objects(&scene), [("floor", 4), ("lamp", 4)]);
}
