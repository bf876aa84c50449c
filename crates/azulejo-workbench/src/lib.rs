//! The workbench: see a model, give it light, watch the light settle, save it.
//!
//! A window on everything below it. It has no maths of its own: it plots
//! [`brdf`](azulejo::scene::brdf) and shows what the two passes return.

pub mod app;
pub mod command;
pub mod document;
pub mod first_pass;
pub mod gpu;
pub mod history;
pub mod jobs;
pub mod preferences;
pub mod recovery;
pub mod script;
pub mod ui;
pub mod view;
pub mod words;
