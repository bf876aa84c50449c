//! The command line from outside, and the rules of the house.

mod arrows;
mod bad_input;
mod brdf;
mod circles;
mod commands;
mod engines;
mod exact;
mod experiment;
mod files;
mod glossy;
mod lettering;
mod reading;
mod rtrace;
mod support;
#[path = "../../../azulejo-formats/tests/it/tiny_font.rs"]
mod tiny_font;
mod view3d;
mod workbench;

#[cfg(unix)]
mod form_factors;
#[cfg(unix)]
mod interrupt;
