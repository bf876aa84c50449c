//! The workbench: see a model, give it light, watch the light settle, save it.
//!
//! A window on everything below it. It has no maths of its own: it plots
//! [`brdf`](azulejo::scene::brdf) and shows what the two passes return.

pub mod gpu;
pub mod ui;
pub mod words;
