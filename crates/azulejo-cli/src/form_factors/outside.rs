//! What rows receive from the sky, the sun and pictures of the surroundings.

use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, number};
use crate::session::Session;
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
) -> Result<Option<Vec<Gathered>>, Failure> {
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
    Ok(Some(rows))
}

/// Means over groups of rows, by area.
pub fn grouped(
    rows: &[Gathered],
    areas: &[f64],
    groups: &[Option<u32>],
    count: usize,
) -> Vec<Gathered> {
    let mut sums = vec![(0.0, Gathered::default()); count];
    for ((row, area), group) in rows.iter().zip(areas).zip(groups) {
        if let Some(group) = group {
            let (whole, sum) = &mut sums[*group as usize];
            *whole += area;
            for (sum, value) in sum.replicates.iter_mut().zip(row.replicates) {
                *sum += value * *area;
            }
        }
    }
    let mean = |(whole, sum): (f64, Gathered)| Gathered {
        replicates: sum.replicates.map(|e| e / whole.max(f64::MIN_POSITIVE)),
    };
    sums.into_iter().map(mean).collect()
}

/// Adds the mean over all rows to the report.
pub fn describe(rows: &[Gathered], areas: &[f64], report: &mut Report) {
    let all = vec![Some(0); rows.len()];
    let mean = grouped(rows, areas, &all, 1)[0];
    let (value, error) = (mean.mean().mean(), mean.standard_error().mean());
    report.fact(
        "irradiance_outside",
        number(value),
        "irradiance",
        format!("{value:.5} ± {error:.2} by light from outside, the mean of all rows"),
    );
    report.value("irradiance_outside_error", number(error));
}
