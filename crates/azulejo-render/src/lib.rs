//! Second pass: a scene that carries irradiance becomes a picture.
//!
//! The first pass leaves irradiance on the vertices; [`render`] looks at it from a camera,
//! through perfect mirrors and glass, and [`radiance`] along single rays. [`tone_map`] makes the
//! linear picture fit for a display. The two passes know nothing of each other: they meet in the
//! data of [`azulejo_scene::Scene`].
//!
//! Every result depends on scene, options and seed alone: the same bits for any number of
//! threads.

mod film;
mod integrator;
mod interpolate;
mod pass;
pub mod rtrace;
mod tone;

pub use pass::{SecondPass, radiance, render};
pub use tone::{REINHARD_WHITE, Tone, auto_exposure, srgb_from_linear, tone_map};
