//! Two-dimensional outlines: fonts and their encodings, typefaces, drawings.
//!
//! Their readers return a [`Figure`](azulejo_scene::Figure) or a [`Font`](azulejo_scene::Font)
//! rather than a scene.

mod clip;
pub(crate) mod drawing;
#[cfg(feature = "fonts")]
pub(crate) mod letters;
#[cfg(feature = "pdf")]
pub mod pdf;
pub(crate) mod pen;
pub mod ppe;
pub mod ppf;
mod stroke;
pub mod svg;
mod text_path;
#[cfg(feature = "fonts")]
pub mod typeface;

pub use drawing::{Drawing, Filled};
pub use text_path::{PathTooShort, TextPath};
