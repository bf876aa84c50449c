//! What does a point see?
//!
//! [`Tracer`] answers for one ray or for batches of them: the first surface met, or whether any
//! is. It is made from a scene once, holds a copy of what it needs and never changes; the kernel
//! below it works eight boxes and four triangles at a time, in `f32` around the scene's centre,
//! and [`Tracer::resolve`] gives a hit its digits back in `f64`. Exact shapes (prisms, patches and
//! what set operations make of solids) are met in `f64` throughout.
//!
//! On it stand, each on the one before: [`sampling`] (scrambled Sobol points and where they
//! lead), [`lambert`] (what a point receives from a polygon, exactly), [`lights`] (where
//! to look for lamps), [`follow`] (rays through mirrors and glass to all they see), and [`Gatherer`] (irradiance at points, for both passes).
//! Triangles may be left to Embree instead ([`Kernel`]; feature `embree`).
//! [`item_buffer`] asks the same of a raster: what a patch sees through the pixels of a hemicube.
//! [`Progress`] counts long work, measures it, pauses and stops it.
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

mod assemble;
mod build;
mod bvh;
#[cfg(feature = "embree")]
pub mod embree;
mod exact;
pub mod follow;
mod gather;
pub mod interaction;
pub mod item_buffer;
mod kernel;
mod kernels;
pub mod lambert;
pub mod lights;
mod placed;
mod portable;
mod prepared;
mod primitive;
mod progress;
mod ray;
pub mod sampling;
mod simd;
mod surfaces;
#[cfg(test)]
mod tests;
mod tracer;
mod triangle;

pub use gather::{
    DiffuseHit, DiffuseLight, DirectLight, DirectionTables, GatherOptions, GatherPoint, Gathered,
    Gatherer, NextEvent, OutgoingRadiosity, RAYS_PER_FORMULA, REPLICATES, SurfaceSamples,
};
pub use kernels::Kernel;
pub use progress::{Cancelled, Measure, Measured, Progress};
pub use ray::{Hit, Item, KernelHit, KernelRay};
pub use surfaces::{MeshTriangles, Surfaces};
pub use tracer::{Instance, Tracer};
