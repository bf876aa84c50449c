//! What rows receive from the sky, the sun and pictures of the surroundings.

use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, number};
use crate::session::Session;
use azulejo_exchange::{Enclosure, Groups, OutsideLight};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::PreparedPlan;
use azulejo_scene::Scene;

/// The irradiance of each row by light from outside; `None` if there is none.
pub fn irradiance(
    plan: &PreparedPlan,
    scene: &Scene,
    factors: &FormFactors,
    session: &mut Session,
) -> Result<Option<Vec<OutsideLight>>, Failure> {
    let light = session.with_progress(|p| OutsideLight::of_rows(plan, scene, factors, p));
    light.map_err(pass::failure)
}

/// Adds the mean over all rows to the report.
pub fn describe(enclosure: &Enclosure, report: &mut Report) {
    let one_group = Groups {
        of_rows: vec![Some(0); enclosure.len()],
        names: vec![String::new()],
    };
    let Some(mean) = enclosure.mean_outside(&one_group) else {
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
