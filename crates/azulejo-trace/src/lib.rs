//! What does a point see?
//!
//! [`Tracer`] answers for one ray or for batches of them: which surface a ray hits first, or
//! whether it hits any. It is built from a scene once, holds a copy of what it needs and never
//! changes. The kernel below it tests eight boxes and four triangles at a time, in `f32` around
//! the scene's centre, and [`Tracer::resolve`] computes a hit again in `f64`. Exact shapes (prisms,
//! patches and the results of set operations on solids) are intersected in `f64` throughout.
//!
//! Above it, each using those before: [`sampling`] (scrambled Sobol points and the directions they
//! map to), [`lambert`] (the irradiance at a point due to a polygon, exactly), [`lights`]
//! (sampling of light sources), [`follow`] (paths through mirrors and glass), and [`Gatherer`]
//! (irradiance at points, for both passes). Triangles may be left to Embree instead ([`Kernel`];
//! feature `embree`). [`item_buffer`] answers the same question by rasterising: what a patch sees
//! through the pixels of a hemicube. [`Progress`] counts long work, measures it, pauses and stops
//! it.
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
mod progress;
pub mod sampling;
mod surfaces;
mod tracer;

pub use gather::{
    Arrival, DiffuseLight, DirectLight, DirectionTables, GatherOptions, GatherPoint, Gathered,
    Gatherer, Glints, Glow, Places, RAYS_PER_FORMULA, REPLICATES,
};
pub use hit::{Hit, Item};
#[cfg(feature = "embree")]
pub use kernel::embree;
pub use kernel::{Kernel, KernelHit, KernelRay};
pub use progress::{Cancelled, Measure, Measured, Progress};
pub use surfaces::Surfaces;
pub use tracer::{Instance, Tracer};
