//! Values in closed form or from the papers, and limits of models.

use super::*;
use std::f64::consts::{PI, TAU};

/// The albedo for a direction at an angle, in degrees.
fn check_albedo(text: &str, (theta, phi): (f64, f64), expected: f64, tolerance: f64) {
    let albedo = check::albedo(&brdf(text), direction(theta, phi)).r;
    assert!(
        (albedo - expected).abs() <= tolerance,
        "{text} at {theta}°, {phi}°: {albedo} instead of {expected}"
    );
}

#[test]
fn albedos_are_the_known_ones() {
    let check = |text: &str, theta: f64, expected: f64| {
        // Half a unit of the third digit.
        let digit = 10f64.powf(expected.log10().floor() - 2.0).max(1e-3);
        check_albedo(text, (theta, 20.0), expected, 0.51 * digit);
    };
    for (theta, expected) in [(0.0, 1.0), (30.0, 0.866), (60.0, 0.5), (85.0, 0.138)] {
        check("lewis n = 20", theta, expected);
    }
    for (theta, expected) in [(0.0, 1.0), (30.0, 0.776), (60.0, 0.328)] {
        check("blinn n = 20", theta, expected);
    }
    check("cook_torrance m = 0.2", 0.0, 1.0);
    check("cook_torrance m = 0.2", 75.0, 0.928);
    check("cook_torrance m = 0.5", 0.0, 0.892);
    check("ggx_smith ax = 0.5", 0.0, 0.688);
    check("ggx_smith ax = 1", 0.0, 0.307);
    check("poulin_fournier d = 2 ks = 1 n = 20", 0.0, 0.577);
    let he = "he_torrance sigma0 = 0.18 tau = 3 lambda = 0.5";
    check(he, 0.0, 1.0);
    check(he, 75.0, 0.943);
}

#[test]
fn albedos_at_slanting_angles_are_the_known_ones() {
    let angles = [80.0, 88.0, 89.0, 89.8];
    let check = |text: &str, expected: [f64; 4]| {
        for (theta, expected) in angles.into_iter().zip(expected) {
            check_albedo(
                text,
                (theta, 0.0),
                expected,
                0.005 * expected.max(1.0) + 1e-4,
            );
        }
    };
    check("ward ax = 0.2", [0.22, 0.20, 0.24, 0.48]);
    check("ward_duer ax = 0.2", [0.92, 1.95, 3.37, 14.9]);
    check("ward_gmd ax = 0.2", [0.80, 0.86, 0.90, 0.964]);
    let he = "he_torrance sigma0 = 0.18 tau = 3 lambda = 0.5";
    check_albedo(he, (89.0, 0.0), 0.10, 0.005);
}

#[test]
fn means_of_samples_are_the_known_ones() {
    let check = |text: &str, expected: f64| {
        let weights = check::weights(&brdf(text), direction(50.0, 20.0), 100_000);
        assert!(
            (weights.expected.r - expected).abs() < 6e-5,
            "{text}: {weights:?}"
        );
        assert!(weights.deviation() < 4.0, "{text}: {weights:?}");
    };
    check("ward ax = 0.15 ay = 0.4", 0.5206);
    check("ward_gmd ax = 0.15 ay = 0.4", 0.8797);
    check("ggx_smith ax = 0.3 ay = 0.1 eta = 0.2 k = 3.9", 0.8452);
    check("lewis n = 20", 0.6428);
    check("he_torrance sigma0 = 0.28 tau = 1.77 lambda = 0.5", 0.9171);
}

#[test]
fn matt_cylinders_side_by_side() {
    let text = "poulin_fournier d = 2 kd = 1 ks = 0 n = 1";
    for theta in [0.0, 40.0, 80.0] {
        check_albedo(text, (theta, 0.0), 0.802, 5e-4);
    }
    check_albedo(text, (75.0, 90.0), 0.909, 5e-4);
}

#[test]
fn white_facets_that_reflect_again_lose_nothing() {
    for alpha in [0.01, 0.05, 0.3, 0.5, 1.0] {
        for theta in [0.0, 30.0, 60.0, 80.0, 89.0] {
            let tolerance = if alpha < 0.05 { 2e-4 } else { 5e-5 };
            check_albedo(
                &format!("ggx_ms ax = {alpha}"),
                (theta, 20.0),
                1.0,
                tolerance,
            );
        }
    }
}

#[test]
fn phong_creates_light_from_grazing_light() {
    // This is the albedo for incidence along wi; the integral over wi for a given wo stays below 1.
    let phong = brdf("phong n = 20");
    let reflected = |theta: f64| {
        let (wi, n) = (direction(theta, 0.0), 400);
        let of = |k: usize| {
            let cos = ((k / n) as f64 + 0.5) / n as f64;
            let wo = direction(cos.acos().to_degrees(), (k % n) as f64 * 360.0 / n as f64);
            phong.eval(wo, wi).r * cos
        };
        (0..n * n).map(of).sum::<f64>() * TAU / (n * n) as f64
    };
    assert!((reflected(0.0) - TAU / 22.0).abs() < 1e-4);
    assert!((reflected(89.0) - 1.59).abs() < 5e-3);
    check_albedo("phong n = 20", (0.0, 0.0), TAU / 21.0, 1e-5);
}

#[test]
fn along_the_normal_formulas_are_short() {
    let check = |text: &str, expected: f64| {
        let value = brdf(text).eval(DVec3::Z, DVec3::Z).g;
        assert!((value / expected - 1.0).abs() < 1e-9, "{text}: {value}");
    };
    check("phong kd = 0.3 ks = 0.4 n = 7", 0.3 / PI + 0.4);
    check("blinn ks = 0.5 n = 0", 0.5 / PI);
    check("blinn n = 2", 4.0 * 6.0 / (8.0 * PI * 2.5));
    check(
        "ward kd = 0.1 ks = 0.5 ax = 0.1 ay = 0.3",
        0.1 / PI + 0.5 / (4.0 * PI * 0.03),
    );
    check(
        "ward_duer ks = 0.5 ax = 0.1 ay = 0.3",
        0.5 / (4.0 * PI * 0.03),
    );
    check(
        "ward_gmd ks = 0.5 ax = 0.1 ay = 0.3",
        0.5 / (4.0 * PI * 0.03),
    );
    check(
        "cook_torrance ks = 0.5 m = 0.2 F = 0.6",
        0.3 / (4.0 * PI * 0.04),
    );
    check(
        "beckmann_smith ax = 0.2 ay = 0.3 eta = 1.5",
        0.04 / (4.0 * PI * 0.06),
    );
    check("ggx_smith ax = 1", 1.0 / (4.0 * PI));
    check(
        "ggx_smith ax = 0.1 ay = 0.4 f0 = 0.8",
        0.8 / (4.0 * PI * 0.04),
    );
    // Wide facets: N = 1/(2π ∫ cos θ sin θ dθ) = 1/π.
    let wide = brdf("torrance_sparrow_gauss c = 0.01")
        .eval(DVec3::Z, DVec3::Z)
        .r;
    assert!((wide * 4.0 * PI - 1.0).abs() < 2e-4, "{wide}");
}

#[test]
fn rough_waves_are_facets() {
    let (wo, wi) = (direction(20.0, 180.0), direction(26.0, 5.0));
    let ratio = |sigma: f64| {
        let text = format!(
            "he_torrance sigma0 = {sigma} tau = {} lambda = 0.5",
            20.0 * sigma
        );
        brdf(&text).eval(wo, wi).r / brdf("beckmann_smith ax = 0.1").eval(wo, wi).r - 1.0
    };
    let (rough, rougher) = (ratio(8.0), ratio(80.0));
    assert!(
        rough.abs() < 1e-4 && rougher.abs() < 1e-6,
        "{rough} {rougher}"
    );
}

#[test]
fn smooth_waves_are_a_mirror() {
    let mirror = |text: &str| brdf(text).mirror(0.5);
    let rough = mirror("he_torrance_mirror sigma0 = 1e-4 tau = 0.1 eta = 1.5");
    let smooth = mirror("fresnel_dielectric eta = 1.5");
    assert!((rough.g - smooth.g).abs() < 1e-5 * smooth.g, "{rough:?}");
    // The full model has the same specular part; shorter waves lose more.
    let both = brdf("he_torrance sigma0 = 0.1 tau = 2 metal = silver");
    let alone = mirror("he_torrance_mirror sigma0 = 0.1 tau = 2 metal = silver");
    assert_eq!(both.mirror(0.5), alone);
    assert!(alone.r > 1.2 * alone.b, "{alone:?}");
    assert_eq!(both.mean_mirror(), both.narrow().mean_mirror());
}

#[test]
fn cylinders_far_apart_are_blinns_floor() {
    let (wo, wi) = (direction(40.0, 170.0), direction(30.0, 0.0));
    let floor = brdf("blinn kd = 0.3 ks = 0.4 n = 10").eval(wo, wi).r;
    let cylinders = brdf("poulin_fournier d = 1e6 kd = 0.3 ks = 0.4 n = 10");
    assert!((cylinders.eval(wo, wi).r / floor - 1.0).abs() < 1e-5);
    // So are shallow waves.
    let waves = brdf("poulin_fournier d = 0.001 kd = 0.3 ks = 0.4 n = 10");
    assert!((waves.eval(wo, wi).r / floor - 1.0).abs() < 1e-4);
}

#[test]
fn parameters_that_make_no_surface_are_refused() {
    let check = |text: &str, expected: &str| {
        let problem = text.parse().and_then(Brdf::new).unwrap_err().to_string();
        assert!(problem.contains(expected), "{text}: {problem}");
    };
    check("ward ax = 0.00001", "`ax` is 0.00001");
    check("ward_gmd ax = 0.1 ay = 0", "`ay` is 0");
    check("cook_torrance rough = 0", "`m` is 0");
    check("blinn n = -0.1", "`n` is -0.1");
    check("phong n = 1e7", "`n` is 10000000");
    check("ward kd = 0.6 ks = 0.6 ax = 0.1", "create energy");
    check("cook_torrance kd = 0.9 m = 0.2", "create energy");
    check("ggx_ms ax = 0.1 ay = 0.2", "must be equal");
    check("he_torrance sigma0 = 0.1", "needs `tau`");
    check(
        "ggx_smith ax = 0.1 metal = unobtainium",
        "there is no metal `unobtainium`",
    );
    check("ggx_smith ax = 0.1 metal = 3", "must be a word");
    check("poulin_fournier d = 2 n = 3 h = 1", "`h` is 1");
}

#[test]
fn samples_of_cylinders_weigh_little() {
    // Without bounded sample weights means would not converge.
    let check = |text: &str, most: f64| {
        for theta in [10.0, 60.0, 85.0, 89.5] {
            let weights = check::weights(&brdf(text), direction(theta, 80.0), 20_000);
            assert!(weights.largest < most, "{text} at {theta}°: {weights:?}");
        }
    };
    check("poulin_fournier d = 2 kd = 1 ks = 0 n = 1", 1.0 + 1e-9);
    check("poulin_fournier d = 2 kd = 0 ks = 1 n = 20", 4.0);
    check(
        "poulin_fournier d = 3 h = 0.5 kd = 0.3 ks = 0.7 n = 500",
        4.0,
    );
}

/// Half vectors at the horizon would give single samples any weight: with an exponent of 0, Blinn's lobe is diffuse.
#[test]
fn samples_of_wide_lobes_weigh_alike() {
    for (n, most) in [(0.0, 1.0 + 1e-12), (0.5, 1.1), (1.9, 1.2)] {
        let wide = brdf(&format!("blinn ks = 1 n = {n}"));
        for theta in [0.0, 50.0, 89.0] {
            let weights = check::weights(&wide, direction(theta, 20.0), 20_000);
            assert!(weights.largest <= most, "n = {n} at {theta}°: {weights:?}");
            assert!(
                weights.deviation() < 5.0,
                "n = {n} at {theta}°: {weights:?}"
            );
        }
    }
}
