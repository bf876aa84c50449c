//! Spheres, long cylinders, domes, cavities, and enclosures between disks.

use super::super::enclosures::{frustum, mirrored_cylinder, nested, parts_of_sphere};
use super::super::expected::{
    SIGMA, concentric, disks, hole_of_sphere, in_series, of_surface, part_of_sphere, reradiating,
};
use super::super::known_factors;
use super::*;
use std::f64::consts::PI;

/// The closed formula between concentric surfaces.
const CONCENTRIC: &str = "A1/(1/e1 + (A1/A2)(1/e2 - 1/(1 - rs2)) + rs2/(1 - rs2))";

/// The cases of this module.
pub fn cases() -> Vec<ExchangeCase> {
    [
        spheres(),
        part_specular_spheres(),
        cylinders(),
        nested_sweep(),
        shielded_tube(),
        spheres_in_parts(),
        domes(),
        sphere_holes(),
        closed_cylinder(),
        cavities(),
        cones(),
        mirrored_top(),
    ]
    .concat()
}

fn asked(text: String, areas: [f64; 2], paint: &GreyPaint) -> EnclosureCases {
    let paint = paint.clone();
    EnclosureCases::new(text, move || nested(areas, &paint))
}

const SPHERES: [f64; 2] = [4.0 * PI, 16.0 * PI];

fn spheres() -> Vec<ExchangeCase> {
    let case = |id, text: &str, mirror: f64| {
        let paint = GreyPaint::new(&[0.7, 0.4], &[0.0, mirror]);
        let text = format!("concentric spheres of radius 1 and 2, e 0.7 and 0.4, {text}");
        let truth = concentric(SPHERES, [0.7, 0.4], mirror);
        asked(text, SPHERES, &paint).conductance(known(id, CONCENTRIC, truth), 0, 1)
    };
    vec![
        case("sph_diff_GR", "diffuse", 0.0),
        case("sph_spec_GR", "the outer one a mirror", 0.6),
        case(
            "sph_part_GR",
            "the outer one's mirror reflectance 0.35",
            0.35,
        ),
    ]
}

fn part_specular_spheres() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(&[0.7, 0.4], &[0.0, 0.35]);
    let text = "concentric spheres of radius 1 and 2, e 0.7 and 0.4, the outer one's mirror \
                reflectance 0.35";
    let asked = asked(text.into(), SPHERES, &paint);
    let book = known_factors::nested(SPHERES, &paint);
    let own = (1.0 - 0.25) / (1.0 - 0.35);
    vec![
        asked.factor(known("sph_part_Fs22", "(1 - A1/A2)/(1 - rs2)", own), 1, 1),
        asked.gebhart(
            known("sph_part_B22", GEBHART_IMAGES, book.gebhart(1, 1)),
            1,
            1,
        ),
    ]
}

fn cylinders() -> Vec<ExchangeCase> {
    let areas = [PI, 4.0 * PI];
    let case = |id, text: &str, mirror: f64| {
        let paint = GreyPaint::new(&[0.9, 0.2], &[0.0, mirror]);
        let text = format!("long concentric cylinders of radius 0.5 and 2, e 0.9 and 0.2, {text}");
        let truth = concentric(areas, [0.9, 0.2], mirror);
        asked(text, areas, &paint).conductance(known(id, CONCENTRIC, truth), 0, 1)
    };
    vec![
        case("cyl_diff_GR", "diffuse", 0.0),
        case("cyl_spec_GR", "the outer one a mirror", 0.8),
    ]
}

/// Ratios of radii, and mirror reflectances of both.
fn nested_sweep() -> Vec<ExchangeCase> {
    let rows = [
        ("cyl_close_GR", false, 1.01, [0.1, 0.1], [0.0, 0.45]),
        ("cyl_wide_GR", false, 10.0, [0.5, 0.05], [0.0, 0.0]),
        ("cyl_wide_mirror_GR", false, 10.0, [0.5, 0.05], [0.0, 0.95]),
        ("cyl_inner_mirror_GR", false, 1.5, [0.3, 0.6], [0.7, 0.0]),
        ("cyl_both_mirrors_GR", false, 3.0, [0.3, 0.1], [0.7, 0.9]),
        ("sph_close_GR", true, 1.1, [0.02, 0.03], [0.0, 0.9]),
        ("sph_wide_GR", true, 100.0, [0.8, 0.01], [0.0, 0.0]),
        ("sph_inner_part_GR", true, 2.0, [0.4, 0.5], [0.3, 0.2]),
        ("sph_both_mirrors_GR", true, 5.0, [0.2, 0.2], [0.8, 0.8]),
    ];
    let case = |(id, is_sphere, ratio, emissivity, mirror): (_, bool, f64, [f64; 2], [f64; 2])| {
        let (shape, power) = if is_sphere {
            ("spheres", 2)
        } else {
            ("long cylinders", 1)
        };
        let areas = [1.0, ratio.powi(power)];
        let text = format!(
            "concentric {shape}, radii 1:{ratio}, the inner one's area 1, e {emissivity:?}, mirror \
             reflectances {mirror:?}"
        );
        let truth = concentric(areas, emissivity, mirror[1]);
        let paint = GreyPaint::new(&emissivity, &mirror);
        asked(text, areas, &paint).conductance(known(id, CONCENTRIC, truth), 0, 1)
    };
    rows.into_iter().map(case).collect()
}

/// Long concentric tubes with two thin tubes as shields between them.
fn shielded_tube() -> Vec<ExchangeCase> {
    const SIDES: [(f64, f64, [f64; 2]); 3] = [
        (0.05, 0.1, [0.8, 0.05]),
        (0.1, 0.15, [0.05, 0.1]),
        (0.15, 0.2, [0.1, 0.8]),
    ];
    let areas = |(r1, r2, _): (f64, f64, [f64; 2])| [2.0 * PI * r1, 2.0 * PI * r2];
    let gap = |side: (f64, f64, [f64; 2])| concentric(areas(side), side.2, 0.0);
    let answer = move || {
        let gap = |side: (f64, f64, [f64; 2])| {
            nested(areas(side), &GreyPaint::matt(&side.2)).conductance(0, 1)
        };
        let gaps: Result<Vec<f64>, ExchangeError> = SIDES.into_iter().map(gap).collect();
        Ok(in_series(&gaps?))
    };
    vec![case(
        "cyl_2_shields_GR",
        "long tubes of radius 0.05 and 0.2, e 0.8, shields of radius 0.1 and 0.15 with e 0.05 and 0.1: \
         GR between the tubes, per metre",
        "resistances in series, concentric tubes",
        ExchangeQuantity::Conductance,
        in_series(&SIDES.map(gap)),
        answer,
    )]
}

fn spheres_in_parts() -> Vec<ExchangeCase> {
    const PARTS: &str = "F_ij = A_j/A; e_j A_j/(e_1 A_1 + e_2 A_2 + ...)";
    const RERADIATING: &str = "resistances, A1 A2/(A1 + A2) between 1 and 2 by way of 3";
    let (areas, emissivity) = ([0.1, 0.3, 0.6], [0.9, 0.5, 0.05]);
    let paint = GreyPaint::matt(&emissivity);
    let asked = EnclosureCases::new(
        "inside of a sphere of area 1 in parts of 0.1, 0.3, 0.6, e 0.9, 0.5, 0.05",
        move || parts_of_sphere(&areas, &paint),
    );
    let part = |j| part_of_sphere(&areas, &emissivity, j);
    // From the emission of 1 over its radiosity, the other's radiosity, to the emission of 2.
    let surfaces = [of_surface(0.9, 0.1), of_surface(0.5, 0.3)];
    let between = 0.1 * 0.3 / (0.1 + 0.3);
    let heat =
        SIGMA * fourth_powers(700.0, 400.0) * in_series(&[surfaces[0], between, surfaces[1]]);
    let radiosities = [
        SIGMA * 700f64.powi(4) - heat / surfaces[0],
        SIGMA * 400f64.powi(4) + heat / surfaces[1],
    ];
    let mean = (0.1 * radiosities[0] + 0.3 * radiosities[1]) / 0.4;
    let given = [at(700.0), at(400.0), giving(0.0)];
    vec![
        asked.gebhart(known("sphere3_B12", PARTS, part(1)), 0, 1),
        asked.gebhart(known("sphere3_B31", PARTS, part(0)), 2, 0),
        asked.flux(
            known("sphere3_rerad_q1", RERADIATING, heat / 0.1),
            0,
            &given,
        ),
        asked.temperature(
            known("sphere3_rerad_T3", RERADIATING, (mean / SIGMA).powf(0.25)),
            2,
            &given,
        ),
    ]
}

/// A disk under a hemisphere.
fn domes() -> Vec<ExchangeCase> {
    const HALVES: &str =
        "resistances, 1/(e A) for each half of the disk, which sees the dome alone";
    let areas = [PI, 2.0 * PI];
    let truth = concentric(areas, [0.6, 0.3], 0.0);
    let dome = asked(
        "disk of radius 1 under a hemisphere, e 0.6 and 0.3".into(),
        areas,
        &GreyPaint::matt(&[0.6, 0.3]),
    );
    let halves = EnclosureCases::new(
        "two halves of a disk of radius 1 under a hemisphere, e 0.6, 0.4 and 0.3",
        || {
            let half = 0.5 * PI;
            let factors = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.5]];
            let paint = GreyPaint::matt(&[0.6, 0.4, 0.3]);
            GreyEnclosure::new(&[half, half, 2.0 * PI], &paint, |i, j| factors[i][j])
        },
    );
    let half = 0.5 * PI;
    let through = in_series(&[0.6 * half, 0.4 * half]);
    vec![
        dome.conductance(
            known("dome_GR", "1/(1/e1 + (A1/A2)(1/e2 - 1))", truth),
            0,
            1,
        ),
        halves.through_reradiating(known("dome_halves_rerad_GR", HALVES, through), half),
    ]
}

fn sphere_holes() -> Vec<ExchangeCase> {
    let case = |id, e: f64, f: f64| {
        let text =
            format!("isothermal sphere of area 1, e {e}, with a hole of the share {f} of it");
        let build = move || parts_of_sphere(&[1.0 - f], &GreyPaint::matt(&[e]));
        // The hole is as large as its flat disk, f (1 − f) of the sphere.
        let known = known(id, "e/(1 - (1 - e)(1 - f))", hole_of_sphere(e, f));
        EnclosureCases::new(text, build).opening(known, f * (1.0 - f))
    };
    vec![
        case("sphere_hole", 0.5, 0.1),
        case("sphere_hole_dull", 0.9, 0.01),
        case("sphere_hole_bright", 0.05, 0.3),
    ]
}

fn closed_cylinder() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.9, 0.6, 0.3]);
    let book = known_factors::frustum(1.0, 1.0, 2.0, &paint);
    let asked = EnclosureCases::new(
        "closed cylinder of radius 1 and height 2, base, top, wall of e 0.9, 0.6, 0.3",
        move || frustum(1.0, 1.0, 2.0, &paint),
    );
    let given = [at(900.0), at(300.0), giving(0.0)];
    let wall = book.balance(&given).temperatures[2];
    let black = reradiating(PI, PI, disks(1.0, 1.0, 2.0));
    let through = in_series(&[of_surface(0.9, PI), black, of_surface(0.6, PI)]);
    vec![
        asked.factor(
            known("cyl3_F12", "3 - 2 sqrt 2, coaxial disks", 3.0 - 8f64.sqrt()),
            0,
            1,
        ),
        asked.gebhart(known("cyl3_B12", GEBHART, book.gebhart(0, 1)), 0, 1),
        asked.through_reradiating(
            known("cyl3_rerad_GR", "Hottel, reradiating wall", through),
            PI,
        ),
        asked.temperature(known("cyl3_mixed_T3", NET_RADIATION, wall), 2, &given),
    ]
}

/// Cylindrical cavities of base and wall.
fn cavities() -> Vec<ExchangeCase> {
    let case = |id, depth: f64, e: f64| {
        let paint = GreyPaint::matt(&[e; 2]);
        let book = known_factors::cylindrical_cavity(1.0, depth, &paint);
        let through = book.conductance(0, 2) + book.conductance(1, 2);
        let text = format!(
            "cylindrical cavity of radius 1 and depth {depth}, base and wall of e {e} with one \
             radiosity each"
        );
        let asked = EnclosureCases::new(text, move || frustum(1.0, 1.0, depth, &paint));
        asked.opening(known(id, GEBHART, through / PI), PI)
    };
    vec![
        case("cyl_cavity_shallow", 0.5, 0.7),
        case("cyl_cavity_deep", 4.0, 0.5),
        case("cyl_cavity_bright", 8.0, 0.1),
    ]
}

/// Cones without tips, their walls adiabatic.
fn cones() -> Vec<ExchangeCase> {
    let case = |id, r2: f64, h: f64, emissivity: [f64; 3]| {
        let paint = GreyPaint::matt(&emissivity);
        let (base, top) = (PI, PI * r2 * r2);
        let black = reradiating(base, top, disks(1.0, r2, h));
        let [e1, e2, _] = emissivity;
        let through = in_series(&[of_surface(e1, base), black, of_surface(e2, top)]);
        let text = format!(
            "cone without tip between disks of radius 1 and {r2} at distance {h}, base, top, wall of e \
             {emissivity:?}"
        );
        let asked = EnclosureCases::new(text, move || frustum(1.0, r2, h, &paint));
        asked.through_reradiating(known(id, "Hottel, reradiating wall", through), base)
    };
    vec![
        case("cone_rerad_GR", 2.0, 1.5, [0.7, 0.4, 0.2]),
        case("cone_narrow_rerad_GR", 0.3, 3.0, [0.9, 0.8, 0.95]),
    ]
}

/// A closed cylinder with a mirror for its top.
fn mirrored_top() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(&[0.7, 0.2, 0.4], &[0.0, 0.8, 0.0]);
    let book = known_factors::mirrored_cylinder(1.0, 2.0, &paint);
    let asked = EnclosureCases::new(
        "closed cylinder of radius 1 and height 2, base, top, wall of e 0.7, 0.2, 0.4, the top a mirror",
        move || mirrored_cylinder(1.0, 2.0, &paint),
    );
    let (near, far) = (3.0 - 8f64.sqrt(), 9.0 - 80f64.sqrt());
    let to_wall = 1.0 - near + 0.8 * (near - far);
    let given = [at(600.0), at(300.0), giving(0.0)];
    let balance: KnownBalance = book.balance(&given);
    vec![
        asked.factor(
            known(
                "cyl_mirror_Fs13",
                "(1 - F12) + 0.8 (F12 - F(disks, 4))",
                to_wall,
            ),
            0,
            2,
        ),
        asked.gebhart(
            known("cyl_mirror_B12", GEBHART_IMAGES, book.gebhart(0, 1)),
            0,
            1,
        ),
        asked.gebhart(
            known("cyl_mirror_B33", GEBHART_IMAGES, book.gebhart(2, 2)),
            2,
            2,
        ),
        asked.flux(
            known("cyl_mirror_q1", NET_RADIATION, balance.fluxes[0]),
            0,
            &given,
        ),
        asked.temperature(
            known("cyl_mirror_T3", NET_RADIATION, balance.temperatures[2]),
            2,
            &given,
        ),
    ]
}
