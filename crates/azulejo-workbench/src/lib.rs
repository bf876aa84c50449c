//! The workbench: view a model, light it, watch the solution converge, save it.
//!
//! A window on top of the other crates. It has no mathematics of its own: it plots
//! [`brdf`](azulejo::scene::brdf) and displays the results of the two passes.

pub mod app;
pub mod bake;
pub mod command;
pub mod document;
pub mod ending;
pub mod engine_comparison;
pub mod first_pass;
pub mod gpu;
mod history;
pub mod jobs;
pub mod lab;
mod library;
pub mod platform;
pub mod preferences;
mod projection;
pub mod recovery;
pub mod ui;
pub mod variants;
pub mod view;
pub mod words;

pub use ui::script;
