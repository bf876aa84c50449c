//! Every model of the table, by the public checks.

use super::*;
use check::{Effort, direction};

/// Each example of each model.
fn each(of: impl Fn(&'static ModelInfo, &str, &Brdf)) {
    for info in MODELS {
        assert!(!info.examples.is_empty(), "{} has no example", info.name);
        for text in info.examples {
            of(info, text, &brdf(text));
        }
    }
}

#[test]
fn names_are_those_of_one_model_each() {
    let names = MODELS
        .iter()
        .flat_map(|m| [m.name].into_iter().chain(m.aliases.iter().copied()));
    let mut names: Vec<String> = names.map(str::to_ascii_lowercase).collect();
    names.sort();
    assert!(names.windows(2).all(|w| w[0] != w[1]), "{names:?}");
}

#[test]
fn examples_are_of_their_models_and_say_what_they_are() {
    each(|info, text, made| {
        assert_eq!(
            find(text.split(' ').next().unwrap()).unwrap().name,
            info.name
        );
        let message = made.description().to_string();
        assert_eq!(brdf(&message), *made, "{text}: {message}");
    });
}

#[test]
fn light_may_be_exchanged() {
    each(|info, text, made| {
        let reciprocity = check::reciprocity(made, 2000);
        if info.is_reciprocal {
            assert!(reciprocity.largest < 1e-12, "{text}: {reciprocity:?}");
        } else {
            assert!(
                reciprocity.largest > 0.01,
                "{text} is reciprocal: {reciprocity:?}"
            );
        }
    });
}

#[test]
fn safe_models_reflect_no_more_than_arrives() {
    each(|info, text, made| {
        for theta in check::ANGLES {
            let albedo = check::albedo(made, direction(theta, check::AZIMUTH));
            assert!(albedo.is_finite(), "{text} at {theta}°: {albedo:?}");
            if info.is_energy_safe {
                assert!(
                    albedo.max_channel() <= 1.0 + 1e-4,
                    "{text} at {theta}°: {albedo:?}"
                );
            }
        }
    });
}

#[test]
fn samples_lie_where_their_density_says_and_weigh_what_is_reflected() {
    each(|_, text, made| {
        for theta in [0.0, 50.0, 80.0] {
            let wo = direction(theta, check::AZIMUTH);
            let sampling = check::chi_square(made, wo, 30_000);
            assert!(
                sampling.probability > 1e-5,
                "{text} at {theta}°: {sampling:?}"
            );
            let weights = check::weights(made, wo, 30_000);
            assert!(weights.deviation() < 5.0, "{text} at {theta}°: {weights:?}");
        }
    });
}

#[test]
fn no_angle_gives_anything_but_numbers() {
    let mut directions = vec![DVec3::Z];
    for theta in [1e-9, 20.0, 60.0, 89.0, 89.999_999, 90.0 - 1e-12] {
        directions.extend([0.0, 37.0, 90.0, 180.0, 217.0, 270.0].map(|phi| direction(theta, phi)));
    }
    directions.push(DVec3::new(1.0, 0.0, 1e-200));
    directions.push(DVec3::new(1.0, 0.0, f64::MIN_POSITIVE));
    directions.push(DVec3::X);
    directions.push(DVec3::NEG_Z);
    each(|_, text, made| {
        for &wo in &directions {
            for &wi in &directions {
                let (value, density) = (made.eval(wo, wi), made.pdf(wo, wi));
                let is_good = value.is_finite() && value.to_array().iter().all(|v| *v >= 0.0);
                assert!(is_good, "{text} {wo} {wi}: {value:?}");
                assert!(
                    density.is_finite() && density >= 0.0,
                    "{text} {wo} {wi}: {density}"
                );
            }
            assert!(made.mirror(wo.z.max(0.0)).is_finite(), "{text} {wo}");
            for u in [
                [0.0; 3],
                [0.5; 3],
                [1.0 - f64::EPSILON; 3],
                [0.999, 0.0, 1.0 - 1e-16],
            ] {
                if let Some(sample) = made.sample(wo, u) {
                    let good = sample.weight.is_finite() && sample.wi.z > 0.0 && sample.pdf > 0.0;
                    assert!(good, "{text} {wo} {u:?}: {sample:?}");
                }
            }
        }
    });
}

#[test]
fn what_is_the_same_along_both_axes_may_be_turned() {
    let is_stretched = |text: &str| {
        ["ay =", "ey =", "cx =", "poulin", "nv =", "nu =", "p = "]
            .iter()
            .any(|word| text.contains(word))
    };
    each(|_, text, made| {
        let turned = |by: f64| made.eval(direction(40.0, 20.0 + by), direction(55.0, 170.0 + by));
        let (here, there) = (turned(0.0), turned(77.0));
        let off = (here - there).map(f64::abs).max_channel();
        let same = off <= 1e-11 * here.max_channel().max(1e-9);
        if !is_stretched(text) {
            assert!(same, "{text}: {here:?} {there:?}");
        }
    });
}

#[test]
fn a_report_tells_where_most_is_reflected() {
    let effort = Effort {
        pairs: 100,
        samples: 2000,
    };
    let report = check::check(&brdf("ward_duer ax = 0.2"), effort);
    let (theta, albedo) = report.largest_albedo();
    assert!(theta == 89.0 && albedo > 2.0, "{report:?}");
    assert_eq!(report, check::check(&brdf("ward_duer ax = 0.2"), effort));
}
