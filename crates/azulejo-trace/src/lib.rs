//! What does a point see: ray tracing kernel over a scene.

mod progress;
pub mod sampling;

pub use progress::{Cancelled, Progress};
