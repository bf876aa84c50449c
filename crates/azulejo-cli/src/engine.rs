//! The form factor engine: its options, its preparation, and its part of the report.

use super::content_key::ContentHasher;
use super::failure::Failure;
use super::report::Report;
use super::values;
use azulejo_factors::{Engine, EngineUsed, Hemicube, HemicubeBackend};
use azulejo_scene::Scene;
use azulejo_trace::item_buffer::Device;
use azulejo_trace::{Kernel, Tracer};
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;
use std::sync::Arc;

/// Environment variable with the path of Embree's library, if `--embree` gives none.
const EMBREE_VARIABLE: &str = "AZULEJO_EMBREE";

/// Engines. Embree is the ray engine with another ray tracing kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// Analytic for scenes of few flat surfaces, otherwise rays; the summary says which, and why
    Auto,
    /// Rays from random points of each patch, followed through mirrors and glass
    Rays,
    /// The same rays, traced by Embree
    Embree,
    /// Item buffers rendered from each patch, on the processor or a graphics card
    Hemicube,
    /// Item buffers for direct visibility, rays for paths through mirrors and glass
    Hybrid,
    /// Closed-form factors between polygons, with exact occlusion
    Analytic,
    /// Particles shot from the lights; for solve, render and probe, not for form factors
    Particles,
}

/// Backends that render hemicubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GpuName {
    /// A graphics card if there is one, otherwise the processor
    Auto,
    /// The processor
    Off,
    /// Vulkan
    Vulkan,
    /// OpenGL
    Gl,
}

/// The form factor engine.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Engine")]
pub struct EngineArgs {
    /// How form factors are computed
    #[arg(long, value_name = "ENGINE", value_enum, default_value_t = EngineName::Auto)]
    pub engine: EngineName,
    /// Backend that renders the hemicubes of --engine hemicube and hybrid [default: auto]
    #[arg(long, value_name = "BACKEND", value_enum)]
    pub gpu: Option<GpuName>,
    /// Resolution of a hemicube in pixels, an even number [default: 128, or 32 where form factors of groups are
    /// planned]
    #[arg(long, value_name = "N", value_parser = values::resolution)]
    pub resolution: Option<u32>,
    /// Hemicubes per patch, at different points: one at the barycentre, whose error is unknown, or a
    /// multiple of four, to which other numbers are rounded up [default: 16, or planned for the groups of
    /// --by]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub patch_points: Option<u32>,
    /// Trace the rays of the engine and of gathering with Embree. PATH is its library [default: the
    /// environment variable AZULEJO_EMBREE, or the system's search path]
    // With a space, the model that follows would be taken for the library.
    #[arg(
        long,
        value_name = "PATH",
        value_hint = ValueHint::FilePath,
        num_args = 0..=1,
        require_equals = true
    )]
    pub embree: Option<Option<PathBuf>>,
}

/// What an engine is called on the command line.
pub fn word(engine: &Engine) -> &'static str {
    match engine {
        Engine::Auto => "auto",
        Engine::Rays => "rays",
        Engine::Hemicube(_) => "hemicube",
        Engine::Hybrid(_) => "hybrid",
        Engine::Analytic => "analytic",
        Engine::Particles => "particles",
    }
}

/// Adds an engine with all its settings to a key.
pub fn add_to_key(engine: &Engine, hasher: &mut ContentHasher) {
    let mut hemicubes = |kind: &str, hemicube: &Hemicube| {
        let Hemicube {
            resolution,
            points,
            device,
        } = hemicube;
        let device = match device {
            HemicubeBackend::Processor => "processor".to_owned(),
            HemicubeBackend::Device(device) => device.name(),
        };
        hasher.add(kind).add(resolution).add(points).add(&device);
    };
    match engine {
        Engine::Hemicube(hemicube) => hemicubes("hemicube", hemicube),
        Engine::Hybrid(hemicube) => hemicubes("hybrid", hemicube),
        other => {
            hasher.add(word(other));
        }
    }
}

/// An engine with its kernel and devices loaded.
pub struct PreparedEngine {
    /// The engine, as the libraries take it.
    pub engine: Engine,
    /// Whether to fail rather than to fall back to azulejo's own kernel.
    requires_embree: bool,
    kernel: Kernel,
    notes: Vec<String>,
}

impl EngineArgs {
    /// Loads what the engine needs.
    ///
    /// # Errors
    /// What is missing, and how to get it.
    pub fn prepare(&self) -> Result<PreparedEngine, Failure> {
        self.check()?;
        let mut notes = Vec::new();
        let kernel = self.kernel(&mut notes)?;
        let engine = match self.engine {
            EngineName::Auto => Engine::Auto,
            EngineName::Rays | EngineName::Embree => Engine::Rays,
            EngineName::Hemicube => Engine::Hemicube(self.hemicube(&mut notes)?),
            EngineName::Hybrid => Engine::Hybrid(self.hemicube(&mut notes)?),
            EngineName::Analytic => Engine::Analytic,
            EngineName::Particles => Engine::Particles,
        };
        Ok(PreparedEngine {
            engine,
            requires_embree: self.requires_embree(),
            kernel,
            notes,
        })
    }

    /// Refuses options that the engine does not have.
    pub fn check(&self) -> Result<(), Failure> {
        let misuse = |option: &str, engines: &str| {
            let message = format_args!("{option} applies only to --engine {engines}");
            Err(Failure::misuse(message))
        };
        let has_hemicubes = matches!(self.engine, EngineName::Hemicube | EngineName::Hybrid);
        match self {
            EngineArgs {
                resolution: Some(_),
                ..
            } if !has_hemicubes => misuse("--resolution", "hemicube and hybrid"),
            EngineArgs {
                patch_points: Some(_),
                ..
            } if !has_hemicubes => misuse("--patch-points", "hemicube and hybrid"),
            EngineArgs { gpu: Some(_), .. } if !has_hemicubes => {
                misuse("--gpu", "hemicube and hybrid")
            }
            _ => Ok(()),
        }
    }

    /// Whether to fail without Embree. An automatic choice does without it, with a note.
    fn requires_embree(&self) -> bool {
        self.engine == EngineName::Embree
            || self.embree.is_some() && self.engine != EngineName::Auto
    }

    /// Embree if it is requested.
    fn kernel(&self, notes: &mut Vec<String>) -> Result<Kernel, Failure> {
        if self.engine != EngineName::Embree && self.embree.is_none() {
            return Ok(Kernel::Own);
        }
        let variable = std::env::var_os(EMBREE_VARIABLE).map(PathBuf::from);
        match load_embree(self.embree.clone().flatten().or(variable)) {
            Ok(kernel) => Ok(kernel),
            Err(why) if self.requires_embree() => Err(Failure::failed(why)),
            Err(why) => {
                notes.push(format!("built-in kernel instead of Embree: {why}"));
                Ok(Kernel::Own)
            }
        }
    }

    fn hemicube(&self, notes: &mut Vec<String>) -> Result<Hemicube, Failure> {
        let default = Hemicube::default();
        let device = match self.gpu.unwrap_or(GpuName::Auto) {
            GpuName::Off => HemicubeBackend::Processor,
            GpuName::Auto => fastest_device(notes),
            name => HemicubeBackend::Device(open_card(name).map_err(Failure::failed)?.0),
        };
        Ok(Hemicube {
            resolution: self.resolution.unwrap_or(default.resolution),
            points: self.patch_points.unwrap_or(default.points),
            device,
        })
    }
}

/// A hardware graphics card if there is one; software drivers are slower than our own rasterizer.
fn fastest_device(notes: &mut Vec<String>) -> HemicubeBackend {
    match open_card(GpuName::Auto) {
        Ok((card, false)) => return HemicubeBackend::Device(card),
        Ok((card, true)) => notes.push(format!(
            "hemicubes are rendered on the processor: {} is a software driver (select it with --gpu vulkan or gl)",
            card.name()
        )),
        Err(why) => notes.push(format!("hemicubes are rendered on the processor: {why}")),
    }
    HemicubeBackend::Processor
}

/// A card, and whether its driver is software.
#[cfg(feature = "gpu")]
fn open_card(name: GpuName) -> Result<(Arc<dyn Device>, bool), String> {
    let backend = match name {
        GpuName::Vulkan => azulejo_gpu::Backend::Vulkan,
        GpuName::Gl => azulejo_gpu::Backend::Gl,
        GpuName::Auto | GpuName::Off => azulejo_gpu::Backend::Auto,
    };
    let card = azulejo_gpu::Card::open(backend).map_err(|e| e.to_string())?;
    let is_software = card.is_software();
    Ok((Arc::new(card), is_software))
}

#[cfg(not(feature = "gpu"))]
fn open_card(_: GpuName) -> Result<(Arc<dyn Device>, bool), String> {
    let how = "cargo build --release --features gpu";
    Err(format!(
        "this azulejo was built without support for graphics cards: build it with \"{how}\""
    ))
}

fn load_embree(path: Option<PathBuf>) -> Result<Kernel, String> {
    let loaded = azulejo_trace::embree::Embree::load(path.as_deref());
    let hint = |e| format!("{e} (--embree=PATH, or {EMBREE_VARIABLE})");
    loaded.map(Kernel::Embree).map_err(hint)
}

/// Name of the graphics card that `--gpu auto` would use.
pub fn fastest_card_name() -> Result<String, String> {
    open_card(GpuName::Auto).map(|(card, _)| card.name())
}

/// The version of Embree that would be loaded without `--embree`.
pub fn embree_version() -> Result<String, String> {
    let path = std::env::var_os(EMBREE_VARIABLE).map(PathBuf::from);
    let loaded = azulejo_trace::embree::Embree::load(path.as_deref());
    loaded.map(|e| e.version()).map_err(|e| e.to_string())
}

impl PreparedEngine {
    /// Deviations from what was requested.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// A tracer of the scene, with the engine's kernel.
    pub fn tracer(&self, scene: &Scene) -> Result<Tracer, Failure> {
        let tracer = Tracer::with_kernel(scene, &self.kernel);
        if self.requires_embree && tracer.kernel() == Kernel::Own {
            return Err(Failure::failed("Embree ran out of memory"));
        }
        Ok(tracer)
    }

    /// Adds the engine that was used, its device, and why.
    pub fn describe(&self, ran: &EngineUsed, report: &mut Report) {
        let words = match ran.device.as_str() {
            "" => ran.name.clone(),
            device => format!("{} ({device})", ran.name),
        };
        report.fact("engine", ran.name.clone(), "engine", words);
        report.value("device", ran.device.clone());
        let notes: Vec<String> = self.notes.iter().chain(&ran.notes).cloned().collect();
        for note in &notes {
            report.line("", note.clone());
        }
        report.value("engine_notes", notes);
    }
}
