//! Second pass: a scene that carries irradiance becomes an image.
//!
//! The first pass stores irradiance on the vertices. [`render`] shows it from a camera, through
//! mirrors, glass and glossy surfaces; [`radiance`] evaluates single rays. [`reference()`] renders
//! the same scene without a first pass, by brute force: both passes are tested against it.
//! [`tone_map`] maps the linear image to a display. The two passes share nothing but the data of
//! [`azulejo_scene::Scene`].
//!
//! Every result depends on scene, options and seed alone: the same bits for any number of
//! threads.

mod budget;
mod denoise;
mod diffuse_reflectance;
mod exposure;
mod film;
mod first_view;
mod integrator;
mod interpolate;
mod layers;
mod mattes;
mod measured;
mod options;
mod pass;
mod path_cost;
mod path_sampler;
mod reference;
mod render_scene;
mod room;
pub mod rtrace;
mod shading;
mod surface_maps;
mod tone;

pub use denoise::{DenoisedImage, denoise};
pub use diffuse_reflectance::DiffuseReflectance;
pub use exposure::{auto_exposure_of_surfaces, black_share_of_surfaces};
pub use first_view::first_view;
pub use layers::{NO_DEPTH, PictureLayers, picture_layers};
pub use mattes::{Matte, Mattes, mattes};
pub use measured::{MeasuredImage, relative_rmse};
pub use options::{FinalGather, SecondPass};
pub use pass::{
    NO_IRRADIANCE, radiance, render, render_irradiance, render_measured, render_with_errors,
    render_within,
};
pub use reference::{ReferencePass, reference, reference_radiance};
pub use room::Room;
pub use tone::{REINHARD_WHITE, Tone, auto_exposure, srgb_from_linear, tone_map};
