//! Second pass: a scene that carries irradiance becomes a picture.
//!
//! The first pass leaves irradiance on the vertices; [`render`] looks at it from a camera,
//! through mirrors, glass and by way of glossy surfaces, and [`radiance`] along single rays.
//! [`reference()`] draws the same without a first pass, by brute force: what both are judged by.
//! [`tone_map`] makes the
//! linear picture fit for a display. The two passes know nothing of each other: they meet in the
//! data of [`azulejo_scene::Scene`].
//!
//! Every result depends on scene, options and seed alone: the same bits for any number of
//! threads.

mod draws;
mod film;
mod integrator;
mod interpolate;
mod pass;
mod reference;
pub mod rtrace;
mod scenery;
mod shading;
mod tone;

pub use pass::{SecondPass, radiance, render};
pub use reference::{Reference, ReferencePass, reference, reference_radiance, relative_rmse};
pub use tone::{REINHARD_WHITE, Tone, auto_exposure, srgb_from_linear, tone_map};
