//! What does a point see: ray tracing kernel over a scene.

mod assemble;
mod build;
mod bvh;
pub mod follow;
mod gather;
mod kernel;
pub mod lambert;
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
    Arrival, DiffuseLight, DirectLight, DirectionTables, GatherOptions, GatherPoint, Gathered,
    Gatherer, Glow, REPLICATES,
};
pub use progress::{Cancelled, Progress};
pub use ray::{Hit, Item, KernelHit, KernelRay};
pub use surfaces::Surfaces;
pub use tracer::{Instance, Tracer};
