//! The parts of the window. Each displays state and issues commands.
//!
//! [`Workbench`] combines them around an [`App`](crate::app::App): it is drawn by eframe, operated by
//! tests and driven by scripts.

pub mod actions;
pub mod brdf;
mod color_temperature;
mod colors;
mod dialogs;
mod emitter;
mod focus;
mod group_transform;
mod help;
mod inputs;
mod inspector;
mod lab;
mod lamps;
mod light;
pub mod lightmap;
mod material;
mod material_actions;
mod material_library;
mod menu;
mod messages;
mod panel_context;
mod polar;
pub mod script;
mod surroundings;
mod tree;
mod view_tab;
mod viewport;
mod workbench;

pub(crate) use material_library::giving;
pub use viewport::{DeviceLost, Viewport};
pub use workbench::{PanelTab, Rescued, Workbench};
