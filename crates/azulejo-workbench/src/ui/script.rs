//! Scripted sessions: a list of steps, one per line.
//!
//! ```text
//! # A model, an area light, a material, a solution and a file.
//! size 1280 800
//! open cow.3ds
//! action Area light
//! select cow
//! material brdf ward_duer ks=0.3 kd=0.4 ax=0.1 ay=0.3
//! solve 5%
//! shading irradiance
//! screenshot lit.png
//! save lit.grf
//! ```
//!
//! A step that starts a job waits until it ends. A step that fails ends the script, and the command
//! with status 1. `docs/workbench/scripts.md` lists all steps.

mod bake;
mod fields;
mod light;
mod material;
mod parse;
mod play;
mod scene;
mod selected;
mod solver;
mod step;
#[cfg(test)]
mod tests;
mod view;

pub use parse::parse;
pub use play::ScriptPlayer;
pub use step::{ScriptStep, StepCommands};
