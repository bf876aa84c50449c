//! Whole systems: radiosities and fluxes in enclosures.

use super::answers::solve;
use super::builders::*;
use super::formulas::*;
use super::{Case, CaseKind, EnclosureSurface, PatchGroup, Question, Truth};
use crate::patch::PatchSize;
use glam::DVec3;
use std::f64::consts::PI;

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        furnaces(),
        plates(),
        shells(),
        cubes(),
        enclosure(),
        prism(),
    ]
    .concat()
}

fn enclosure_surface(group: PatchGroup, surface: GreySurface) -> EnclosureSurface {
    EnclosureSurface {
        group,
        exitance: surface.exitance,
        reflectance: surface.diffuse,
    }
}

/// The unit cube with these surfaces, and the question of the radiosity of one face; pure mirrors
/// have none.
fn cube_with(surfaces: [GreySurface; 6], of: usize) -> CaseBuilder {
    let mut builder = SceneBuilder::default();
    let groups = cube(&mut builder, surfaces);
    let lit = groups
        .into_iter()
        .zip(surfaces)
        .filter(|(_, s)| s.diffuse > 0.0);
    let before = surfaces[..of].iter().filter(|s| s.diffuse > 0.0).count();
    let groups = lit.map(|(g, s)| enclosure_surface(g, s)).collect();
    builder.about(Question::Radiosity { groups, of: before })
}

fn furnaces() -> Vec<Case> {
    let case = |id, source, description, surface: GreySurface, value| {
        cube_with([surface; 6], 0).case(
            id,
            source,
            kind(surface),
            description,
            Truth::formula(value),
        )
    };
    let mirroring = GreySurface {
        mirror: 0.3,
        ..GreySurface::matt(0.5, 1.0)
    };
    vec![
        case(
            "furnace",
            "E/(1 − ρ)",
            "cube, E = 1 and ρ = 0.5 all over",
            GreySurface::matt(0.5, 1.0),
            2.0,
        ),
        case(
            "furnace_spec",
            "E + ρ_d E/(1 − ρ_d − ρ_s)",
            "cube, E = 1, ρ_d = 0.5 and ρ_s = 0.3 all over",
            mirroring,
            3.5,
        ),
    ]
}

fn kind(surface: GreySurface) -> CaseKind {
    if surface.mirror > 0.0 {
        CaseKind::Mirrors
    } else {
        CaseKind::Polygons
    }
}

fn plates() -> Vec<Case> {
    let (lower, upper) = (GreySurface::matt(0.2, 1.0), GreySurface::matt(0.6, 0.0));
    let question = cube_with(
        [
            lower,
            upper,
            PERFECT_MIRROR,
            PERFECT_MIRROR,
            PERFECT_MIRROR,
            PERFECT_MIRROR,
        ],
        0,
    );
    vec![question.case(
        "plates",
        "(E₁ + ρ₁E₂)/(1 − ρ₁ρ₂)",
        CaseKind::Mirrors,
        "infinite plates, ρ = 0.2 and 0.6, the first emits 1",
        Truth::formula(1.0 / (1.0 - 0.2 * 0.6)),
    )]
}

/// Concentric spheres; only the inner one emits, 0.8 of a black body's 1.
fn shells() -> Vec<Case> {
    let case = |id, source, description: &str, outer: GreySurface, value| {
        let inner = GreySurface::matt(0.2, 0.8);
        let mut builder = SceneBuilder::default();
        let groups = [
            enclosure_surface(builder.sphere(DVec3::ZERO, 1.0, inner), inner),
            enclosure_surface(builder.sphere(DVec3::ZERO, 2.0, outer).inside(), outer),
        ];
        let groups = groups.into_iter().filter(|g| g.reflectance > 0.0).collect();
        builder.about(Question::Flux { groups, of: 0 }).case(
            id,
            source,
            CaseKind::Curved,
            description,
            Truth::formula(value),
        )
    };
    let (e1, e2) = (0.8, 0.4);
    vec![
        case(
            "shell_diffuse",
            "1/(1/ε₁ + (A₁/A₂)(1/ε₂ − 1))",
            "concentric spheres of radius 1 and 2, ε = 0.8 and 0.4, flux of the inner one",
            GreySurface::matt(1.0 - e2, 0.0),
            1.0 / (1.0 / e1 + 0.25 * (1.0 / e2 - 1.0)),
        ),
        case(
            "shell_specular",
            "1/(1/ε₁ + 1/ε₂ − 1)",
            "the same with a mirror as the outer sphere",
            GreySurface::mirror(1.0 - e2),
            1.0 / (1.0 / e1 + 1.0 / e2 - 1.0),
        ),
    ]
}

fn cubes() -> Vec<Case> {
    let rho = [0.5, 0.7, 0.3, 0.3, 0.6, 0.6];
    let lit = std::array::from_fn(|k| GreySurface::matt(rho[k], f64::from(k == 0)));
    let mut mirrored: [GreySurface; 6] = lit;
    mirrored[2] = GreySurface::mirror(0.9);
    vec![
        cube_with(lit, 1).case(
            "cube_box",
            "Howell C-11 and C-14, six equations",
            CaseKind::Polygons,
            "unit cube, ρ = .5 .7 .3 .3 .6 .6, the floor emits 1: radiosity of the ceiling",
            Truth::formula(ceiling_of_cube(rho, 0.0)),
        ),
        cube_with(mirrored, 1).case(
            "cube_mirror_B",
            "images: Howell C-11 and C-15, five equations",
            CaseKind::Mirrors,
            "the same with a mirror of 0.9 as the wall x = 0",
            Truth::formula(ceiling_of_cube(rho, 0.9)),
        ),
    ]
}

/// Radiosity of the ceiling of the unit cube whose floor emits 1, with exact factors; if the wall x
/// = 0 is a mirror it has no radiosity.
fn ceiling_of_cube(rho: [f64; 6], mirror: f64) -> f64 {
    // The mirror has no radiosity.
    let lit = |k: usize| f64::from(!(k == 2 && mirror > 0.0));
    let entry = |i: usize, j: usize| {
        f64::from(i == j) - lit(i) * lit(j) * rho[i] * cube_factor(i, j, mirror)
    };
    let row = |i: usize| (0..6).map(|j| entry(i, j)).collect();
    let system = (0..6).map(row).collect();
    solve(system, vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0])[1]
}

/// Extended form factor between faces z = 0, z = 1, x = 0, x = 1, y = 0, y = 1 of the unit cube,
/// the wall x = 0 a mirror.
fn cube_factor(i: usize, j: usize, mirror: f64) -> f64 {
    const UNIT: [f64; 2] = [0.0, 1.0];
    let (once, twice) = (opposed(1.0, 1.0, 1.0), opposed(2.0, 1.0, 1.0));
    let corner = on_common_edge(1.0, 1.0, 1.0);
    let direct = match (i, j) {
        _ if i == j => 0.0,
        _ if i / 2 == j / 2 => once,
        _ => corner,
    };
    // The image of the room stands at −1 ≤ x ≤ 0.
    let image = match (i, j) {
        (2, _) | (_, 2) => 0.0,
        (3, 3) => opposed(1.0, 1.0, 2.0),
        (3, _) | (_, 3) => perpendicular([1.0, 2.0], UNIT, UNIT, UNIT),
        _ if i == j => 0.0,
        _ if i / 2 == j / 2 => twice - once,
        // Beside and behind the mirror, along the common edge.
        _ => on_common_edge(2.0, 1.0, 1.0) - corner,
    };
    direct + mirror * image
}

/// A sphere in three parts that emit and reflect differently. Any part of a sphere receives the
/// share of its area, so sectors, which divide evenly, can replace caps.
fn enclosure() -> Vec<Case> {
    let parts = [(0.1, 0.2, 1.0), (0.3, 0.5, 0.0), (0.6, 0.8, 0.0)];
    let mut builder = SceneBuilder::default();
    let inside = builder.sphere(DVec3::ZERO, 1.0, GREY).inside();
    let mut from = 0.0;
    let mut groups = Vec::new();
    for (share, rho, exitance) in parts {
        let group = inside.clone().between(from, from + share);
        groups.push(enclosure_surface(group, GreySurface::matt(rho, exitance)));
        from += share;
    }
    let reflected: f64 = parts.iter().map(|(f, rho, _)| f * rho).sum();
    let arriving = 0.1 / (1.0 - reflected);
    let case = builder.about(Question::Radiosity { groups, of: 2 }).case(
        "sphere_encl",
        "B₃ = ρ₃ Σ f E/(1 − Σ f ρ)",
        CaseKind::Curved,
        "sphere, parts of area .1 .3 .6, ρ = .2 .5 .8, the first emits 1: radiosity of the third",
        Truth::formula(0.8 * arriving),
    );
    // Twenty cells around, so that tenths of the sphere end between cells.
    let size = PatchSize::Edge(0.65);
    vec![Case { size, ..case }]
}

fn prism() -> Vec<Case> {
    let (one, two) = (GreySurface::matt(0.4, 1.0), GreySurface::matt(0.6, 0.0));
    let top = (0.5, 0.75f64.sqrt());
    let mut builder = SceneBuilder::default();
    let groups = vec![
        enclosure_surface(builder.wall((0., 0.), (1., 0.), one), one),
        enclosure_surface(builder.wall((1., 0.), top, two), two),
    ];
    builder.wall(top, (0., 0.), GreySurface::mirror(0.8));
    builder.ends(&[(0., 0.), (1., 0.), top]);
    let own = 0.8 * strips_at_angle(PI * 2.0 / 3.0);
    let other = 0.5 + 0.8 * 0.5 * (3f64.sqrt() - 1.0);
    let system = vec![
        vec![1.0 - 0.4 * own, -0.4 * other],
        vec![-0.6 * other, 1.0 - 0.6 * own],
    ];
    let truth = Truth::formula(solve(system, vec![1.0, 0.0])[1]);
    let description =
        "infinite equilateral prism, ρ = .4 .6, a mirror of 0.8, side 1 emits 1: B of side 2";
    vec![builder.about(Question::Radiosity { groups, of: 1 }).case(
        "prism_mir_B",
        "crossed strings, two equations",
        CaseKind::Mirrors,
        description,
        truth,
    )]
}
