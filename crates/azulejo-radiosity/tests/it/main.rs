//! Integration tests of the first pass, one module per subject.

// Tests say what they skip and what they measured.
#![allow(clippy::print_stderr)]

mod agreement;
mod analytic_engine;
mod analytic_pairs;
mod bad_scenes;
mod determinism;
mod drawn_errors;
mod engines;
mod exact;
mod form_factor_matrix;
mod form_factor_row;
mod form_factors;
mod furnace;
mod glossy;
mod hemicubes;
mod lights;
mod matrix_operations;
mod mirrors;
mod polygons;
mod refinement;
mod rooms;
mod vertices;
mod watching;
