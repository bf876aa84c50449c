//! azulejo: global illumination for the models people already have.
//!
//! Reads a model, computes the irradiance on its vertices, and renders images. This crate is a thin
//! façade that puts the libraries under one name. The command line is `azulejo-cli`.
//!
//! | module | purpose |
//! |---|---|
//! | [`scene`] | geometry, materials, lights, cameras and images, as plain data |
//! | [`formats`] | readers and writers of models and images |
//! | [`trace`] | ray tracing and item buffers: what a point sees |
//! | [`factors`] | form factors between the patches of a scene |
//! | [`radiosity`] | first pass: from a scene to the irradiance on its vertices |
//! | [`render`] | second pass: from a scene to an image |
//! | [`mod@bake`], [`lightmap`] | third pass: from a scene to the irradiance in the texels of a lightmap |
//! | [`models`] | model files: reading, merging, atomic writing |
//! | [`surroundings`] | light from outside: suns, skies, pictures, a studio |
//! | [`luminaire`] | luminaires of photometric files at their places |
//! | [`recipe`] | files of rules that are applied to a model each time it is read |
//! | [`output`] | files written atomically |
//! | [`page`] | web pages that show a scene with its light |
//! | [`files`], [`machine`] | messages for errors of the file system; memory of the machine |
//! | [`fonts`] | the fonts of the machine, for text inside files |
//! | [`spelling`] | messages for unknown names, with the most similar known one |
//! | [`typeface`] | the embedded typeface |
//!
//! The two passes do not depend on each other: they share data, the irradiance on the vertices.
//! `examples/journey.rs` follows one vertex through both in seven lines.
//!
//! Embree, where it is installed, is loaded at run time as another ray tracing kernel.
//!
//! The feature `fonts`, on by default, reads TrueType, OpenType and Type 1. The feature `gpu` adds
//! the module `gpu`: item buffers on graphics cards.

pub mod files;
#[cfg(feature = "fonts")]
pub mod fonts;
pub mod lightmap;
pub mod luminaire;
pub mod machine;
pub mod models;
pub mod output;
pub mod page;
pub mod periods;
pub mod probe_grid;
pub mod recipe;
pub mod spelling;
pub mod surroundings;
pub mod typeface;

pub use azulejo_bake as bake;
pub use azulejo_factors as factors;
pub use azulejo_formats as formats;
#[cfg(feature = "gpu")]
pub use azulejo_gpu as gpu;
pub use azulejo_radiosity as radiosity;
pub use azulejo_render as render;
pub use azulejo_scene as scene;
pub use azulejo_trace as trace;

/// The pages on extending azulejo, whose examples are tests of this crate.
#[cfg(doctest)]
mod how_to_add {
    #[doc = include_str!("../../../docs/how-to-add/a-format.md")]
    struct AFormat;
    #[doc = include_str!("../../../docs/how-to-add/an-engine.md")]
    struct AnEngine;
}
