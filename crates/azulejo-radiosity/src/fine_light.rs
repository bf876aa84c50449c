//! Light known at far more points than there are patches.
//!
//! A patch has one radiosity, so the edge of a shadow that runs through it is lost, and so is all that
//! changes near to a corner: most of the error of reading patches. Who has irradiance at many points of
//! the surfaces, such as the texels of a lightmap, gives it back: hits read the nearest of them.

use azulejo_trace::DiffuseHit;

/// Irradiance all over the surfaces, finer than patches.
pub trait IrradianceField: Sync {
    /// Irradiance at a hit, on the side where it is hit, W/m², and the distance, scene units, from nearer
    /// than which it is too coarse to be used; `None` where it is not known.
    fn irradiance(&self, at: &DiffuseHit) -> Option<([f32; 3], f32)>;
}
