//! Visibility: ray queries, sampling and gathering of light.
//!
//! [`Tracer`] finds the first surface that a ray hits, or whether it hits any, for single rays and
//! batches. It is built from a scene once, holds a copy of the data that it needs and is immutable.
//! Its kernel tests eight boxes and four triangles at a time, in `f32` around the scene's centre,
//! and [`Tracer::resolve`] computes a hit again in `f64`. Exact shapes (prisms, patches and the
//! results of set operations on solids) are intersected in `f64` throughout.
//!
//! The other modules, each of which uses those before it: [`sampling`] (scrambled Sobol points and
//! the directions they map to), [`lambert`] (the irradiance at a point due to a polygon, exactly),
//! [`lights`] (sampling of light sources), [`follow`] (paths through mirrors and glass), and
//! [`Gatherer`] (irradiance at points, for both passes). Embree can trace the triangles instead
//! ([`Kernel`]). [`item_buffer`] solves visibility by rasterization: it finds the
//! patches that are visible through the pixels of a hemicube. [`Progress`] reports the progress of
//! long work, pauses and stops it; a [`Run`] keeps its finished blocks, and divides it.
//!
//! ```
//! use azulejo_scene::{math::Ray, synthetic::cube_room};
//! use azulejo_trace::Tracer;
//! use glam::DVec3;
//!
//! let tracer = Tracer::new(&cube_room());
//! let hit = tracer.hit(&Ray::new(DVec3::splat(0.5), DVec3::X)).unwrap();
//! assert!((hit.t - 0.5).abs() < 1e-6 && hit.entering);
//! ```

mod back_to_back;
mod exact;
pub mod follow;
mod frame;
mod gather;
mod hit;
pub mod interaction;
pub mod item_buffer;
mod kernel;
pub mod lambert;
pub mod lights;
pub mod medium;
mod progress;
pub mod run;
pub mod sampling;
mod surfaces;
pub mod time;
mod tracer;

pub use gather::{
    DiffuseHit, DiffuseLight, DirectLight, DirectionTables, EmitterForm, GatherOptions,
    GatherPoint, Gathered, Gatherer, Harmonics, IncidentDomain, NextEvent, OutgoingRadiosity,
    RAYS_PER_FORMULA, REPLICATES, SplitIrradiance, SurfaceSamples, Termination, sequence_gain,
};
pub use hit::{Hit, Item};
pub use kernel::embree;
pub use kernel::{Kernel, KernelHit, KernelRay};
pub use progress::{Cancelled, Measure, Measured, Progress};
pub use run::{Blocks, Run, RunRole, RunStage};
pub use surfaces::{MeshTriangles, Surfaces};
pub use tracer::{PeriodError, Tracer};
