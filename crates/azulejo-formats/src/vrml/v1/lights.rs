//! Lights without area, and cameras.

use super::node::V1Node;
use super::state::rotation;
use azulejo_scene::{Camera, LightKind, Rgb};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// A light in world coordinates: colour × intensity is taken as W/sr, for a directional light as
/// W/m². `None` if its position or direction is not finite.
pub(super) fn light(node: &V1Node, world_from_node: &DAffine3) -> Option<LightKind> {
    use super::node::V1NodeKind;
    let color = node.colors("color").and_then(|c| c.first().copied());
    let light = color.unwrap_or(Rgb::WHITE) * node.number("intensity", 1.0);
    let light = light.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
    let position = world_from_node.transform_point3(node.vector("location", DVec3::Z));
    let direction = node.vector("direction", DVec3::NEG_Z);
    let direction = (world_from_node.matrix3 * direction).try_normalize();
    match node.kind {
        V1NodeKind::DirectionalLight => Some(LightKind::Directional {
            direction: direction?,
            irradiance: light,
            half_angle: 0.0,
        }),
        _ if !position.is_finite() => None,
        V1NodeKind::SpotLight => {
            let cut_off = node.number("cutOffAngle", FRAC_PI_4).clamp(0.0, PI);
            let drop_off = node.number("dropOffRate", 0.0);
            let (inner, outer) = cone(cut_off, drop_off);
            Some(LightKind::Spot {
                position,
                direction: direction?,
                intensity: light,
                inner,
                outer,
            })
        }
        _ => Some(LightKind::Point {
            position,
            intensity: light,
        }),
    }
}

/// Half angles of full and of no intensity.
///
/// Browsers let the intensity fall off with the power 128 `drop_off` of the cosine. The spot light
/// of azulejo has half of the intensity at the same angle, and none beyond the same edge.
fn cone(cut_off: f64, drop_off: f64) -> (f64, f64) {
    let exponent = 128.0 * drop_off.clamp(0.0, 1.0);
    if exponent == 0.0 {
        return (cut_off, cut_off);
    }
    // The intensity is one half where the cosine is the mean of the cosines of the two angles.
    let half = 0.5f64.powf(1.0 / exponent);
    let inner = 2.0 * half - cut_off.cos();
    if inner <= 1.0 {
        let inner = inner.max(-1.0).acos();
        (inner.min(cut_off), cut_off)
    } else {
        (0.0, (2.0 * half - 1.0).clamp(-1.0, 1.0).acos().min(cut_off))
    }
}

/// A camera in world coordinates, without its name; `None` if its view is degenerate.
pub(super) fn camera(node: &V1Node, world_from_node: &DAffine3) -> Option<Camera> {
    let turn = rotation(node.exactly("orientation"));
    let forward = (world_from_node.matrix3 * (turn * DVec3::NEG_Z)).try_normalize()?;
    let up = (world_from_node.matrix3 * (turn * DVec3::Y)).try_normalize()?;
    let eye = world_from_node.transform_point3(node.vector("position", DVec3::Z));
    let distance = node.number("focalDistance", 5.0);
    let distance = if distance > 0.0 { distance } else { 5.0 };
    let camera = Camera {
        name: String::new(),
        eye,
        target: eye + distance * forward,
        up,
        vertical_fov: node.number("heightAngle", FRAC_PI_4),
        size: None,
    };
    let (right, up, forward) = camera.axes();
    let sees = [camera.eye, right, up, forward]
        .iter()
        .all(|v| v.is_finite());
    (sees && camera.vertical_fov > 0.0 && camera.vertical_fov < PI).then_some(camera)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_light_is_where_browsers_have_it() {
        let check = |cut_off: f64, drop_off: f64| {
            let (inner, outer) = cone(cut_off, drop_off);
            assert!(0.0 <= inner && inner <= outer && outer <= cut_off);
            let spot = LightKind::Spot {
                position: DVec3::ZERO,
                direction: DVec3::Z,
                intensity: Rgb::WHITE,
                inner,
                outer,
            };
            let cos = 0.5f64.powf(1.0 / (128.0 * drop_off));
            let half = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            assert!(
                (spot.intensity_toward(half).r - 0.5).abs() < 1e-6,
                "{cut_off} {drop_off}"
            );
        };
        check(FRAC_PI_4, 0.1);
        check(FRAC_PI_4, 1.0);
        check(1.5, 0.02);
        assert_eq!(cone(1.0, 0.0), (1.0, 1.0));
    }
}
