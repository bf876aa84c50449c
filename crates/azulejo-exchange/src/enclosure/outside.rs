//! Light from outside on rows.

use super::OutsideLight;
use azulejo_factors::form_factors::PreparedPlan;
use azulejo_factors::{FactorsError, FormFactors};
use azulejo_scene::{LightKind, Rgb, Scene};
use azulejo_trace::{Gathered, Progress};
use std::f64::consts::PI;

impl OutsideLight {
    /// The light of sun, sky and pictures of the surroundings on the rows of a plan, of which `factors`
    /// were computed; `None` if there is none.
    ///
    /// # Errors
    /// [`FactorsError::Cancelled`].
    pub fn of_rows(
        plan: &PreparedPlan,
        scene: &Scene,
        factors: &FormFactors,
        progress: &Progress,
    ) -> Result<Option<Vec<OutsideLight>>, FactorsError> {
        let ambient = scene.lights.iter().filter_map(|light| match light.kind {
            LightKind::Ambient { radiance } => Some(radiance * PI),
            _ => None,
        });
        let ambient: Rgb = ambient.sum();
        let mut rows = if plan.has_light_from_outside() {
            plan.light_from_outside(progress)?
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
}
