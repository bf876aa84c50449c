//! What rows receive from the sky, the sun and pictures of the surroundings.

use super::args::FormFactorArgs;
use crate::failure::Failure;
use crate::pass;
use crate::report::{Report, number};
use crate::session::Session;
use azulejo_exchange::files::FactorFormat;
use azulejo_exchange::{Enclosure, Groups, OutsideLight};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{PreparedPlan, SkyFactors};
use azulejo_scene::Scene;
use azulejo_scene::sky::SkyDivision;

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

/// What rows see of the patches of the sky, if that is asked for.
pub fn sky(
    plan: &PreparedPlan,
    factors: &FormFactors,
    asked: Option<AskedSky>,
    session: &mut Session,
) -> Result<Option<SkyFactors>, Failure> {
    let Some(AskedSky { division, north }) = asked else {
        return Ok(None);
    };
    let found = session.with_progress(|p| plan.sky_factors(division, north, factors, p));
    found.map(Some).map_err(pass::failure)
}

/// Patches of the sky for which shares are wanted.
#[derive(Clone, Copy, Debug)]
pub struct AskedSky {
    division: SkyDivision,
    /// North of the scene, radians.
    north: f64,
}

impl AskedSky {
    /// What the arguments ask for.
    ///
    /// # Errors
    /// The output has no place for it.
    pub fn of(args: &FormFactorArgs) -> Result<Option<AskedSky>, Failure> {
        let Some(division) = args.matrix.sky_patches else {
            return Ok(None);
        };
        if !matches!(
            args.file_format(),
            None | Some(FactorFormat::Npz | FactorFormat::Csv)
        ) {
            return Err(Failure::misuse(format_args!(
                "--sky-patches: {} has no place for them; expected an .npz or a .csv",
                args.output.display()
            )));
        }
        let north = args.input.outside.north.to_radians();
        Ok(Some(AskedSky { division, north }))
    }
}

/// Adds the division of the sky and the mean irradiance of all rows to the report.
pub fn describe(enclosure: &Enclosure, report: &mut Report) {
    if let Some(sky) = &enclosure.sky {
        let (division, count) = (sky.division.to_string(), sky.division.count() - 1);
        report.value("sky_patches", count);
        report.fact(
            "sky_division",
            division.clone(),
            "patches of the sky",
            format!("{count} ({division}), and the ground"),
        );
    }
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
