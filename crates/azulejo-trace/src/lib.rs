//! What does a point see: ray tracing kernel over a scene.

pub mod lambert;
mod progress;
pub mod sampling;

pub use progress::{Cancelled, Progress};
