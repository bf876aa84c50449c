//! The engines that are checked.

use crate::engine::{EngineArgs, EngineName, GpuName, PreparedEngine};
use crate::failure::Failure;
use azulejo_factors::PatchSize;
use azulejo_factors::{FormFactorOptions, Patches};
use azulejo_scene::Scene;

/// An engine with a setting, ready to run.
pub struct CheckedEngine {
    /// Its name in the report.
    pub name: &'static str,
    /// The engine.
    pub prepared: PreparedEngine,
    /// Whether close pairs are computed in closed form.
    pub formulas: bool,
    /// What decides how good its answers have to be.
    pub family: EngineFamily,
}

/// Engines by their errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineFamily {
    /// Rays: standard errors.
    Rays,
    /// Rendering: standard errors, and curved bodies as facets.
    Rendering,
    /// Closed forms of polygons.
    Analytic,
}

/// Engines, and those that are not here with the reason.
pub struct CheckedEngines {
    /// Those that run.
    pub engines: Vec<CheckedEngine>,
    /// Names and reasons.
    pub missing: Vec<(&'static str, String)>,
}

/// An engine before it is prepared.
struct EngineChoice {
    name: &'static str,
    engine: EngineName,
    formulas: bool,
    gpu: Option<GpuName>,
    family: EngineFamily,
}

const CHOICES: [EngineChoice; 7] = [
    choice("rays", EngineName::Rays, EngineFamily::Rays),
    EngineChoice {
        formulas: true,
        ..choice(
            "rays and closed forms",
            EngineName::Rays,
            EngineFamily::Rays,
        )
    },
    choice("rays by Embree", EngineName::Embree, EngineFamily::Rays),
    EngineChoice {
        gpu: Some(GpuName::Off),
        ..choice("hemicube", EngineName::Hemicube, EngineFamily::Rendering)
    },
    EngineChoice {
        gpu: Some(GpuName::Auto),
        ..choice(
            "hemicube, graphics card",
            EngineName::Hemicube,
            EngineFamily::Rendering,
        )
    },
    EngineChoice {
        gpu: Some(GpuName::Off),
        ..choice("hybrid", EngineName::Hybrid, EngineFamily::Rendering)
    },
    EngineChoice {
        formulas: true,
        ..choice("analytic", EngineName::Analytic, EngineFamily::Analytic)
    },
];

const fn choice(name: &'static str, engine: EngineName, family: EngineFamily) -> EngineChoice {
    EngineChoice {
        name,
        engine,
        formulas: false,
        gpu: None,
        family,
    }
}

impl CheckedEngines {
    /// The engines of these names, or all; `resolution` in pixels is that of hemicubes.
    ///
    /// # Errors
    /// A named engine that is not here, or has no form factors to check.
    pub fn new(names: &[EngineName], resolution: u32) -> Result<CheckedEngines, Failure> {
        let mut checked = CheckedEngines {
            engines: Vec::new(),
            missing: Vec::new(),
        };
        if let Some(name) = names
            .iter()
            .find(|n| !CHOICES.iter().any(|c| c.engine == **n))
        {
            let word = format!("{name:?}").to_lowercase();
            return Err(Failure::misuse(format_args!(
                "--engine {word} is not checked by itself, expected rays, embree, hemicube, hybrid or analytic"
            )));
        }
        for choice in CHOICES {
            if !names.is_empty() && !names.contains(&choice.engine) {
                continue;
            }
            match choice.prepare(resolution) {
                Ok(engine) => checked.engines.push(engine),
                Err(failure) if choice.engine == EngineName::Embree && !names.is_empty() => {
                    return Err(failure);
                }
                Err(failure) => checked.missing.push((choice.name, failure.to_string())),
            }
        }
        Ok(checked)
    }
}

impl EngineChoice {
    fn prepare(&self, resolution: u32) -> Result<CheckedEngine, Failure> {
        let is_rendering = self.family == EngineFamily::Rendering;
        let args = EngineArgs {
            engine: self.engine,
            gpu: self.gpu,
            resolution: is_rendering.then_some(resolution),
            patch_points: None,
            embree: None,
        };
        let prepared = args.prepare()?;
        match prepared.notes().first() {
            // A card was asked for, and there is none.
            Some(note) => Err(Failure::failed(note)),
            None => Ok(CheckedEngine {
                name: self.name,
                prepared,
                formulas: self.formulas,
                family: self.family,
            }),
        }
    }
}

impl CheckedEngine {
    /// Its options for a scene with this many rays of all rows together.
    pub fn options(
        &self,
        scene: &Scene,
        size: PatchSize,
        rays: usize,
        seed: u64,
    ) -> FormFactorOptions {
        let patches = Patches::new(scene, size).len().max(1);
        FormFactorOptions {
            engine: self.prepared.engine.clone(),
            analytic: self.formulas,
            size,
            rays: (rays / patches).clamp(LEAST_RAYS, MOST_RAYS) as u32,
            seed,
            ..FormFactorOptions::default()
        }
    }
}

/// Rays of a row.
const LEAST_RAYS: usize = 1 << 10;
const MOST_RAYS: usize = 1 << 16;
