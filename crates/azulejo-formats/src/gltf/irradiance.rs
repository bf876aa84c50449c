//! Irradiance in vertex colours, and the extras that mark it.

use azulejo_scene::{Rgb, Scene, Shape};
use gltf_json::{Extras, Mesh};
use serde_json::{Value, json};

/// How a mesh stores its irradiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StoredIrradiance {
    /// The set of colours: `COLOR_0` or `COLOR_1`.
    pub set: u32,
    /// Irradiance of a colour of 1.
    pub scale: f64,
}

/// The description of irradiance in the extras of a mesh, or of a primitive: packers drop the former.
pub(super) fn of(mesh: &Mesh) -> Option<StoredIrradiance> {
    let of_primitives = mesh.primitives.iter().map(|p| &p.extras);
    std::iter::once(&mesh.extras)
        .chain(of_primitives)
        .find_map(described)
}

fn described(extras: &Extras) -> Option<StoredIrradiance> {
    let extras: Value = serde_json::from_str(extras.as_ref()?.get()).ok()?;
    let irradiance = extras.get("azulejo")?.get("irradiance")?;
    let stored = StoredIrradiance {
        set: match irradiance.get("attribute")?.as_str()? {
            "COLOR_0" => 0,
            "COLOR_1" => 1,
            _ => return None,
        },
        scale: irradiance.get("scale")?.as_f64()?,
    };
    (stored.scale > 0.0 && stored.scale.is_finite()).then_some(stored)
}

/// A common scale for all meshes of a scene, so that viewers show them equally bright: a power of
/// two, so that no number loses a digit, with no colour above 1, as glTF requires.
pub(super) fn scale(scene: &Scene) -> f64 {
    let lights = scene.objects.iter().map(|o| match &o.shape {
        Shape::Mesh(mesh) => mesh.irradiance.as_slice(),
        Shape::Instance(i) => i.light.as_ref().map_or(&[][..], |l| &l.irradiance),
        Shape::Primitive(p) => p.light.as_ref().map_or(&[][..], |l| &l.irradiance),
        Shape::Exact(e) => e.proxy.as_ref().map_or(&[][..], |proxy| &proxy.irradiance),
    });
    let most = lights
        .flatten()
        .map(|e: &Rgb| e.max_channel())
        .fold(0.0, f64::max);
    if most > 0.0 {
        // If the logarithm is rounded, twice the least sufficient power of two, or half of it, would
        // do as well, except that a colour must not exceed 1.
        most.log2().ceil().exp2().max(most)
    } else {
        1.0
    }
}

impl StoredIrradiance {
    /// The extras of a mesh that stores its irradiance in this way, and of its primitives.
    pub fn extras(&self, photometric: bool) -> Value {
        json!({
            "azulejo": {
                "irradiance": {
                    "attribute": format!("COLOR_{}", self.set),
                    "scale": self.scale,
                    "unit": if photometric { "lx" } else { "W/m²" },
                    "meaning": "irradiance = scale × attribute; radiance = diffuse × irradiance / π",
                }
            }
        })
    }
}
