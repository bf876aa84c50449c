//! Integration tests of form factors, one module per subject.

// Tests report what they skip and what they measured.
#![allow(clippy::print_stderr)]

mod analytic_engine;
mod analytic_pairs;
// The cases of `azulejo validate`; of their reader, tests need but a part.
#[allow(dead_code)]
#[path = "../../../azulejo-cli/src/known/factors/mod.rs"]
mod cases;
mod compressed_factors;
mod engines;
mod form_factor_matrix;
mod form_factor_points;
mod form_factor_row;
mod form_factors;
mod group_plans;
mod hemicube_errors;
mod hemicubes;
mod invariants;
mod known_values;
mod matrix_operations;
mod polygons;
mod posed_cases;
mod poses;
mod rays;
mod rounded_worlds;
mod scenes;
mod stated_errors;
