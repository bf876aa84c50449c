//! The options of form factors, as the command makes them of its own.

use crate::choices;
use crate::error::refused;
use azulejo::periods::Periods;
use azulejo_factors::{Closure, Engine, FormFactorOptions, GroupBy, Hemicube};
use azulejo_scene::sky::SkyDivision;
use pyo3::prelude::*;

/// Options by name; what is `None` is the default.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct OptionArgs {
    engine: String,
    patches: Option<usize>,
    patch_size: Option<f64>,
    rays: Option<u32>,
    two_sided: bool,
    closure: Option<String>,
    separate: bool,
    formulas: bool,
    seed: u64,
    tolerance: Option<f64>,
    memory: Option<u64>,
    resolution: Option<u32>,
    patch_points: Option<u32>,
    periodic: Option<String>,
    /// Division of the sky, and north of the scene in degrees.
    sky_patches: Option<(String, f64)>,
}

impl OptionArgs {
    /// The library's options.
    pub fn options(&self) -> PyResult<FormFactorOptions> {
        let default = FormFactorOptions::default();
        let machine = || azulejo::machine::memory().unwrap_or(u64::MAX);
        Ok(FormFactorOptions {
            engine: self.engine()?,
            groups: None,
            size: choices::patch_size(self.patches, self.patch_size).unwrap_or(default.size),
            rays: self.rays.unwrap_or(default.rays),
            two_sided: self.two_sided,
            seed: self.seed,
            analytic: self.formulas,
            accuracy: self.tolerance,
            separate: self.separate,
            closure: match (&self.closure, self.formulas) {
                (Some(name), _) => choices::closure(name)?,
                (None, true) => Closure::Closed,
                (None, false) => Closure::Never,
            },
            memory: self.memory.unwrap_or_else(machine),
        })
    }

    /// The same where only groups of rows are wanted: planned for them, as far as nothing else is said.
    pub fn options_for(&self, by: Option<GroupBy>) -> PyResult<FormFactorOptions> {
        let options = self.options()?;
        let is_divided = self.patches.is_some() || self.patch_size.is_some();
        let is_planned = !is_divided && self.rays.is_none() && self.patch_points.is_none();
        let Some(by) = by.filter(|_| is_planned) else {
            return Ok(options);
        };
        let resolution = self.resolution.unwrap_or(Hemicube::GROUP_RESOLUTION);
        Ok(FormFactorOptions {
            engine: options.engine.with_resolution(resolution),
            groups: Some(by),
            ..options
        })
    }

    /// Where the scene repeats itself.
    pub fn periods(&self) -> PyResult<Option<Periods>> {
        let text = self.periodic.as_deref();
        let parsed = text.map(|text| {
            text.parse()
                .map_err(|e: String| refused(format_args!("periodic: {e}")))
        });
        parsed.transpose()
    }

    /// The patches of the sky that are asked for, and the north of the scene in radians.
    pub fn sky(&self) -> PyResult<Option<(SkyDivision, f64)>> {
        let Some((text, north)) = &self.sky_patches else {
            return Ok(None);
        };
        let division = text.parse();
        let division = division.map_err(|e| refused(format_args!("sky_patches: {e}")))?;
        Ok(Some((division, north.to_radians())))
    }

    /// A number of rays, or no formulas, choose rays where nothing else does.
    fn engine(&self) -> PyResult<Engine> {
        match choices::engine(&self.engine, self.resolution, self.patch_points)? {
            Engine::Auto if self.rays.is_some() || !self.formulas => Ok(Engine::Rays),
            Engine::Particles => Err(refused(
                "particles have no form factors: that engine is for solve_light and probe",
            )),
            Engine::Analytic if !self.formulas => Err(refused(
                "formulas=False does not apply to the engine analytic, which is formulas alone",
            )),
            engine => Ok(engine),
        }
    }
}
