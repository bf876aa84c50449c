//! Conversion between RTRACE's lights and lights that follow the inverse-square law.

use super::document::SffView;
use azulejo_scene::rtrace::{RtraceLight, RtraceLightKind};
use azulejo_scene::{Light, LightKind, Material, Primitive, Rgb};
use glam::DVec3;
use std::f64::consts::PI;

/// A light without attenuation is taken as directional if it is farther than this multiple of the
/// distance from the eye to the target.
const FAR: f64 = 100.0;

/// The physical equivalent of a light.
pub(super) enum SffLight {
    /// Lights without area.
    Lights(Vec<LightKind>),
    /// An emitter with this radiance.
    Body(Primitive, Rgb),
}

/// The physical equivalent of an RTRACE light.
///
/// RTRACE's lights attenuate as g / (g + d/4), where g is the distance from the eye to the target,
/// or not at all. The physical light gives the same irradiance at the target, follows the
/// inverse-square law, and has area if RTRACE's has. `material` is the material of its emitter.
pub(super) fn physical(light: &RtraceLight, view: &SffView, material: u32) -> SffLight {
    let target_distance = view.eye.distance(view.target);
    let offset = view.target - light.position;
    let distance = offset.length().max(1e-3 * target_distance);
    let fade = target_distance / (target_distance + 0.25 * distance);
    let arriving = Rgb::from([0, 1, 2].map(|k| {
        let share = if light.fades[k] { fade } else { 1.0 };
        light.brightness[k] * share
    }));
    // RTRACE's reflection has no factor 1/π.
    let irradiance = arriving * PI;
    let intensity = irradiance * (distance * distance);
    let position = light.position;
    match light.kind {
        RtraceLightKind::Point if light.fades == [false; 3] && distance > FAR * target_distance => {
            let direction = offset / distance;
            SffLight::Lights(vec![LightKind::Directional {
                direction,
                irradiance,
                half_angle: 0.0,
            }])
        }
        RtraceLightKind::Point => SffLight::Lights(vec![LightKind::Point {
            position,
            intensity,
        }]),
        RtraceLightKind::Spot {
            direction,
            half_angle,
            factor,
        } => SffLight::Lights(vec![LightKind::Spot {
            position,
            direction,
            intensity,
            inner: full_angle(half_angle, factor),
            outer: half_angle,
        }]),
        RtraceLightKind::Extended { radius, .. } => {
            let body = Primitive::sphere(position, radius, material);
            SffLight::Body(body, intensity / (PI * radius * radius))
        }
        RtraceLightKind::Planar { edges, samples } => {
            let area = edges[0].cross(edges[1]).length();
            if area > 0.0 && area.is_normal() {
                let corner = position - 0.5 * (edges[0] + edges[1]);
                let body = Primitive::parallelogram(corner, edges[0], edges[1], material);
                return SffLight::Body(body, intensity / area);
            }
            let count = samples[0].max(1);
            let point = |k: u32| LightKind::Point {
                position: position + along(k, count) * edges[0],
                intensity: intensity / f64::from(count),
            };
            SffLight::Lights((0..count).map(point).collect())
        }
    }
}

/// The centre of the `k`-th of `count` equal intervals of −½..½.
fn along(k: u32, count: u32) -> f64 {
    (f64::from(k) + 0.5) / f64::from(count) - 0.5
}

/// The inner angle of a spotlight that has half of its intensity where RTRACE's has: where ((cos a
/// − cos A) / (1 − cos A))^(1/factor) = ½.
fn full_angle(half_angle: f64, factor: f64) -> f64 {
    let edge = half_angle.cos();
    let middle = 0.5f64.powf(factor);
    let full = edge + 2.0 * middle * (1.0 - edge);
    full.clamp(-1.0, 1.0).acos().min(half_angle)
}

/// A light as an RTRACE light without attenuation and with the same irradiance at the target;
/// `None` for ambient light and environments.
pub(super) fn rtrace_light(light: &LightKind, view: &SffView) -> Option<RtraceLight> {
    // RTRACE reflects without the factor 1/π. Near the target, a least distance keeps the brightness finite.
    let as_bright = |position: DVec3, intensity: Rgb| {
        let distance = position.distance(view.target);
        let distance = distance.max(1e-3 * view.eye.distance(view.target));
        intensity / (PI * distance * distance)
    };
    let (position, brightness, kind) = match light.without_web() {
        LightKind::Point {
            position,
            intensity,
        } => {
            let brightness = as_bright(position, intensity);
            (position, brightness, RtraceLightKind::Point)
        }
        LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        } => {
            let kind = RtraceLightKind::Spot {
                direction,
                half_angle: outer,
                factor: factor(inner, outer),
            };
            (position, as_bright(position, intensity), kind)
        }
        LightKind::Directional {
            direction,
            irradiance,
            ..
        } => {
            // A point at the edge of SFF's space shines in nearly the same direction everywhere.
            let position = view.target - DISTANT * direction;
            (position, irradiance / PI, RtraceLightKind::Point)
        }
        LightKind::Luminaire { .. } | LightKind::Ambient { .. } | LightKind::Environment(_) => {
            return None;
        }
    };
    // Without fading, light arrives at the target as bright as it starts.
    Some(RtraceLight {
        position,
        brightness: brightness.map(|b| b.min(BRIGHTEST)),
        fades: [false; 3],
        kind,
    })
}

/// The range of coordinates in SFF.
const DISTANT: f64 = 90_000.0;

/// The greatest brightness in SFF.
const BRIGHTEST: f64 = 300.0;

/// The factor of an RTRACE spotlight that has half of its intensity where this one has.
fn factor(inner: f64, outer: f64) -> f64 {
    let edge = outer.cos();
    let middle = 0.5 * (inner.cos() - edge) / (1.0 - edge);
    let factor = -middle.log2();
    if factor.is_finite() {
        factor.clamp(1.0, 300.0)
    } else {
        1.0
    }
}

/// A named light.
pub(super) fn named(number: usize, kind: LightKind) -> Light {
    Light {
        name: format!("light {number}"),
        kind,
    }
}

/// The material of a light's emitter.
pub(super) fn emitter_material(number: usize, radiance: Rgb) -> Material {
    Material {
        emits_back: true,
        ..Material::emitter(format!("light {number}"), radiance)
    }
}

/// Whether two directions are non-zero and not parallel.
pub(super) fn spans(direction: DVec3, up: DVec3) -> bool {
    direction
        .normalize_or_zero()
        .cross(up.normalize_or_zero())
        .length()
        > 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> SffView {
        SffView {
            eye: DVec3::new(0.0, 0.0, 4.0),
            target: DVec3::ZERO,
            ..SffView::default()
        }
    }

    fn light(position: DVec3, fades: bool, kind: RtraceLightKind) -> RtraceLight {
        RtraceLight {
            position,
            brightness: Rgb::grey(0.5),
            fades: [fades; 3],
            kind,
        }
    }

    /// Checks that the irradiance of the light at the target is RTRACE's times π.
    fn check(light: RtraceLight, expected: f64) {
        let irradiance = match physical(&light, &view(), 0) {
            SffLight::Lights(lights) => lights.iter().map(irradiance_at_look).sum(),
            SffLight::Body(body, radiance) => {
                let flat = match light.kind {
                    RtraceLightKind::Extended { radius, .. } => PI * radius * radius,
                    _ => body.area(),
                };
                radiance.g * flat / light.position.length_squared()
            }
        };
        let relative: f64 = irradiance / (PI * expected) - 1.0;
        assert!(relative.abs() < 1e-3, "{irradiance} instead of {expected}");
    }

    fn irradiance_at_look(light: &LightKind) -> f64 {
        let (LightKind::Point { position, .. } | LightKind::Spot { position, .. }) = *light else {
            let LightKind::Directional { irradiance, .. } = *light else {
                unreachable!("not made of these lights")
            };
            return irradiance.g;
        };
        let toward = -position.normalize();
        light.intensity_toward(toward).g / position.length_squared()
    }

    #[test]
    fn as_bright_where_one_looks() {
        let near = DVec3::new(0.0, 16.0, 0.0);
        let point = RtraceLightKind::Point;
        check(light(near, true, point), 0.25);
        check(light(near, false, point), 0.5);
        check(light(1e5 * DVec3::Y, false, point), 0.5);
        check(
            light(
                near,
                true,
                RtraceLightKind::Extended {
                    radius: 1.0,
                    samples: 4,
                },
            ),
            0.25,
        );
        let edges = [DVec3::X, DVec3::Z];
        let planar = RtraceLightKind::Planar {
            edges,
            samples: [4, 4],
        };
        check(light(near, true, planar), 0.25);
        let edges = [0.1 * DVec3::X, DVec3::ZERO];
        let linear = RtraceLightKind::Planar {
            edges,
            samples: [4, 0],
        };
        check(light(near, true, linear), 0.25);
        let spot = RtraceLightKind::Spot {
            direction: -DVec3::Y,
            half_angle: 0.5,
            factor: 2.0,
        };
        check(light(near, true, spot), 0.25);
    }

    #[test]
    fn spotlights_are_half_as_bright_at_the_same_angle() {
        for (half_angle, factor) in [(0.5f64, 1.0), (1.2, 3.0), (3.0, 1.0), (0.2, 5.0)] {
            let edge = half_angle.cos();
            let angle = (edge + 0.5f64.powf(factor) * (1.0 - edge)).acos();
            let spot = LightKind::Spot {
                position: DVec3::ZERO,
                direction: DVec3::Z,
                intensity: Rgb::WHITE,
                inner: full_angle(half_angle, factor),
                outer: half_angle,
            };
            let toward = DVec3::new(angle.sin(), 0.0, angle.cos());
            assert!((spot.intensity_toward(toward).g - 0.5).abs() < 1e-6);
        }
    }
}
