//! Engines compared on one patch: the error of its row of form factors against time.
//!
//! The experiment of B. Sena's thesis *Radiosity with specular surfaces* (2019) for a single row.

use crate::document::{SceneDocument, SurfacePick};
use crate::first_pass::{EngineChoice, LightSettings, factor_options, picked_row};
use azulejo::factors::form_factors::{Factor, Plan};
use azulejo::factors::{Engine, FormFactorOptions, Hemicube};
use azulejo::trace::{Progress, Tracer};
use std::time::Instant;

/// Rows of form factors by one engine with one number of samples, by several seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineRun {
    /// The engine.
    pub engine: EngineChoice,
    /// Rays, or pixels of all hemicubes.
    pub samples: u32,
    /// Seconds of wall-clock time, the least of all these rows: other programs only ever add to it.
    pub seconds: f64,
    /// Σ|X − R| / ΣR of the row X and that by formulas, R: the mean of several rows.
    pub error: f64,
}

/// Rows of each setting, by other random numbers.
const REPEATS: u64 = 4;
/// Rays of a row.
const RAYS: [u32; 7] = [64, 256, 1024, 4096, 16_384, 65_536, 262_144];
/// Pixels along the side of a hemicube, of which there are as many as usual.
const PIXELS: [u32; 6] = [8, 16, 32, 64, 128, 256];
/// Rays of the reference for what has no formula.
const REFERENCE_RAYS: u32 = 1 << 20;

/// Computes the row of a picked patch by rays and hemicubes with growing numbers of samples, without help from
/// formulas, and passes each result to `show`; nothing more if the job was cancelled.
///
/// # Errors
///
/// A message: no surface, too many patches, or no patch at that point.
pub fn compare_engines(
    document: &SceneDocument,
    settings: &LightSettings,
    pick: &SurfacePick,
    progress: &Progress,
    show: &dyn Fn(EngineRun),
) -> Result<(), String> {
    let (scene, own) = (document.scene(), factor_options(settings));
    let tracer = Tracer::new(&scene);
    // The row as `options` say, and the seconds that it took.
    let row = |options: &FormFactorOptions| -> Result<Option<(Vec<Factor>, f64)>, String> {
        let plan = Plan::new(&scene, &tracer, options).map_err(|e| e.to_string())?;
        let row = picked_row(document, &tracer, &plan, pick)?;
        let prepared = plan.prepare();
        let began = Instant::now();
        let factors = prepared.row(row, progress);
        Ok(factors.ok().map(|f| (f, began.elapsed().as_secs_f64())))
    };
    let reference = FormFactorOptions {
        engine: Engine::Analytic,
        rays: REFERENCE_RAYS,
        ..own.clone()
    };
    let Some((reference, _)) = row(&reference)? else {
        return Ok(());
    };
    for (engine, samples, options) in settings_of_runs(&own) {
        let mut run = EngineRun {
            engine,
            samples,
            seconds: f64::INFINITY,
            error: 0.0,
        };
        for seed in 1..=REPEATS {
            let Some((factors, seconds)) = row(&FormFactorOptions {
                seed,
                ..options.clone()
            })?
            else {
                return Ok(());
            };
            run.seconds = run.seconds.min(seconds);
            run.error += row_error(&factors, &reference) / REPEATS as f64;
        }
        show(run);
    }
    Ok(())
}

/// Both engines, from few samples to many.
fn settings_of_runs(own: &FormFactorOptions) -> Vec<(EngineChoice, u32, FormFactorOptions)> {
    let plain = FormFactorOptions {
        analytic: false,
        ..own.clone()
    };
    let rays = RAYS.map(|rays| {
        let options = FormFactorOptions {
            engine: Engine::Rays,
            rays,
            ..plain.clone()
        };
        (EngineChoice::Rays, rays, options)
    });
    let hemicubes = PIXELS.map(|resolution| {
        let hemicube = Hemicube {
            resolution,
            ..Hemicube::default()
        };
        // The top face, and the halves of four more.
        let pixels = 3 * resolution * resolution * hemicube.points;
        let options = FormFactorOptions {
            engine: Engine::Hemicube(hemicube),
            ..plain.clone()
        };
        (EngineChoice::Hemicube, pixels, options)
    });
    rays.into_iter().chain(hemicubes).collect()
}

/// Σ|X − R| / ΣR; 0 if the reference sees nothing.
fn row_error(row: &[Factor], reference: &[Factor]) -> f64 {
    let difference = row.iter().zip(reference);
    let difference: f64 = difference.map(|(x, r)| (x.value - r.value).abs()).sum();
    let sum: f64 = reference.iter().map(|r| r.value).sum();
    difference / sum.max(f64::MIN_POSITIVE)
}
