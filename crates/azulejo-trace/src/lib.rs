//! What does a point see: ray tracing kernel over a scene.

pub mod lambert;
mod assemble;
mod build;
mod bvh;
mod kernel;
mod primitive;
mod progress;
mod ray;
mod simd;
mod tracer;
mod triangle;
pub mod sampling;

pub use progress::{Cancelled, Progress};
pub use ray::{Hit, Item, KernelHit, KernelRay};
pub use tracer::{Instance, Tracer};
