//! The window's parts. Each shows state and returns commands.

pub mod brdf;
