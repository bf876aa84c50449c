//! What rows receive from the sky, the sun and pictures of the surroundings.

use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, number};
use crate::session::Session;
use azulejo_exchange::{Enclosure, Groups, OutsideLight};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::PreparedPlan;
use azulejo_scene::{LightKind, Scene};
use azulejo_trace::Gathered;
use std::f64::consts::PI;

/// The irradiance of each row by light from outside; `None` if there is none.
pub fn irradiance(
    plan: &PreparedPlan,
    scene: &Scene,
    factors: &FormFactors,
    session: &mut Session,
) -> Result<Option<Vec<OutsideLight>>, Failure> {
    let ambient = scene.lights.iter().filter_map(|light| match light.kind {
        LightKind::Ambient { radiance } => Some(radiance * PI),
        _ => None,
    });
    let ambient: azulejo_scene::Rgb = ambient.sum();
    let mut rows = if plan.has_light_from_outside() {
        let found = session.with_progress(|p| plan.light_from_outside(p));
        found.map_err(pass::failure)?
    } else if ambient.is_black() {
        return Ok(None);
    } else {
        vec![Gathered::default(); factors.len()]
    };
    for (row, rest) in rows.iter_mut().zip(&factors.rest) {
        row.replicates
            .iter_mut()
            .for_each(|e| *e += ambient * rest.escaped());
    }
    let light = |row: &Gathered| OutsideLight {
        irradiance: row.mean(),
        error: row.standard_error(),
    };
    Ok(Some(rows.iter().map(light).collect()))
}

/// Adds the mean over all rows to the report.
pub fn describe(enclosure: &Enclosure, report: &mut Report) {
    let all = Groups {
        of_rows: vec![Some(0); enclosure.len()],
        names: vec![String::new()],
    };
    let Some(mean) = enclosure.mean_outside(&all) else {
        return;
    };
    let (value, error) = (mean[0].irradiance.mean(), mean[0].error.mean());
    report.fact(
        "irradiance_outside",
        number(value),
        "irradiance",
        format!("{value:.5} ± {error:.2} by light from outside, the mean of all rows"),
    );
    report.value("irradiance_outside_error", number(error));
}
