//! Polygons and elements, unoccluded or with occluders.

use super::builders::*;
use super::formulas::*;
use super::{Case, CaseKind, Truth};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        opposed_rectangles(),
        square_to_each_other(),
        wedges(),
        apart(),
        elements(),
        occluded(),
    ]
    .concat()
}

const UNIT: [f64; 2] = [0.0, 1.0];

/// An unoccluded pair of polygons.
fn pair(p1: &[DVec3], p2: &[DVec3]) -> CaseBuilder {
    behind(&[], p1, p2)
}

/// A pair of polygons with an occluder.
fn behind(occluder: &[DVec3], p1: &[DVec3], p2: &[DVec3]) -> CaseBuilder {
    let mut builder = SceneBuilder::default();
    let (from, to) = (builder.polygon(p1, GREY), builder.polygon(p2, GREY));
    if !occluder.is_empty() {
        builder.polygon(occluder, GREY);
    }
    builder.asks(from, to)
}

fn opposed_rectangles() -> Vec<Case> {
    let case = |id, a: f64, b: f64, c: f64| {
        let (x, y) = ([0.0, a], [0.0, b]);
        let description = format!("opposed rectangles {a} × {b} at distance {c}");
        let truth = Truth::formula(opposed(a, b, c));
        pair(&rectangle(x, y, 0.0, true), &rectangle(x, y, c, false)).case(
            id,
            "Howell C-11",
            CaseKind::Polygons,
            description,
            truth,
        )
    };
    vec![
        case("par_1_1_1", 1.0, 1.0, 1.0),
        case("par_2_1_0p5", 2.0, 1.0, 0.5),
        case("par_3_3_1", 3.0, 3.0, 1.0),
        // The formula's terms cancel to a hundredth of themselves and less.
        Case {
            truth: Truth::formula(opposed(1.0, 1.0, 10.0)).but_for(1e-11),
            ..case("par_1_1_10", 1.0, 1.0, 10.0)
        },
        case("par_1_1_0p01", 1.0, 1.0, 0.01),
    ]
}

fn square_to_each_other() -> Vec<Case> {
    let case = |id, edge: f64, depth: f64, height: f64| {
        let y = [0.0, edge];
        let description = format!(
            "rectangles square to each other on an edge of {edge}, depth {depth}, height {height}"
        );
        let truth = Truth::formula(on_common_edge(edge, depth, height));
        pair(
            &rectangle([0.0, depth], y, 0.0, true),
            &upright(0.0, y, [0.0, height]),
        )
        .case(id, "Howell C-14", CaseKind::Polygons, description, truth)
    };
    vec![
        case("perp_1_1_1", 1.0, 1.0, 1.0),
        case("perp_2_1_3", 2.0, 1.0, 3.0),
        case("perp_1_5_0p2", 1.0, 5.0, 0.2),
    ]
}

fn wedges() -> Vec<Case> {
    let case = |id, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let leaf = [
            dvec3(0., 0., 0.),
            dvec3(0., 1., 0.),
            dvec3(cos, 1., sin),
            dvec3(cos, 0., sin),
        ];
        let description = format!("unit squares with a common edge at {degrees}°");
        let truth = Truth::quadrature(wedge(degrees.to_radians()));
        pair(&square(0.0, true), &leaf).case(
            id,
            "Howell C-16",
            CaseKind::Polygons,
            description,
            truth,
        )
    };
    vec![
        case("wedge_30", 30.0),
        case("wedge_60", 60.0),
        case("wedge_120", 120.0),
        case("wedge_150", 150.0),
    ]
}

/// Corners of a regular polygon with n sides of length 1 about the z axis; the first is at `first`
/// turns.
fn regular(n: u32, centre: DVec3, first: f64) -> Vec<DVec3> {
    let radius = 0.5 / (PI / f64::from(n)).sin();
    let corner = |k: u32| {
        let (sin, cos) = (2.0 * PI * (f64::from(k) / f64::from(n) + first)).sin_cos();
        centre + radius * dvec3(cos, sin, 0.0)
    };
    (0..n).map(corner).collect()
}

/// The polygon raised and turned to face down.
fn opposite(polygon: &[DVec3], height: f64) -> Vec<DVec3> {
    polygon
        .iter()
        .rev()
        .map(|&p| p + height * DVec3::Z)
        .collect()
}

fn apart() -> Vec<Case> {
    let floor = square(0.0, true);
    let polygons = |id, source, description: &str, p1: &[DVec3], p2: &[DVec3], truth| {
        pair(p1, p2).case(id, source, CaseKind::Polygons, description, truth)
    };
    let triangle = regular(3, DVec3::ZERO, 0.0);
    let hexagon = regular(6, DVec3::ZERO, 0.0);
    // Two neighbouring faces of a regular tetrahedron, facing inward.
    let apex = DVec3::new(0.0, 0.0, (2.0 / 3.0f64).sqrt());
    let slope = [triangle[0], apex, triangle[1]];
    let skew = [dvec3(0., 0., 0.), dvec3(2., 0., 0.), dvec3(0.3, 1.7, 0.4)];
    let above = [
        dvec3(0.2, 0.1, 1.9),
        dvec3(0.5, 1.6, 1.4),
        dvec3(2.1, 0.7, 2.3),
    ];
    let l_shape = plane(
        0.0,
        &[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)],
    );
    let two = [0.0, 2.0];
    // Two rectangles make the L; each contributes its share of the area.
    let l_parts =
        2.0 * parallel(two, UNIT, two, two, 1.0) + parallel(UNIT, [1.0, 2.0], two, two, 1.0);
    let (wide, deep) = ([-0.5, 1.5], [-1.0, 1.0]);
    vec![
        polygons(
            "par_coax_1_3_1",
            "Howell C-12",
            "coaxial squares of sides 1 and 3 at distance 1",
            &floor,
            &rectangle([-1.0, 2.0], [-1.0, 2.0], 1.0, false),
            Truth::formula(parallel(UNIT, UNIT, [-1.0, 2.0], [-1.0, 2.0], 1.0)),
        ),
        polygons(
            "par_offset",
            "Howell C-13",
            "parallel rectangles beside each other",
            &floor,
            &rectangle([2.0, 4.0], [1.0, 2.0], 1.5, false),
            Truth::formula(parallel(UNIT, UNIT, [2.0, 4.0], [1.0, 2.0], 1.5)).but_for(1e-12),
        ),
        polygons(
            "perp_offset",
            "Howell C-15",
            "rectangles square to each other, apart",
            &floor,
            &upright(-1.0, [2.0, 4.0], [0.5, 2.0]),
            Truth::formula(perpendicular([1.0, 2.0], UNIT, [2.0, 4.0], [0.5, 2.0])).but_for(1e-12),
        ),
        polygons(
            "tetra",
            "symmetry",
            "faces of a regular tetrahedron",
            &triangle,
            &slope,
            Truth::formula(1.0 / 3.0),
        ),
        polygons(
            "tri_par",
            "double contour integral",
            "opposed equilateral triangles of side 1 at distance 1",
            &triangle,
            &opposite(&triangle, 1.0),
            Truth::quadrature(double_contour(&triangle, &opposite(&triangle, 1.0))),
        ),
        polygons(
            "hex_par",
            "double contour integral",
            "opposed regular hexagons of side 1 at distance 2",
            &hexagon,
            &opposite(&hexagon, 2.0),
            Truth::quadrature(double_contour(&hexagon, &opposite(&hexagon, 2.0))),
        ),
        polygons(
            "tri_skew",
            "double contour integral",
            "triangles in general position that see all of each other",
            &skew,
            &above,
            Truth::quadrature(double_contour(&skew, &above)),
        ),
        polygons(
            "L_shape",
            "Howell C-13, two rectangles",
            "concave L of area 3 to a parallel square of side 2 at distance 1",
            &l_shape,
            &rectangle(two, two, 1.0, false),
            Truth::formula(l_parts / 3.0),
        ),
        polygons(
            "horizon",
            "Howell C-15 of the upper half",
            "receiver that crosses the plane of the sender: its lower half is not seen",
            &floor,
            &upright(-0.5, wide, deep),
            Truth::formula(perpendicular([0.5, 1.5], UNIT, wide, UNIT)).but_for(1e-12),
        ),
    ]
}

fn elements() -> Vec<Case> {
    let case = |id, source, description: &str, polygon: &[DVec3], value: f64| {
        let mut builder = SceneBuilder::default();
        let element = builder.element(DVec3::ZERO, DVec3::Z);
        let polygon = builder.polygon(polygon, GREY);
        let truth = Truth::formula(value).but_for(ELEMENT);
        builder
            .asks(element, polygon)
            .case(id, source, CaseKind::Polygons, description, truth)
    };
    let across = [
        dvec3(1., 0., 0.),
        dvec3(1., 0., 1.),
        dvec3(1., 1., 1.),
        dvec3(1., 1., 0.),
    ];
    let tilted = |low: f64| {
        [
            dvec3(1., -1., low),
            dvec3(1., -1., 2.),
            dvec3(2., 2., 2.),
            dvec3(2., 2., low),
        ]
    };
    vec![
        case(
            "dA_rect_par",
            "Howell B-3",
            "element parallel to a unit square, below its corner at distance 1",
            &square(1.0, false),
            element_parallel(1.0, 1.0, 1.0),
        ),
        case(
            "dA_rect_perp",
            "Howell B-4",
            "element square to a unit square at distance 1, whose lower edge is level with it",
            &across,
            element_perpendicular(1.0, 1.0, 1.0),
        ),
        case(
            "dA_horizon",
            "Lambert's formula, clipped",
            "element to a tilted rectangle that crosses its horizon",
            &tilted(-1.0),
            element(DVec3::ZERO, DVec3::Z, &tilted(0.0)),
        ),
    ]
}

/// Relative change by the small squares in the place of elements.
pub const ELEMENT: f64 = 5e-8;

fn occluded() -> Vec<Case> {
    let (floor, ceiling) = (square(0.0, true), square(1.0, false));
    let plate = |id, description: &str, occluder: &[DVec3], truth| {
        behind(occluder, &floor, &ceiling).case(
            id,
            "visible part",
            CaseKind::Shadow,
            description,
            truth,
        )
    };
    let origin =
        "exact visible part of the receiver for each point, Gauss points between the breaks";
    let fin = upright(0.5, UNIT, [0.0, 0.3]);
    vec![
        plate(
            "occ_view3d",
            "opposed unit squares, a quarter of their cell covered at half the height",
            &rectangle([0.0, 0.5], [0.0, 0.5], 0.5, true),
            Truth::formula(0.75 * opposed(1.0, 1.0, 1.0)),
        ),
        plate(
            "occ_centre",
            "opposed unit squares, a square of half their side between their centres",
            &rectangle([0.25, 0.75], [0.25, 0.75], 0.5, true),
            Truth::constant(0.09950629460, 10, origin),
        ),
        plate(
            "occ_low",
            "opposed unit squares, a square of 0.4 at a quarter of the distance",
            &rectangle([0.3, 0.7], [0.3, 0.7], 0.25, true),
            Truth::constant(0.1447582159, 10, origin),
        ),
        behind(&fin, &floor, &upright(0.0, UNIT, UNIT)).case(
            "occ_fin",
            "visible part",
            CaseKind::Shadow,
            "unit squares square to each other, a fin of 0.3 across the floor's middle",
            Truth::constant(0.1525107504, 10, origin),
        ),
    ]
}
