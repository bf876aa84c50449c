//! Rows and groups.

use super::*;
use azulejo_factors::form_factors::Plan;
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};
use azulejo_factors::{FormFactorOptions, PatchSize};
use azulejo_scene::synthetic::cube_room;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

/// Fronts of one material, each an object without a name, with exchange areas and no light from elsewhere.
pub fn fronts(areas: Vec<f64>, exchange: ExchangeAreas) -> Enclosure {
    let n = areas.len();
    let face = |object| FaceId { object, face: 0 };
    Enclosure {
        factors: FormFactors {
            exchange,
            areas,
            faces: (0..n as u32).map(face).collect(),
            materials: vec![0; n],
            is_back: vec![false; n],
            rest: vec![RowRemainder::default(); n],
            ends: vec![1.0; n],
            row_errors: vec![0.0; n],
            ..FormFactors::default()
        },
        rows: RowTable {
            materials: vec!["grey".into()],
            diffuse: vec![Rgb::grey(0.2); n],
            ..RowTable::default()
        },
        outside: None,
        sky: None,
        elsewhere: None,
    }
}

/// Two rows, half of whose light came by a mirror.
pub fn two_squares() -> Enclosure {
    let face = |object, face| FaceId { object, face };
    let pair = |share: f64| Exchange {
        column: 1,
        value: 0.5 * share,
        error: 0.25 * share as f32,
    };
    let areas = |share| ExchangeAreas::from_iter([vec![pair(share)], vec![]]);
    let rest = |sky| RowRemainder {
        sky,
        sky_error: 0.0625,
        ..RowRemainder::default()
    };
    let factors = FormFactors {
        exchange: areas(1.0),
        orders: vec![
            areas(0.5),
            areas(0.5),
            ExchangeAreas::from_iter([vec![], vec![]]),
        ],
        areas: vec![2.0, 1.0],
        faces: vec![face(0, 3), face(1, 0)],
        materials: vec![0, 0],
        is_back: vec![false, true],
        rest: vec![rest(0.75), rest(0.5)],
        ends: vec![1.0; 2],
        row_errors: vec![0.1, 0.2],
        ..FormFactors::default()
    };
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let square = vec![
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    let triangle = vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0)];
    Enclosure {
        factors,
        rows: RowTable {
            names: vec!["floor/3".into(), "lid/0 (back)".into()],
            objects: vec!["floor".into(), "lid".into()],
            materials: vec!["grey".into()],
            diffuse: vec![Rgb::grey(0.25), Rgb::new(0.5, 0.25, 0.0)],
            cells: CellMesh::new([square, triangle]),
            metres_per_unit: Some(0.5),
            ..RowTable::default()
        },
        outside: None,
        sky: None,
        elsewhere: None,
    }
}

/// The faces of two coincident rooms.
fn rooms(two_sided: bool) -> Enclosure {
    let mut scene = cube_room();
    scene.objects[0].name = "room".to_owned();
    scene.materials[0].name = "grey".to_owned();
    scene.merge(scene.clone());
    let options = FormFactorOptions {
        two_sided,
        rays: 4,
        analytic: false,
        size: PatchSize::Edge(0.6),
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(&scene);
    let plan = Plan::new(&scene, &tracer, &options).unwrap();
    let prepared = plan.prepare();
    let factors = prepared.compute(&Progress::new()).unwrap();
    Enclosure::new(&prepared, &scene, factors)
}

fn check(by: GroupBy, two_sided: bool, expected: &[&str]) {
    let enclosure = rooms(two_sided);
    let groups = enclosure.groups(by);
    assert_eq!(groups.names, expected);
    let last = groups.of_rows.iter().flatten().max();
    assert_eq!(last, Some(&(expected.len() as u32 - 1)));
    let grouped = enclosure.grouped(&groups);
    assert!(grouped.rows.are_groups && grouped.rows.names == expected);
    // Each cell now belongs to a group, and groups are as large as their cells.
    let cells = &grouped.rows.cells;
    let mut areas = vec![0.0; expected.len()];
    for (i, &row) in cells.rows.iter().enumerate() {
        areas[row as usize] += azulejo_scene::math::area_vector(&cells.polygon(i)).length();
    }
    for (a, b) in areas.iter().zip(&grouped.factors.areas) {
        assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
    }
}

#[test]
fn names_are_unique_and_backs_are_separate() {
    check(GroupBy::Object, false, &["room #0", "room #1"]);
    check(GroupBy::Material, false, &["grey #0", "grey #1"]);
    let with_backs = ["room #0", "room (back) #1", "room #2", "room (back) #3"];
    check(GroupBy::Object, true, &with_backs);
}

#[test]
fn patches_are_named_by_object_face_and_number() {
    let enclosure = rooms(true);
    // Cells of edge 0.5: four patches a face.
    assert_eq!(enclosure.len(), 2 * 2 * 6 * 4);
    assert_eq!(enclosure.rows.names[0], "room/0.0 #0");
    assert_eq!(enclosure.rows.names[1], "room/0.0 (back) #1");
    let mut scene = cube_room();
    scene.objects[0].name = "room".to_owned();
    let whole = FormFactorOptions {
        size: PatchSize::Edge(0.0),
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(&scene);
    let plan = Plan::new(&scene, &tracer, &whole).unwrap();
    let prepared = plan.prepare();
    let factors = prepared.compute(&Progress::new()).unwrap();
    let enclosure = Enclosure::new(&prepared, &scene, factors);
    assert_eq!(enclosure.rows.names[5], "room/5");
}

#[test]
fn rows_face_the_side_that_they_are() {
    let enclosure = rooms(true);
    let frames = enclosure.rows.cells.frames(enclosure.len());
    for pair in frames.chunks_exact(2) {
        assert!((pair[0].1 + pair[1].1).length() < 1e-12);
        assert!((pair[0].0 - pair[1].0).length() < 1e-12);
        // A room is seen from inside.
        let middle = DVec3::splat(0.5);
        assert!(pair[0].1.dot(middle - pair[0].0) > 0.0, "{pair:?}");
    }
}

#[test]
fn light_of_groups_is_a_mean_by_area() {
    let mut enclosure = two_squares();
    let light = |e: f64, s: f64| OutsideLight {
        irradiance: Rgb::grey(e),
        error: Rgb::grey(s),
    };
    enclosure.outside = Some(vec![light(1.0, 0.3), light(4.0, 0.8)]);
    let groups = Groups {
        of_rows: vec![Some(0); 2],
        names: vec!["all".into()],
    };
    let grouped = enclosure.grouped(&groups).outside.unwrap();
    assert_eq!(grouped[0].irradiance, Rgb::grey(2.0));
    let expected = (0.6f64.powi(2) + 0.8f64.powi(2)).sqrt() / 3.0;
    assert!((grouped[0].error.r - expected).abs() < 1e-15);
}
