//! Lights without area: point, spot and directional lights, luminaires, and their mirror images.

use crate::Surfaces;
use crate::lambert::mirror_point;
use azulejo_scene::math::reflect;
use azulejo_scene::{LightKind, Rgb};
use glam::{DMat3, DVec3};

/// Where a shadow ray from `p` to a light without area ends, and the irradiance of a surface of
/// normal `n` there if nothing stands between, W/m²; `None` if the light is below the horizon.
pub(crate) fn unoccluded(
    light: &LightKind,
    p: DVec3,
    n: DVec3,
    surfaces: &Surfaces,
) -> Option<(DVec3, Rgb)> {
    match *light {
        LightKind::Point { position, .. }
        | LightKind::Spot { position, .. }
        | LightKind::Luminaire { position, .. } => {
            let d = position - p;
            let r2 = d.length_squared();
            let cos = d.dot(n) / r2.sqrt();
            (cos > 0.0).then(|| {
                (
                    position,
                    light.intensity_toward(-d / r2.sqrt()) * (cos / r2),
                )
            })
        }
        LightKind::Directional {
            direction,
            irradiance,
            ..
        } => {
            let cos = -direction.dot(n);
            (cos > 0.0).then(|| (beyond(surfaces, p, -direction), irradiance * cos))
        }
        LightKind::Ambient { .. } | LightKind::Environment(_) => None,
    }
}

/// [`unoccluded`] for the mirror image of a light in the plane through `plane` with unit `normal`;
/// the irradiance leaves out the mirror's loss.
pub(crate) fn unoccluded_image(
    light: &LightKind,
    (p, n): (DVec3, DVec3),
    (plane, normal): (DVec3, DVec3),
    surfaces: &Surfaces,
) -> Option<(DVec3, Rgb)> {
    let flip = |d: DVec3| reflect(d, normal);
    let image = match *light {
        LightKind::Point {
            position,
            intensity,
        } => LightKind::Point {
            position: mirror_point(position, plane, normal),
            intensity,
        },
        LightKind::Spot {
            position,
            direction,
            intensity,
            inner,
            outer,
        } => LightKind::Spot {
            position: mirror_point(position, plane, normal),
            direction: flip(direction),
            intensity,
            inner,
            outer,
        },
        LightKind::Luminaire {
            position,
            world_from_web,
            scale,
            ref web,
        } => LightKind::Luminaire {
            position: mirror_point(position, plane, normal),
            world_from_web: DMat3::from_cols(
                flip(world_from_web.x_axis),
                flip(world_from_web.y_axis),
                flip(world_from_web.z_axis),
            ),
            scale,
            web: web.clone(),
        },
        LightKind::Directional {
            direction,
            irradiance,
            ..
        } => LightKind::Directional {
            direction: flip(direction),
            irradiance,
            half_angle: 0.0,
        },
        LightKind::Ambient { .. } | LightKind::Environment(_) => return None,
    };
    unoccluded(&image, p, n, surfaces)
}

/// The point in that unit direction from `p` that lies beyond everything in the scene.
pub(crate) fn beyond(surfaces: &Surfaces, p: DVec3, direction: DVec3) -> DVec3 {
    let bounds = surfaces.tracer.bounds();
    p + direction * (2.0 * bounds.diagonal() + (p - bounds.centre()).length())
}
