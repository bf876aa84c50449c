//! azulejo: global illumination for the models people already have.
//!
//! A model file goes in; lit vertices and a picture come out. This crate is a thin façade: it
//! puts the libraries under one name. The command line is `azulejo-cli`, built on this.
//!
//! | module | purpose |
//! |---|---|
//! | [`scene`] | what is there: geometry, materials, lights, cameras, images, as plain data |
//! | [`formats`] | bytes to scene and back, pictures to files |
//! | [`trace`] | what does a point see: rays against the scene |
//! | [`factors`] | form factors between the patches of a scene |
//! | [`radiosity`] | first pass: scene to irradiance on its vertices |
//! | [`render`] | second pass: scene to image |
//! | [`models`] | models as files: read, put together, written whole or not at all |
//! | [`output`] | any file, written whole or not at all |
//! | [`files`], [`machine`] | what the operating system says |
//!
//! The two passes do not know each other: they meet in data, the irradiance on the vertices.
//! `examples/journey.rs` follows one vertex through all of it in seven lines.
//!
//! The feature `embree` adds Embree as another kernel for rays, loaded at run time.
//!
//! The feature `fonts`, on by default, reads TrueType, OpenType and Type 1. The feature `gpu` adds
//! the module `gpu`: item buffers on graphics cards.

pub mod files;
pub mod machine;
pub mod models;
pub mod output;
pub mod typeface;

pub use azulejo_factors as factors;
pub use azulejo_formats as formats;
#[cfg(feature = "gpu")]
pub use azulejo_gpu as gpu;
pub use azulejo_radiosity as radiosity;
pub use azulejo_render as render;
pub use azulejo_scene as scene;
pub use azulejo_trace as trace;
