//! Plane mirrors, glass, and strips made infinite by mirrors.

use super::builders::*;
use super::formulas::*;
use super::{Case, CaseKind, PatchGroup, Truth};
use azulejo_scene::Material;
use glam::{DVec3, dvec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        strips_between_ends(),
        one_mirror(),
        corridors(),
        prisms(),
        glass(),
    ]
    .concat()
}

const UNIT: [f64; 2] = [0.0, 1.0];

fn strips_between_ends() -> Vec<Case> {
    let mut opposed = SceneBuilder::default();
    let below = opposed.wall((0., 0.), (1., 0.), GREY);
    let above = opposed.wall((1., 1.), (0., 1.), GREY);
    opposed.ends(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]);
    let mut corner = SceneBuilder::default();
    let floor = corner.wall((0., 0.), (1., 0.), GREY);
    let wall = corner.wall((0., 1.), (0., 0.), GREY);
    corner.ends(&[(0., 0.), (1., 0.), (0., 1.)]);
    vec![
        opposed.asks(below, above).case(
            "strips",
            "Howell C-1, crossed strings",
            CaseKind::Mirrors,
            "infinite opposed strips, as wide as they are apart",
            Truth::formula(strips(1.0, 1.0)),
        ),
        corner.asks(floor, wall).case(
            "wedge_inf_90",
            "Howell C-5, crossed strings",
            CaseKind::Mirrors,
            "infinite strips of equal width at 90°",
            Truth::formula(strips_at_angle(FRAC_PI_2)),
        ),
    ]
}

/// Floor and ceiling of the unit cube with mirrors.
fn floor_and_ceiling(mirrors: &[(Vec<DVec3>, f64)]) -> (SceneBuilder, PatchGroup, PatchGroup) {
    let mut builder = SceneBuilder::default();
    let floor = builder.polygon(&square(0.0, true), GREY);
    let ceiling = builder.polygon(&square(1.0, false), GREY);
    for (polygon, reflectance) in mirrors {
        builder.polygon(polygon, GreySurface::mirror(*reflectance));
    }
    (builder, floor, ceiling)
}

fn one_mirror() -> Vec<Case> {
    let single = |id, source, description: &str, mirror: Vec<DVec3>, reflectance: f64, truth| {
        let (builder, from, to) = floor_and_ceiling(&[(mirror, reflectance)]);
        builder
            .asks(from, to)
            .case(id, source, CaseKind::Mirrors, description, truth)
    };
    let whole_wall = || upright(0.0, UNIT, UNIT);
    let (once, twice) = (opposed(1.0, 1.0, 1.0), opposed(2.0, 1.0, 1.0));
    let mut apart = SceneBuilder::default();
    let left = apart.polygon(&square(0.0, true), GREY);
    let right = apart.polygon(&rectangle([1.5, 2.5], UNIT, 0.0, true), GREY);
    apart.polygon(
        &rectangle([0.0, 3.0], UNIT, 1.0, false),
        GreySurface::mirror(0.9),
    );
    vec![
        single(
            "mir_cube",
            "image: Howell C-11",
            "unit cube, floor to ceiling, one wall a perfect mirror",
            whole_wall(),
            1.0,
            Truth::formula(twice),
        ),
        single(
            "mir_window",
            "image through a window",
            "opposed unit squares, a mirror of 0.8 that covers a quarter of a plane beside them",
            upright(-0.2, [0.2, 0.7], [0.3, 0.8]),
            0.8,
            Truth::constant(
                0.22076122,
                8,
                "part of the image seen in the window for each point, Gauss points",
            ),
        ),
        single(
            "cube_mirror_F",
            "images: Howell C-11",
            "unit cube, floor to ceiling, one wall a mirror of 0.9",
            whole_wall(),
            0.9,
            Truth::formula(once + 0.9 * (twice - once)),
        ),
        // All lines from one to the image of the other pass the mirror.
        apart.asks(left, right).case(
            "mir_corner",
            "image: Howell C-13",
            CaseKind::Mirrors,
            "squares side by side that see each other in a mirror of 0.9 above them only",
            Truth::formula(0.9 * parallel(UNIT, UNIT, [1.5, 2.5], UNIT, 2.0)).but_for(1e-12),
        ),
    ]
}

fn corridors() -> Vec<Case> {
    let case = |id, reflectance: f64, source, truth| {
        let wall = |x| (upright(x, UNIT, UNIT), reflectance);
        let (builder, from, to) = floor_and_ceiling(&[wall(0.0), wall(1.0)]);
        let description =
            format!("unit cube, floor to ceiling, facing walls mirrors of {reflectance}");
        builder
            .asks(from, to)
            .case(id, source, CaseKind::Mirrors, description, truth)
    };
    // The k-th image of the ceiling is shifted by k and seen after k reflections.
    let images = |r: f64| {
        let shifted = |k: u32| parallel(UNIT, UNIT, [f64::from(k), f64::from(k) + 1.0], UNIT, 1.0);
        let series = (1..400).map(|k| r.powi(k as i32) * shifted(k)).sum::<f64>();
        Truth::formula(shifted(0) + 2.0 * series).but_for(1e-11)
    };
    vec![
        case("corridor_0.5", 0.5, "series of images", images(0.5)),
        case("corridor_0.9", 0.9, "series of images", images(0.9)),
        case(
            "corridor_1",
            1.0,
            "Howell C-1, crossed strings",
            Truth::formula(strips(1.0, 1.0)),
        ),
    ]
}

fn prisms() -> Vec<Case> {
    let top = (0.5, 0.75f64.sqrt());
    let mut prism = SceneBuilder::default();
    let one = prism.wall((0., 0.), (1., 0.), GREY);
    let two = prism.wall((1., 0.), top, GREY);
    prism.wall(top, (0., 0.), PERFECT_MIRROR);
    prism.ends(&[(0., 0.), (1., 0.), top]);
    let diagonal = (0.5f64.sqrt(), 0.5f64.sqrt());
    let mut wedge = SceneBuilder::default();
    let floor = wedge.wall((0., 0.), (1., 0.), GREY);
    wedge.wall(diagonal, (0., 0.), PERFECT_MIRROR);
    wedge.ends(&[(0., 0.), (1., 0.), diagonal]);
    vec![
        prism.asks(one, two).case(
            "prism_mir_12",
            "crossed strings, image",
            CaseKind::Mirrors,
            "infinite equilateral prism, one side a perfect mirror, between the other two",
            Truth::formula(0.5 * 3f64.sqrt()),
        ),
        wedge.asks(floor.clone(), floor).case(
            "wedge45_mir_11",
            "crossed strings, image",
            CaseKind::Mirrors,
            "infinite wedge of 45°, a strip to itself by the perfect mirror beside it",
            Truth::formula(strips_at_angle(0.5 * PI)),
        ),
    ]
}

/// Floor, a sheet of glass above it and further surfaces, infinite between four mirrors.
fn under_glass(glass: Material, z: f64, up: bool, height: f64) -> (SceneBuilder, PatchGroup) {
    let mut builder = SceneBuilder::default();
    let floor = builder.polygon(&square(0.0, true), GREY);
    builder.polygon_of(&square(z, up), glass);
    let corners = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
    for k in 0..4 {
        let ((x0, y0), (x1, y1)) = (corners[k], corners[(k + 1) % 4]);
        let wall = [
            dvec3(x0, y0, 0.),
            dvec3(x0, y0, height),
            dvec3(x1, y1, height),
            dvec3(x1, y1, 0.),
        ];
        builder.polygon(&wall, PERFECT_MIRROR);
    }
    (builder, floor)
}

fn glass() -> Vec<Case> {
    let body = || Material::dielectric("glass", 1.5);
    let (outside, before) = under_glass(body(), 0.5, false, 0.5);
    let (inside, within) = under_glass(body(), 0.5, true, 0.5);
    let reflectance = diffuse_fresnel(1.5);
    let (mut pane, below) = under_glass(Material::pane("pane", 1.5), 0.5, false, 1.0);
    let above = pane.polygon(&square(1.0, false), GREY);
    vec![
        outside.asks(before.clone(), before).case(
            "fresnel_ext_1.5",
            "Duntley 1942",
            CaseKind::Glass,
            "infinite diffuse plane to itself, by the surface of glass of index 1.5 above it",
            Truth::formula(reflectance),
        ),
        inside.asks(within.clone(), within).case(
            "fresnel_int_1.5",
            "1 − (1 − R)/n²",
            CaseKind::Glass,
            "infinite diffuse plane in glass of index 1.5 to itself, by the surface above it",
            Truth::formula(1.0 - (1.0 - reflectance) / 2.25),
        ),
        pane.asks(below, above).case(
            "pane_1.5",
            "mean of (1 − R)/(1 + R) over both polarizations",
            CaseKind::Glass,
            "infinite planes before and behind a clear thin pane of index 1.5",
            Truth::quadrature(diffuse_pane(1.5)),
        ),
    ]
}
