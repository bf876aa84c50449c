//! Readers and writers on whole files.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod large_coordinates;
mod meshes;
mod mgf;
mod mgf_instances;
mod obj;
mod openflight;
mod sff;
mod solids;
mod solvers;
mod table_1;
#[cfg(feature = "fonts")]
mod texts;
mod tiny_font;
#[cfg(feature = "fonts")]
mod typeface;
mod writers;
