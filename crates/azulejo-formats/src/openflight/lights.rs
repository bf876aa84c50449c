//! Light sources.

use super::fields::Fields;
use super::palettes::PaletteLight;
use super::transform::Place;
use super::walk::{Source, Walker};
use azulejo_scene::{Light, LightKind};
use glam::DVec3;
use std::f64::consts::PI;

const ENABLED: u32 = 1 << 31;
const GLOBAL: u32 = 1 << 30;

impl Walker<'_> {
    /// Adds the light of a light source node.
    pub fn light(&mut self, source: Source, node: u32, place: &Place) {
        let record = source.document.node(node);
        let flags = record.u32(24).unwrap_or_default();
        let index = record.i32(16).unwrap_or(-1);
        let mut notes = super::warn::Notes::new(&mut self.warnings, source.document, node);
        if flags & ENABLED == 0 {
            return notes.add("light source that is turned off: left out");
        }
        let Some(entry) = source.palettes.lights.get(&index) else {
            return notes.add("light source that the palette lacks: left out");
        };
        let Some(kind) = kind(record, entry, place) else {
            return notes.add(
                "light source of unknown kind, without a place, or of what is no number: left out",
            );
        };
        if flags & GLOBAL == 0 {
            notes.add("light source for what is below it alone: lights all");
        }
        if entry.attenuation[1..] != [0.0, 0.0] && entry.kind != INFINITE {
            let message = "attenuation of a light source: not used, light falls with the square of the distance";
            notes.add(message);
        }
        if entry.kind == SPOT && entry.spot_exponent != 0.0 {
            notes.add("exponent of a spot light: fades from its axis to its edge instead");
        }
        let name = match self.path.as_str() {
            "" => entry.name.clone(),
            path => path.to_owned(),
        };
        self.scene.lights.push(Light { name, kind });
    }
}

const INFINITE: i32 = 0;
const LOCAL: i32 = 1;
const SPOT: i32 = 2;

/// The light of a node at its place in the world.
fn kind(record: Fields, entry: &PaletteLight, place: &Place) -> Option<LightKind> {
    let position = place.world.transform_point3(record.doubles(32)?);
    let aim = aim(record).and_then(|a| place.world.transform_vector3(a).try_normalize());
    let color = entry.diffuse.map(|c| c.max(0.0));
    let kind = match entry.kind {
        // As in OpenGL, a light that is infinitely far away is given by where it is, and a spot
        // by where it shines.
        INFINITE => LightKind::Directional {
            direction: -aim?,
            irradiance: color,
        },
        LOCAL => LightKind::Point {
            position,
            intensity: color,
        },
        SPOT => {
            let outer = entry.spot_cutoff.to_radians().clamp(0.0, PI);
            LightKind::Spot {
                position,
                direction: aim?,
                intensity: color,
                inner: if entry.spot_exponent == 0.0 {
                    outer
                } else {
                    0.0
                },
                outer,
            }
        }
        _ => return None,
    };
    (entry.kind == INFINITE || position.is_finite()).then_some(kind)
}

/// The direction that yaw and pitch of a node stand for: +y at zero, yaw turns it toward −x,
/// pitch toward +z.
fn aim(record: Fields) -> Option<DVec3> {
    let yaw = record.single(56)?.to_radians();
    let pitch = record.single(60)?.to_radians();
    let level = pitch.cos();
    Some(DVec3::new(
        -yaw.sin() * level,
        yaw.cos() * level,
        pitch.sin(),
    ))
}
