//! Light with its error.

use azulejo_scene::Rgb;

/// Irradiance with its standard error, W/m² (lx in photometric scenes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelLight {
    /// The value.
    pub irradiance: Rgb,
    /// Its standard error.
    pub standard_error: Rgb,
}
