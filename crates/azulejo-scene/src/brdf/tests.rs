//! Invariants of all models.

mod models;
mod reference;
mod values;

use super::*;
use check::direction;

fn brdf(text: &str) -> Brdf {
    let description: Description = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    Brdf::new(description).unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn descriptions_say_what_they_are() {
    for text in [
        "lewis kd = 0.25 ks = (0.5, 0.25, 0.125) n = 20",
        "combination weight = 0.5 diffuse kd = 0.5 weight = 0.25 lewis n = 3",
    ] {
        let description: Description = text.parse().unwrap();
        assert_eq!(description.to_string(), text);
    }
}

#[test]
fn bad_descriptions_are_refused_with_reasons() {
    let check = |text: &str, expected: &str| {
        let made = text.parse().and_then(Brdf::new);
        let problem = made.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(problem.contains(expected), "{text}: {problem}");
    };
    check("lewiss n = 3", "nearest name is `lewis`");
    check("lewis m = 3", "no parameter `m`");
    check("lewis ks = 1", "needs `n`");
    check("lewis n = 3 n = 4", "twice");
    check("lewis n = -1", "between 0 and");
    check("lewis n = NaN", "between 0 and");
    check("lewis n = 3 kd = 0.6 ks = 0.6", "create energy");
    check("combination weight = 2 diffuse kd = 0.5", "more than 1");
    check("", "found nothing");
    check("fresnel_conductor eta = 1 F = 0.5", "one Fresnel term");
}

#[test]
fn lewis_keeps_its_table() {
    let lobe = brdf("lewis kd = 0.3 ks = 0.4 n = 10");
    let f = lobe.eval(direction(40.0, 170.0), direction(30.0, 0.0)).r;
    assert!((f / 0.719_213_448_458 - 1.0).abs() < 1e-9, "{f}");
    let albedo = brdf("lewis n = 20").albedo(direction(60.0, 30.0)).r;
    assert!((albedo - 0.5).abs() < 2e-3, "{albedo}");
}
