//! What does a point see: ray tracing kernel over a scene.

pub mod follow;
mod gather;
pub mod lambert;
mod assemble;
mod build;
mod bvh;
mod kernel;
mod placed;
mod portable;
mod prepared;
mod primitive;
mod progress;
mod ray;
mod simd;
mod surfaces;
#[cfg(test)]
mod tests;
mod tracer;
mod triangle;
pub mod sampling;

pub use gather::{Arrival, DiffuseLight, DirectLight, DirectionTables, Glow, GatherOptions, GatherPoint, Gathered, Gatherer, REPLICATES};
pub use progress::{Cancelled, Progress};
pub use ray::{Hit, Item, KernelHit, KernelRay};
pub use surfaces::Surfaces;
pub use tracer::{Instance, Tracer};
