//! Surfaces without roughness: `specular`, `fresnel_conductor`, `fresnel_dielectric`.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{KS, ModelInfo, PLAIN};
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;

pub(super) const SPECULAR: ModelInfo = ModelInfo {
    name: "specular",
    aliases: &["mirror"],
    title: "Mirror",
    paper: "",
    parameters: &[KS],
    examples: &["specular ks = 0.9"],
    make: |arguments| smooth(arguments.color("ks"), Fresnel::Constant(Rgb::WHITE)),
    ..PLAIN
};

pub(super) const CONDUCTOR: ModelInfo = ModelInfo {
    name: "fresnel_conductor",
    aliases: &["conductor"],
    title: "Smooth metal",
    paper: "A. Fresnel 1823; Hecht, Optics, section 4.8",
    parameters: &[],
    examples: &[
        "fresnel_conductor eta = (0.2, 0.42, 1.3) k = (3.1, 2.35, 1.8)",
        "fresnel_conductor f0 = (0.95, 0.64, 0.54) tint = 0.8",
    ],
    has_fresnel: true,
    make: fresnel,
    ..PLAIN
};

pub(super) const DIELECTRIC: ModelInfo = ModelInfo {
    name: "fresnel_dielectric",
    aliases: &["dielectric"],
    title: "Smooth varnish: what a dielectric's surface mirrors",
    examples: &[
        "fresnel_dielectric eta = 1.5",
        "fresnel_dielectric eta = 0.7",
    ],
    ..CONDUCTOR
};

fn fresnel(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    smooth(Rgb::WHITE, arguments.fresnel()?)
}

fn smooth(scale: Rgb, fresnel: Fresnel) -> Result<Vec<Lobe>, BrdfError> {
    Ok(vec![Lobe::Smooth(Smooth { scale, fresnel })])
}

/// Reflects all light in the specular direction.
#[derive(Clone, Debug)]
pub(super) struct Smooth {
    pub scale: Rgb,
    pub fresnel: Fresnel,
}

impl Reflect for Smooth {
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> Rgb {
        Rgb::BLACK
    }

    fn pdf(&self, _wo: DVec3, _wi: DVec3) -> f64 {
        0.0
    }

    fn sample(&self, wo: DVec3, _u: [f64; 3]) -> DVec3 {
        DVec3::new(-wo.x, -wo.y, wo.z)
    }

    fn mirror(&self, cos: f64) -> Rgb {
        self.scale * self.fresnel.at(cos)
    }

    fn spread(&self) -> Spread {
        Spread::Glossy(0.0)
    }
}
