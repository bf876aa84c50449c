//! The engines that compute form factors, and the report of which one ran.

use crate::rays::RayEstimator;
use azulejo_trace::Tracer;
use azulejo_trace::item_buffer::Device;
use std::sync::Arc;

/// A method of computing form factors. All estimate the same quantity, with its error.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Engine {
    /// Formulas or rays, depending on the patches and the requested error; [`EngineUsed::notes`]
    /// gives the choice and its reason.
    #[default]
    Auto,
    /// Rays from all over each patch, through mirrors and glass (Malley's method, Sobol points).
    Rays,
    /// Item buffers on hemicubes; flat mirrors are windows to reflected worlds.
    Hemicube(Hemicube),
    /// Item buffers for what is seen directly, rays from the pixels of specular surfaces.
    Hybrid(Hemicube),
    /// Closed forms for pairs of polygons, with exact shadows; rays for light without formulas.
    Analytic,
    /// Particles shot from the lights, for solving light alone: no form factors. Where rows are
    /// needed all the same, rays compute them.
    Particles,
}

impl Engine {
    /// The engine that takes this one's place for a scene, and why. Formulas and item buffers take
    /// surfaces as opaque through which light passes straight ([`Tracer::has_see_through`]), and see
    /// no copies of a scene that repeats itself ([`Tracer::repeated`]), so rays do their work there.
    pub fn for_tracer(self, tracer: &Tracer) -> (Engine, Option<String>) {
        let name = match self {
            Engine::Hemicube(_) => "hemicubes",
            Engine::Hybrid(_) => "hybrid hemicubes",
            Engine::Analytic => "formulas",
            Engine::Auto | Engine::Rays | Engine::Particles => return (self, None),
        };
        let why = if tracer.is_repeated() {
            format!("rays, because the model repeats itself, and {name} would see it once")
        } else if tracer.has_see_through() {
            format!(
                "rays, because light passes straight through surfaces, which {name} take as opaque"
            )
        } else {
            return (self, None);
        };
        (Engine::Rays, Some(why))
    }

    /// The same with another resolution of its hemicubes, if it has any.
    pub fn with_resolution(self, resolution: u32) -> Engine {
        let mut engine = self;
        if let Engine::Hemicube(options) | Engine::Hybrid(options) = &mut engine {
            options.resolution = resolution;
        }
        engine
    }

    /// Rays or pixels per row where `rays` are requested, as [`Estimator::rays`](crate::estimator::Estimator::rays) returns them.
    pub(crate) fn rays_per_row(&self, rays: u32) -> u32 {
        match self {
            Engine::Hemicube(options) | Engine::Hybrid(options) => options.pixels_per_row(),
            Engine::Auto | Engine::Rays | Engine::Analytic | Engine::Particles => {
                RayEstimator::rounded(rays)
            }
        }
    }
}

/// How hemicubes are rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Hemicube {
    /// Pixels along the side of the top face, even.
    pub resolution: u32,
    /// Hemicubes per patch: one, whose error is unknown, or more, rounded up to a multiple of four.
    pub points: u32,
    /// The renderer.
    pub device: HemicubeBackend,
}

impl Hemicube {
    /// The resolution that suffices for sums over groups ([`FormFactorOptions::groups`]): a thousand viewpoints of
    /// a group, each turned by another angle, make up for coarse pixels.
    ///
    /// [`FormFactorOptions::groups`]: crate::FormFactorOptions::groups
    pub const GROUP_RESOLUTION: u32 = 32;
}

impl Default for Hemicube {
    /// 128 pixels, from 16 points, on the processor.
    fn default() -> Hemicube {
        Hemicube {
            resolution: 128,
            points: 16,
            device: HemicubeBackend::Processor,
        }
    }
}

/// The renderer of item buffers.
#[derive(Clone, Debug, Default)]
pub enum HemicubeBackend {
    /// The processor, by software rasterization.
    #[default]
    Processor,
    /// Another device. The processor takes over if it fails, and the report mentions it.
    Device(Arc<dyn Device>),
}

impl PartialEq for HemicubeBackend {
    /// Devices are equal if they are the same object.
    fn eq(&self, other: &HemicubeBackend) -> bool {
        match (self, other) {
            (HemicubeBackend::Processor, HemicubeBackend::Processor) => true,
            (HemicubeBackend::Device(a), HemicubeBackend::Device(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// Which engine ran, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EngineUsed {
    /// The engine's name on the command line: `rays`, `hemicube`, `hybrid`, `analytic` or
    /// `particles`.
    pub name: String,
    /// The kernel or device that did the work.
    pub device: String,
    /// Why this engine was chosen, and deviations from what was requested; sentences without full
    /// stops.
    pub notes: Vec<String>,
}

impl EngineUsed {
    /// An engine on a kernel or device, without notes.
    pub fn new(name: &str, device: String) -> EngineUsed {
        EngineUsed {
            name: name.to_owned(),
            device,
            notes: Vec::new(),
        }
    }

    /// The same with the reason for an automatic choice as the first note.
    pub fn because(mut self, why: Option<String>) -> EngineUsed {
        self.notes.splice(0..0, why);
        self
    }
}
