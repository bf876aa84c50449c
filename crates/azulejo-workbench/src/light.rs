//! The first pass as the window runs it.

use crate::document::{Document, Solution};
use crate::jobs::Outbox;
use azulejo::radiosity::{Engine, FirstPass, Hemicube, PatchSize, SolveError, solve};
use azulejo::trace::{Progress, Tracer};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Who computes form factors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EngineName {
    /// Whoever suits the scene.
    #[default]
    Auto,
    /// Rays.
    Rays,
    /// Pictures from each patch.
    Hemicube,
    /// Pictures, and rays for what mirrors show.
    Hybrid,
    /// Formulas.
    Analytic,
}

impl EngineName {
    /// All of them.
    pub const ALL: [EngineName; 5] = [
        EngineName::Auto,
        EngineName::Rays,
        EngineName::Hemicube,
        EngineName::Hybrid,
        EngineName::Analytic,
    ];

    /// As the library takes it.
    pub fn engine(self) -> Engine {
        match self {
            EngineName::Auto => Engine::Auto,
            EngineName::Rays => Engine::Rays,
            EngineName::Hemicube => Engine::Hemicube(Hemicube::default()),
            EngineName::Hybrid => Engine::Hybrid(Hemicube::default()),
            EngineName::Analytic => Engine::Analytic,
        }
    }
}

/// How light is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSettings {
    /// Who computes form factors.
    pub engine: EngineName,
    /// How many patches the surfaces are divided into, about.
    pub patches: u32,
    /// Relative error at which the solver rests.
    pub error: f64,
    /// Seconds after which it rests in any case.
    pub time: Option<f64>,
    /// Diffuse bounces to follow; `None` for all.
    pub bounces: Option<u32>,
}

impl Default for LightSettings {
    fn default() -> LightSettings {
        LightSettings {
            engine: EngineName::Auto,
            patches: 1_500,
            error: 0.03,
            time: None,
            bounces: None,
        }
    }
}

/// One moment of a solution on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds since the solver began.
    pub seconds: f64,
    /// Estimated relative error of irradiance.
    pub error: f64,
    /// Change of the last bounce.
    pub residual: f64,
}

/// The errors of the drafts that come before the answer: each costs about a quarter of the next.
fn drafts(goal: f64) -> Vec<f64> {
    const FIRST: f64 = 0.25;
    let mut errors: Vec<f64> = std::iter::successors(Some(goal), |e| Some(2.0 * e))
        .take_while(|&e| e < FIRST)
        .collect();
    errors.reverse();
    match errors.is_empty() {
        true => vec![goal],
        false => errors,
    }
}

/// Solves a document's light, better and better; sends every solution with its moment.
///
/// # Errors
/// The solver's own, in words.
pub fn solve_document(
    document: &Document,
    settings: &LightSettings,
    progress: &Progress,
    outbox: &Outbox<crate::app::Found>,
) -> Result<(), String> {
    let begin = Instant::now();
    let deadline = settings
        .time
        .map(|t| begin + Duration::from_secs_f64(t.clamp(0.0, 1e6)));
    if let Some(deadline) = deadline {
        progress.set_deadline(deadline);
    }
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    for error in drafts(settings.error) {
        let pass = FirstPass {
            engine: settings.engine.engine(),
            size: PatchSize::Count(settings.patches.max(1) as usize),
            error: Some(error),
            bounces: settings.bounces,
            memory: azulejo::machine::memory_budget(),
            ..FirstPass::default()
        };
        let light = match solve(&scene, &tracer, &pass, progress) {
            Err(SolveError::Cancelled) => return Ok(()),
            other => other.map_err(|e| e.to_string())?,
        };
        let moment = Moment {
            seconds: begin.elapsed().as_secs_f64(),
            error: light.report.error,
            residual: light.report.residual,
        };
        let solution = Solution::new(
            document.clone(),
            scene.clone(),
            light.irradiance,
            light.report,
        );
        outbox.send(crate::app::Found::Light(Box::new(solution), moment));
        if progress.out_of_time() {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drafts_end_at_the_goal() {
        assert_eq!(drafts(0.5), [0.5]);
        assert_eq!(drafts(0.05), [0.2, 0.1, 0.05]);
        assert_eq!(drafts(0.25), [0.25]);
    }
}
