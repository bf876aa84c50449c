//! Integration tests of the first pass, one module per subject.

// Tests report what they skip and what they measured.
#![allow(clippy::print_stderr)]

mod agreement;
mod analytic_engine;
mod bad_scenes;
mod deadlines;
mod determinism;
mod discretization;
mod exact;
mod furnace;
mod glossy;
mod hemicubes;
mod interpolation;
mod lights;
mod mirrors;
mod opacity;
mod outside;
mod panes;
mod particles;
mod previews;
mod refinement;
mod rooms;
#[path = "../../../azulejo-factors/tests/it/scenes.rs"]
mod scenes;
mod sides;
mod vertices;
