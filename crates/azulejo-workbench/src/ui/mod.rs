//! The window's parts. Each shows state and returns commands.

pub mod actions;
pub mod brdf;
pub mod desk;
pub mod inspector;
pub mod paint;
pub mod tree;
