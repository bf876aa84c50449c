//! `brdf eval`: values of a model for pairs of directions.

use super::args::{DirectionAngles, EvalArgs};
use super::model::{self, direction};
use crate::failure::Failure;
use crate::report::{Report, numbers};
use crate::session::Session;
use azulejo_scene::{Brdf, Rgb};
use glam::DVec3;
use serde_json::{Value, json};

/// The quantity that is printed.
#[derive(Clone, Copy, PartialEq)]
enum EvaluatedQuantity {
    /// f_r, 1/sr.
    Brdf,
    /// Reflectance of a perfect mirror, dimensionless.
    Reflectance,
}

/// Runs `brdf eval`.
pub fn run(args: &EvalArgs, session: &mut Session) -> Result<Report, Failure> {
    let pairs = pairs(&args.wi, &args.wo)?;
    let brdf = model::read(&args.model, session)?;
    let quantity = quantity(&brdf);
    let mut report = Report::default();
    let (name, unit) = match quantity {
        EvaluatedQuantity::Brdf => ("f_r", "1/sr"),
        EvaluatedQuantity::Reflectance => ("reflectance", ""),
    };
    if quantity == EvaluatedQuantity::Reflectance && !session.quiet() {
        report.plain("Reflectance of the perfect mirror at the angle of --i:");
    }
    let mut values = Vec::new();
    for (i, o) in pairs {
        let value = match quantity {
            EvaluatedQuantity::Brdf => brdf.eval(direction(o), direction(i)),
            EvaluatedQuantity::Reflectance => brdf.mirror(direction(i).z),
        };
        let words = written(value);
        if session.quiet() {
            report.plain(words);
        } else {
            let (i, o) = (angles(i), angles(o));
            report.line(&format!("i {i}  o {o}"), format!("{words} {unit}"));
        }
        values.push(json!({
            "i": [i.theta, i.phi],
            "o": [o.theta, o.phi],
            "value": numbers(value.to_array()),
        }));
    }
    report.value("model", model::words(&brdf));
    report.value("quantity", name);
    report.value("unit", unit);
    report.value("values", Value::Array(values));
    Ok(report)
}

/// Pairs of directions: as many of both, or one for all.
fn pairs(
    wi: &[DirectionAngles],
    wo: &[DirectionAngles],
) -> Result<Vec<(DirectionAngles, DirectionAngles)>, Failure> {
    match (wi, wo) {
        (&[i], _) => Ok(wo.iter().map(|&o| (i, o)).collect()),
        (_, &[o]) => Ok(wi.iter().map(|&i| (i, o)).collect()),
        _ if wi.len() == wo.len() => Ok(std::iter::zip(wi, wo).map(|(&i, &o)| (i, o)).collect()),
        _ => Err(Failure::Misuse(format!(
            "{} directions --i and {} --o, expected the same number of both, or one for all",
            wi.len(),
            wo.len()
        ))),
    }
}

/// Perfect mirrors have no value in 1/sr.
fn quantity(brdf: &Brdf) -> EvaluatedQuantity {
    let scattered = brdf.albedo(DVec3::Z) - brdf.mirror(1.0);
    if scattered.is_black() && !brdf.mirror(1.0).is_black() {
        EvaluatedQuantity::Reflectance
    } else {
        EvaluatedQuantity::Brdf
    }
}

/// Twelve digits; one number if all channels are equal.
fn written(value: Rgb) -> String {
    if value.is_grey() {
        return digits(value.r);
    }
    value.to_array().map(digits).join(" ")
}

/// A number to twelve digits, without trailing zeros.
fn digits(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude != 0.0 && !(1e-4..1e9).contains(&magnitude) {
        return format!("{x:.11e}");
    }
    let before = if magnitude == 0.0 {
        0.0
    } else {
        magnitude.log10().floor()
    };
    let text = format!("{x:.*}", (11.0 - before) as usize);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn angles(DirectionAngles { theta, phi }: DirectionAngles) -> String {
    format!("{theta}°,{phi}°")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_twelve_digits() {
        let check = |x: f64, expected: &str| assert_eq!(digits(x), expected);
        check(1.202_026_145_472_3, "1.20202614547");
        check(0.071_721_343_5, "0.0717213435");
        check(0.0, "0");
        check(250.0, "250");
        check(1.5e-7, "1.50000000000e-7");
    }
}
