//! Glass as one path meets it.

use azulejo_scene::{Dielectric, Rgb, fresnel};
use glam::DVec3;

/// A dielectric boundary, or a pane, as one path meets it.
pub(crate) struct Boundary {
    split: fresnel::FresnelSplit,
    /// Scales the mirrored part.
    mirror: Rgb,
    /// Scales the part that passes.
    transmittance: Rgb,
}

impl Boundary {
    pub fn new(
        glass: &Dielectric,
        mirror: Rgb,
        direction: DVec3,
        facing: DVec3,
        entering: bool,
    ) -> Boundary {
        if glass.thin {
            return Boundary {
                split: fresnel::pane(direction, facing, glass.ior),
                mirror,
                transmittance: glass.transmittance,
            };
        }
        let eta = if entering { glass.ior } else { 1.0 / glass.ior };
        Boundary {
            split: fresnel::split(direction, facing, eta),
            mirror,
            // Refraction conserves L/n², so radiance from the far side arrives divided by η².
            transmittance: glass.transmittance / (eta * eta),
        }
    }

    /// Direction and share of the mirrored part.
    pub fn mirrored(&self) -> (DVec3, Rgb) {
        let split = &self.split;
        (split.reflected, self.mirror * split.reflectance)
    }

    /// Direction and share of the part that passes.
    pub fn passed(&self) -> Option<(DVec3, Rgb)> {
        let share = self.transmittance * (1.0 - self.split.reflectance);
        self.split.refracted.map(|direction| (direction, share))
    }

    /// One of the two by a `chance` in 0..1, mirrored with probability R, and the share that
    /// keeps the mean right.
    pub fn chosen(&self, chance: f64) -> (DVec3, Rgb) {
        match self.split.refracted {
            Some(direction) if chance >= self.split.reflectance => (direction, self.transmittance),
            _ => (self.split.reflected, self.mirror),
        }
    }
}
