//! The window's parts. Each shows state and returns commands.
//!
//! [`Workbench`] is all of them around one [`App`](crate::app::App): what eframe draws, what tests click, what
//! scripts drive.

pub mod actions;
mod all_files;
pub mod brdf;
pub mod desk;
pub mod dialogs;
mod focus;
mod inputs;
pub mod inspector;
pub mod light;
pub mod looks;
mod material;
pub mod menu;
pub mod messages;
pub mod paint;
mod prism;
mod stock;
mod together;
pub mod tree;
pub mod viewport;
mod workbench;

pub use viewport::Viewport;
pub use workbench::{PanelTab, Rescued, Workbench};
