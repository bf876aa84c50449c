//! Comparison with a table of values from another program, if it is available.

use super::{brdf, direction};

/// Compares the value of a row with that of its model.
fn check(row: &str) {
    let cells: Vec<&str> = row.split('\t').collect();
    let [id, model, parameters, angles @ .., expected] = &cells[..] else {
        panic!("a row has at least four cells: {row}");
    };
    let angles: Vec<f64> = angles.iter().map(|a| a.parse().unwrap()).collect();
    let expected: f64 = expected.parse().unwrap();
    let text = format!("{model} {}", parameters.replace(';', " "));
    let made = brdf(&text);
    let (wi, wo) = (
        direction(angles[0], angles[1]),
        direction(angles[2], angles[3]),
    );
    let is_mirror = model.starts_with("fresnel") || model.ends_with("rho_s");
    let value = if is_mirror {
        made.mirror(wi.z)
    } else {
        made.eval(wo, wi)
    };
    let tolerance = if *model == "ggx_ms" { 1e-5 } else { 1e-6 };
    assert!(
        (value.r / expected - 1.0).abs() < tolerance,
        "{id} {text}: {} instead of {expected}",
        value.r
    );
}

#[test]
fn the_table_of_values_is_kept() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let path = data.join("reference/brdf_values.tsv");
    let table = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let rows = table.lines().filter(|l| !l.starts_with('#')).skip(1);
    rows.for_each(check);
}
