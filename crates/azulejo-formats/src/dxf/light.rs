//! LIGHT entities, which exist since release 2007.

use super::color::{Color, Paint};
use super::record::Record;
use azulejo_scene::{Light, LightKind, Rgb};
use glam::{DAffine3, DVec3};

/// The light of an entity in its block's coordinates, or the reason why there is none.
pub(super) fn light(record: &Record) -> Result<Light, &'static str> {
    if record.integer(290, 1) == 0 {
        return Err("that is off");
    }
    let color = match Color::with_codes(record, 63, 421) {
        Color::Own(Paint::Index(7)) | Color::ByLayer | Color::ByBlock => Rgb::WHITE,
        Color::Own(paint) => paint.linear(),
    };
    let intensity = color * record.real(40, 1.0).max(0.0);
    let position = record.point(10);
    let direction = (record.point(11) - position).try_normalize();
    let kind = match (record.integer(70, 0), direction) {
        (1, Some(direction)) => LightKind::Directional {
            direction,
            irradiance: intensity,
            half_angle: 0.0,
        },
        (2, _) => LightKind::Point {
            position,
            intensity,
        },
        (3, Some(direction)) => spot(record, position, direction, intensity),
        (1 | 3, None) => return Err("without a direction"),
        _ => return Err("of unknown type"),
    };
    Ok(Light {
        name: record.text(1).into_owned(),
        kind,
    })
}

/// Angles are full cone angles in degrees.
fn spot(record: &Record, position: DVec3, direction: DVec3, intensity: Rgb) -> LightKind {
    let half = |code, default| 0.5 * record.real(code, default).clamp(0.0, 360.0).to_radians();
    let outer = half(51, 50.0);
    LightKind::Spot {
        position,
        direction,
        intensity,
        inner: half(50, 45.0).min(outer),
        outer,
    }
}

/// A light of an inserted block; `None` if its position overflows. Its intensity
/// does not depend on the scale.
pub(super) fn transformed(light: &Light, map: &DAffine3) -> Option<Light> {
    let mut light = light.clone();
    // A direction that a flat block takes away stays.
    light.move_by(map);
    let is_anywhere = light.kind.position().is_none_or(DVec3::is_finite);
    is_anywhere.then_some(light)
}
