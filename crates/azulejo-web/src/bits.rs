//! Results to the last bit, to be compared between a page and the program on a desktop.

use azulejo::factors::form_factors::Plan;
use azulejo::factors::{Engine, FormFactorOptions, PatchSize};
use azulejo::formats::{Memory, grf};
use azulejo::radiosity::{FirstPass, solve};
use azulejo::render::{SecondPass, render};
use azulejo::scene::Scene;
use azulejo::trace::{Progress, Tracer};

/// A scene in GRF.
fn read(text: &[u8]) -> Result<Scene, String> {
    let loaded = grf::read(text, "scene.grf", &Memory::new());
    Ok(loaded.map_err(|e| e.to_string())?.scene)
}

/// All form factors between 100 patches by rays, row by row, each 8 bytes.
///
/// # Errors
/// Not a scene, or one without surfaces.
pub fn form_factors(text: &[u8]) -> Result<Vec<u8>, String> {
    let scene = read(text)?;
    let tracer = Tracer::new(&scene);
    let options = FormFactorOptions {
        size: PatchSize::Squares(100),
        engine: Engine::Rays,
        ..FormFactorOptions::default()
    };
    let plan = Plan::new(&scene, &tracer, &options).map_err(|e| e.to_string())?;
    let rows = plan.patches().len();
    let (plan, progress) = (plan.prepare(), Progress::new());
    let mut bytes = Vec::new();
    for row in 0..rows {
        let row = plan.row(row, &progress).map_err(|e| e.to_string())?;
        bytes.extend(row.iter().flat_map(|f| f.value.to_le_bytes()));
    }
    Ok(bytes)
}

/// Relative error of [`solution`].
const ERROR: f64 = 0.02;

/// The scene with its light, solved to 2%, as GRF.
///
/// # Errors
/// Not a scene, or one that cannot be solved.
pub fn solution(text: &[u8]) -> Result<Vec<u8>, String> {
    let mut scene = read(text)?;
    let pass = FirstPass {
        size: PatchSize::Squares(1_500),
        error: Some(ERROR),
        memory: 1 << 30,
        ..FirstPass::default()
    };
    let tracer = Tracer::new(&scene);
    let light = solve(&scene, &tracer, &pass, &Progress::new()).map_err(|e| e.to_string())?;
    scene.set_irradiance(light.irradiance);
    let mut bytes = Vec::new();
    grf::write(&scene, &mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// A picture of 80 × 60 pixels by the scene's first camera: linear radiance, four bytes per channel.
///
/// # Errors
/// Not a scene, or one without a camera.
pub fn picture(text: &[u8]) -> Result<Vec<u8>, String> {
    let scene = read(text)?;
    let camera = scene.cameras.first().ok_or("there is no camera")?;
    let options = SecondPass {
        size: (80, 60),
        samples_per_pixel: 8,
        ..SecondPass::default()
    };
    let tracer = Tracer::new(&scene);
    let image = render(&scene, &tracer, camera, &options, &Progress::new());
    let image = image.map_err(|e| e.to_string())?;
    let channels = image.pixels.iter().flatten();
    Ok(channels.flat_map(|c| c.to_le_bytes()).collect())
}
