//! The command line from outside.

mod arrival;
mod bad_input;
mod bake;
mod brdf;
mod commands;
mod compressed;
mod directional;
mod docs_commands;
mod elsewhere;
mod engines;
mod exact;
mod exchange;
#[cfg(target_os = "linux")]
mod expansion;
mod experiment;
mod files;
mod grf;
mod grid;
mod lettering;
mod option_budgets;
mod options_page;
mod outputs;
mod outside;
mod pages;
mod poses;
mod reading;
mod recipe;
mod reference;
mod rtrace;
mod sides;
mod support;
#[path = "../../../azulejo-formats/tests/it/tiny_font.rs"]
mod tiny_font;
mod validate;
mod view3d;
mod viewers;
mod workbench;
mod year;

#[cfg(unix)]
mod form_factors;
#[cfg(unix)]
mod interrupt;
mod layers;
mod lightmap;
mod luminaires;
mod matrix_files;
#[cfg(unix)]
mod probe_grids;
mod ranks;
#[cfg(unix)]
mod shards;
