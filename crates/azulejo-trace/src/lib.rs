//! What does a point see: ray tracing kernel over a scene.

mod progress;

pub use progress::{Cancelled, Progress};
