//! Who computes form factors: as it is typed, as the libraries take it, and what is said of it.

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

/// Where Embree's library is, if `--embree` does not say.
const EMBREE_VARIABLE: &str = "AZULEJO_EMBREE";

/// Engines, and Embree, which is another kernel for the same rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineName {
    /// Formulas where surfaces are flat and few enough to pair, else rays; says which, and why
    Auto,
    /// Rays from all over each patch, through mirrors and glass
    Rays,
    /// The same rays, traced by Embree
    Embree,
    /// Pictures from each patch, drawn by the processor or a graphics card
    Hemicube,
    /// Pictures for what is seen straight, rays for what mirrors and glass show
    Hybrid,
    /// Formulas for pairs of polygons, with exact shadows
    Analytic,
}

/// Graphics interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GpuName {
    /// A graphics card if there is one, else the processor
    Auto,
    /// The processor
    Off,
    /// By Vulkan
    Vulkan,
    /// By OpenGL
    Gl,
}

/// Who computes form factors.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Engine")]
pub struct EngineArgs {
    /// Who computes the form factors between patches
    #[arg(long, value_name = "ENGINE", value_enum, default_value_t = EngineName::Auto)]
    pub engine: EngineName,
    /// Who draws the hemicubes of --engine hemicube and hybrid [default: auto]
    #[arg(long, value_name = "WHO", value_enum)]
    pub gpu: Option<GpuName>,
    /// Pixels along the side of a hemicube, an even number [default: 128]
    #[arg(long, value_name = "N", value_parser = values::resolution)]
    pub resolution: Option<u32>,
    /// Points of each patch from which a hemicube is drawn, made a multiple of four [default: 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub patch_points: Option<u32>,
    /// Embree's library, for --engine embree and auto [default: AZULEJO_EMBREE, or where the system
    /// finds it]
    #[arg(long, value_name = "PATH", value_hint = ValueHint::FilePath)]
    pub embree: Option<PathBuf>,
}

/// What was typed, made ready.
pub struct PreparedEngine {
    /// For the library's options.
    pub engine: Engine,
    /// Whether nothing but this kernel will do.
    must_be_foreign: bool,
    kernel: Kernel,
    notes: Vec<String>,
}

impl EngineArgs {
    /// Loads what the engine needs, or says what is missing and how to get it.
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
        };
        Ok(PreparedEngine {
            engine,
            must_be_foreign: self.engine == EngineName::Embree,
            kernel,
            notes,
        })
    }

    /// Refuses options that mean nothing to the engine.
    pub fn check(&self) -> Result<(), Failure> {
        let misuse = |option: &str, engines: &str| {
            let message = format_args!("{option} has a meaning for --engine {engines} only");
            Err(Failure::misuse(message))
        };
        let draws = matches!(self.engine, EngineName::Hemicube | EngineName::Hybrid);
        match self {
            EngineArgs {
                resolution: Some(_),
                ..
            } if !draws => misuse("--resolution", "hemicube and hybrid"),
            EngineArgs {
                patch_points: Some(_),
                ..
            } if !draws => misuse("--patch-points", "hemicube and hybrid"),
            EngineArgs { gpu: Some(_), .. } if !draws => misuse("--gpu", "hemicube and hybrid"),
            EngineArgs {
                embree: Some(_), ..
            } if !matches!(self.engine, EngineName::Embree | EngineName::Auto) => {
                misuse("--embree", "embree and auto")
            }
            _ => Ok(()),
        }
    }

    /// Embree where it is asked for; a path alone is a wish that may fail.
    fn kernel(&self, notes: &mut Vec<String>) -> Result<Kernel, Failure> {
        let is_asked_for = self.engine == EngineName::Embree;
        if !is_asked_for && self.embree.is_none() {
            return Ok(Kernel::Own);
        }
        let variable = std::env::var_os(EMBREE_VARIABLE).map(PathBuf::from);
        match load_embree(self.embree.clone().or(variable)) {
            Ok(kernel) => Ok(kernel),
            Err(why) if is_asked_for => Err(Failure::failed(why)),
            Err(why) => {
                notes.push(format!("own kernel instead of Embree: {why}"));
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

/// A real card if there is one; software drivers are slower than the processor by itself.
fn fastest_device(notes: &mut Vec<String>) -> HemicubeBackend {
    match open_card(GpuName::Auto) {
        Ok((card, false)) => return HemicubeBackend::Device(card),
        Ok((card, true)) => notes.push(format!(
            "the processor draws, since {} is software too (--gpu vulkan or gl takes it)",
            card.name()
        )),
        Err(why) => notes.push(format!("the processor draws: {why}")),
    }
    HemicubeBackend::Processor
}

/// A card, and whether it is software.
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
        "this azulejo was built without graphics cards: build it with \"{how}\""
    ))
}

#[cfg(feature = "embree")]
fn load_embree(path: Option<PathBuf>) -> Result<Kernel, String> {
    let loaded = azulejo_trace::embree::Embree::load(path.as_deref());
    let hint = |e| format!("{e} (--embree PATH, or {EMBREE_VARIABLE})");
    loaded.map(Kernel::Embree).map_err(hint)
}

#[cfg(not(feature = "embree"))]
fn load_embree(_: Option<PathBuf>) -> Result<Kernel, String> {
    let how = "cargo build --release --features embree";
    Err(format!(
        "this azulejo was built without Embree: build it with \"{how}\""
    ))
}

/// The graphics card that `--gpu auto` would find.
pub fn card_name() -> Result<String, String> {
    open_card(GpuName::Auto).map(|(card, _)| card.name())
}

/// The version of the Embree that would be loaded without `--embree`.
#[cfg(feature = "embree")]
pub fn embree_version() -> Result<String, String> {
    let path = std::env::var_os(EMBREE_VARIABLE).map(PathBuf::from);
    let loaded = azulejo_trace::embree::Embree::load(path.as_deref());
    loaded.map(|e| e.version()).map_err(|e| e.to_string())
}

/// Why there is no Embree.
#[cfg(not(feature = "embree"))]
pub fn embree_version() -> Result<String, String> {
    load_embree(None).map(|_| String::new())
}

impl PreparedEngine {
    /// What was not done as asked.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The scene made ready for rays.
    pub fn tracer(&self, scene: &Scene) -> Result<Tracer, Failure> {
        let tracer = Tracer::with_kernel(scene, &self.kernel);
        if self.must_be_foreign && tracer.kernel() == Kernel::Own {
            return Err(Failure::failed("Embree has not enough memory"));
        }
        Ok(tracer)
    }

    /// Says which engine ran, on what, and why.
    pub fn describe(&self, ran: &EngineUsed, report: &mut Report) {
        let words = match ran.device.as_str() {
            "" => ran.name.clone(),
            device => format!("{}, by {device}", ran.name),
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
