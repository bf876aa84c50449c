//! The third pass as run by the window: a lightmap of the document, and its files.

mod files;
mod shown;
mod source;

pub use files::{LightmapFile, numbered, write};
pub use shown::{LightmappedMesh, ShownLightmap};

use crate::document::SceneDocument;
use crate::first_pass::LightSettings;
use azulejo::bake::{Resolution, UnwrapOptions};
use azulejo::formats::gltf::patch::Convention;
use azulejo::lightmap::{
    BakeError, BakeOptions, BakeSource, Baked, BakedLight, BakedSides, Coordinates, bake,
};
use azulejo::radiosity::{FirstPass, SolveError};
use azulejo::scene::Scene;
use azulejo::trace::time::{Duration, Instant};
use azulejo::trace::{Progress, Tracer};

/// Largest width and height of pages whose resolution is given, texels.
const MAX_SIZE: u32 = 8192;

/// How a lightmap is baked and said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Width and height of the page, texels; unused with `texels_per_metre`.
    pub size: u32,
    /// Texels per metre of surface, on as many pages as that takes.
    pub texels_per_metre: Option<f64>,
    /// Relative error of the irradiance at which gathering stops.
    pub error: f64,
    /// The side of surfaces that has light; `None` for the front in glTF files and the brighter one in others.
    pub sides: Option<BakedSides>,
    /// Which light.
    pub light: BakedLight,
    /// What tells viewers of the lightmap.
    pub convention: Convention,
}

impl Default for BakeSettings {
    fn default() -> BakeSettings {
        BakeSettings {
            size: 1024,
            texels_per_metre: None,
            error: 0.03,
            sides: None,
            light: BakedLight::Total,
            convention: Convention::Moz,
        }
    }
}

impl BakeSettings {
    /// Charts and pages in the units of a scene.
    fn charts(&self, scene: &Scene) -> UnwrapOptions {
        let (resolution, size) = match self.texels_per_metre {
            Some(density) => (
                Resolution::PerUnit(density * scene.units.metres()),
                MAX_SIZE,
            ),
            None => (Resolution::Fill, self.size),
        };
        UnwrapOptions {
            resolution,
            size,
            ..UnwrapOptions::default()
        }
    }

    /// The library's type for these settings, with the engine and the bounces of the solver.
    fn options(&self, light: &LightSettings, source: &BakeSource) -> BakeOptions {
        let usual = if source.is_given {
            BakedSides::Front
        } else {
            BakedSides::Brighter
        };
        BakeOptions {
            is_directional: false,
            denoises: false,
            charts: self.charts(&source.scene),
            coordinates: Coordinates::New,
            densities: Vec::new(),
            follows_light: false,
            pass: FirstPass {
                engine: light.engine.engine(),
                error: Some(self.error),
                bounces: light.bounces,
                memory: azulejo::machine::memory_budget(),
                ..FirstPass::default()
            },
            light: self.light,
            sides: self.sides.unwrap_or(usual),
        }
    }
}

/// A lightmap with what it was baked of.
pub struct BakedDocument {
    /// The document at that time.
    pub document: SceneDocument,
    /// The scene, and the glTF file that gets the lightmap.
    pub source: BakeSource,
    /// Its charts, and the light of its texels.
    pub baked: Baked,
    /// The settings with which it was baked.
    pub settings: BakeSettings,
    /// Texels per metre of each chart.
    pub densities: Vec<f64>,
    /// How long it took.
    pub time: Duration,
}

/// Bakes a lightmap of a document; `None` if it was cancelled. `note` gets messages as they come up.
///
/// # Errors
///
/// What cannot be laid out, written or solved, as text.
pub fn bake_document(
    document: &SceneDocument,
    settings: &BakeSettings,
    light: &LightSettings,
    progress: &Progress,
    note: &dyn Fn(String),
) -> Result<Option<BakedDocument>, String> {
    let begin = Instant::now();
    progress.begin("reading", 0);
    let mut source = source::of(document, settings.sides == Some(BakedSides::Both))?;
    source.notes.iter().cloned().for_each(note);
    let tracer = Tracer::new(&source.scene);
    let options = settings.options(light, &source);
    let (scene, receivers) = (&source.scene, &source.receivers);
    let mut baked = match bake(scene, &tracer, receivers, &options, progress) {
        Err(BakeError::Solve(SolveError::Cancelled)) => return Ok(None),
        baked => baked.map_err(|error| error.to_string())?,
    };
    (source.turn_to_light(&mut baked)).map_err(|error| error.to_string())?;
    Ok(Some(BakedDocument {
        document: document.clone(),
        densities: densities(&source, &baked),
        source,
        baked,
        settings: *settings,
        time: begin.elapsed(),
    }))
}

/// Texels per metre of each chart.
fn densities(source: &BakeSource, baked: &Baked) -> Vec<f64> {
    let atlas = &baked.atlas;
    let mut sums = vec![(0.0, 0.0); atlas.layout.charts as usize];
    for (r, receiver) in atlas.receivers.iter().enumerate() {
        for t in 0..receiver.triangles.len() {
            let chart = atlas.layout.receivers[r].charts[t];
            if let Some((texels, area)) = sums.get_mut(chart as usize) {
                let [a, b, c] = atlas.layout.texels(r, t);
                *texels += 0.5 * (b - a).perp_dot(c - a).abs();
                *area += receiver.area_vector(t).length();
            }
        }
    }
    let metres = source.scene.units.metres();
    let density = |(texels, area): (f64, f64)| (texels / f64::max(area, f64::MIN_POSITIVE)).sqrt();
    sums.into_iter().map(|sum| density(sum) / metres).collect()
}
