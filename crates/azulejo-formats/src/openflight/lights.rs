//! Light sources.

use super::fields::RecordFields;
use super::palettes::{PaletteLight, Palettes};
use super::transform::InheritedState;
use super::walk::{FltWalker, NodeVisit};
use super::warn::RecordWarnings;
use crate::ReadError;
use azulejo_scene::{Light, LightKind};
use glam::DVec3;
use std::f64::consts::PI;

const ENABLED: u32 = 1 << 31;
const GLOBAL: u32 = 1 << 30;

impl FltWalker<'_> {
    /// Adds the light of a light source node.
    pub fn light(&mut self, visit: NodeVisit) -> Result<(), ReadError> {
        let record = visit.record();
        let mut notes = self.notes(visit);
        match entry_and_kind(record, visit.source.palettes, &visit.place) {
            Err(why) => notes.add(why),
            Ok((entry, kind)) => {
                note_losses(record, entry, &mut notes);
                let name = match self.full_name()? {
                    path if path.is_empty() => entry.name.clone(),
                    path => path,
                };
                self.scene.lights.push(Light { name, kind });
            }
        }
        Ok(())
    }
}

/// The palette entry of a light source node and its type, or why it is skipped.
fn entry_and_kind<'p>(
    record: RecordFields,
    palettes: &'p Palettes,
    place: &InheritedState,
) -> Result<(&'p PaletteLight, LightKind), &'static str> {
    if record.u32(24).unwrap_or_default() & ENABLED == 0 {
        return Err("light source that is disabled: skipped");
    }
    let index = record.i32(16).unwrap_or(-1);
    let entry = palettes.lights.get(&index);
    let entry = entry.ok_or("light source without a palette entry: skipped")?;
    let kind = kind(record, entry, place).ok_or(
        "light source of unknown type, without a position, or with invalid numbers: skipped",
    )?;
    Ok((entry, kind))
}

fn note_losses(record: RecordFields, entry: &PaletteLight, notes: &mut RecordWarnings) {
    if record.u32(24).unwrap_or_default() & GLOBAL == 0 {
        notes.add("light source limited to its descendants: lights the whole scene");
    }
    if entry.attenuation[1..] != [0.0, 0.0] && entry.kind != INFINITE {
        notes.add(
            "attenuation of a light source: ignored, light falls off with the square of the distance",
        );
    }
    if entry.kind == SPOT && entry.spot_exponent != 0.0 {
        notes.add(
            "exponent of a spot light: replaced by a smooth falloff from its axis to its edge",
        );
    }
}

const INFINITE: i32 = 0;
const LOCAL: i32 = 1;
const SPOT: i32 = 2;

/// The light of a node in world coordinates.
fn kind(record: RecordFields, entry: &PaletteLight, place: &InheritedState) -> Option<LightKind> {
    let position = place.world.transform_point3(record.doubles(32)?);
    let aim = aim(record).and_then(|a| place.world.transform_vector3(a).try_normalize());
    let color = entry.diffuse.map(|c| c.max(0.0));
    let kind = match entry.kind {
        // As in OpenGL, a directional light is defined by the position from which it shines, and a
        // spot by the direction in which it shines.
        INFINITE => LightKind::Directional {
            direction: -aim?,
            irradiance: color,
            half_angle: 0.0,
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

/// The direction given by a node's yaw and pitch: +y at zero; yaw rotates toward −x, pitch toward
/// +z.
fn aim(record: RecordFields) -> Option<DVec3> {
    let yaw = record.single(56)?.to_radians();
    let pitch = record.single(60)?.to_radians();
    let level = pitch.cos();
    Some(DVec3::new(
        -yaw.sin() * level,
        yaw.cos() * level,
        pitch.sin(),
    ))
}
