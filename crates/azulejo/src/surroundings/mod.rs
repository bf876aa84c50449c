//! Light from outside, made for a scene: suns and skies as bright as weather makes them, pictures
//! of the surroundings, and a studio for a model in which nothing shines.
//!
//! [`DaylightUnits`] measures suns and skies in the scene's unit of light; [`sun_light`] and
//! [`Environment::sky`](crate::scene::Environment::sky) make lights of them. [`WeatherFile`] has what weather gives. [`SurroundingPicture`]
//! is read from a file, and [`extract_sun`] takes a sun out of one. [`studio()`] is a scene to merge
//! with the model's; where that is a [`Room`], the lamp hangs in it.
//!
//! ```
//! use azulejo::scene::sky::direction_from;
//! use azulejo::surroundings::DaylightUnits;
//!
//! // The sun in the south at 35 degrees, in a scene whose light is in lux.
//! let sun = direction_from(180f64.to_radians(), 35f64.to_radians());
//! let units = DaylightUnits { photometric: true, solar: false };
//! let clear = units.cie_sky(12, Some(sun), None)?;
//! let beam = units.clear_sun(35f64.to_radians()) * sun.z;
//! assert!(beam > clear.diffuse_horizontal() && clear.diffuse_horizontal() > 5_000.0);
//! # Ok::<(), azulejo::surroundings::DaylightError>(())
//! ```

mod daylight;
mod extracted_sun;
mod ground;
mod picture;
mod studio;
mod weather;

pub use azulejo_render::Room;
pub use daylight::{DaylightError, DaylightUnits, GROUND_REFLECTANCE, sun_light};
pub use extracted_sun::{ExtractedSun, extract_sun};
pub use ground::modelled_ground;
pub use picture::{PictureFailure, SurroundingPicture};
pub use studio::{STUDIO_FLOOR, is_studio_part, limit_paint, studio};
pub use weather::{WeatherError, WeatherFile, WeatherRecord};
