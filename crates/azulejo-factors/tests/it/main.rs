//! Integration tests of form factors, one module per subject.

// Tests report what they skip and what they measured.
#![allow(clippy::print_stderr)]

mod analytic_engine;
mod analytic_pairs;
mod compressed_factors;
mod engines;
mod form_factor_matrix;
mod form_factor_points;
mod form_factor_row;
mod form_factors;
mod group_plans;
mod hemicube_errors;
mod hemicubes;
mod matrix_operations;
mod polygons;
mod poses;
mod rays;
mod rounded_worlds;
mod scenes;
