//! Lights without area.

use super::builder::VrmlSceneBuilder;
use super::tree::VrmlNode;
use super::world::NodePosition;
use azulejo_scene::{Light, LightKind, Rgb};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Adds a light to the scene.
pub(super) fn place(builder: &mut VrmlSceneBuilder, node: &VrmlNode, place: &NodePosition) {
    if !node.flag("on", true) {
        builder.warn_node(node, format!("{} with on FALSE: skipped", node.kind));
        return;
    }
    warn_unsupported_fields(builder, node, place);
    let color = node.color("color", Rgb::WHITE);
    let light = color * node.number("intensity", 1.0).max(0.0);
    let kind = match &*node.kind {
        "PointLight" => point(node, &place.frame.world_from_object, light),
        "SpotLight" => spot(node, &place.frame.world_from_object, light),
        _ => directional(node, &place.frame.world_from_object, light),
    };
    match kind {
        Some(kind) => builder.scene.lights.push(Light {
            name: place.frame.name(node.name.as_deref()),
            kind,
        }),
        None => {
            let message = format!(
                "{} without a valid position or direction: skipped",
                node.kind
            );
            builder.warn_node(node, message);
        }
    }
}

fn warn_unsupported_fields(builder: &mut VrmlSceneBuilder, node: &VrmlNode, place: &NodePosition) {
    let directional = &*node.kind == "DirectionalLight";
    if node.number("ambientIntensity", 0.0) > 0.0 {
        let message = "ambientIntensity of a light: ignored, azulejo computes indirect light";
        builder.warn_node(node, message);
    }
    if !directional {
        let message = "attenuation and radius of lights: ignored, light falls off with the square of the distance";
        builder.warn_node(node, message);
    }
    if !node.flag("global", !directional || place.depth == 0) {
        let message = format!("{} limited to its group: lights the whole scene", node.kind);
        builder.warn_node(node, message);
    }
}

fn position(node: &VrmlNode, map: &DAffine3) -> Option<DVec3> {
    let position = map.transform_point3(node.vector("location", DVec3::ZERO));
    position.is_finite().then_some(position)
}

fn direction(node: &VrmlNode, map: &DAffine3) -> Option<DVec3> {
    let direction = node.vector("direction", DVec3::NEG_Z);
    map.transform_vector3(direction).try_normalize()
}

fn point(node: &VrmlNode, map: &DAffine3, intensity: Rgb) -> Option<LightKind> {
    Some(LightKind::Point {
        position: position(node, map)?,
        intensity,
    })
}

/// The two standards give the same defaults in opposite roles: VRML97 has no falloff inside the
/// cone, X3D has one from half of the cone angle outwards.
fn spot(node: &VrmlNode, map: &DAffine3, intensity: Rgb) -> Option<LightKind> {
    let (cut_off, beam) = if node.source.is_x3d() {
        (FRAC_PI_2, FRAC_PI_4)
    } else {
        (FRAC_PI_4, FRAC_PI_2)
    };
    let outer = node.number("cutOffAngle", cut_off).clamp(0.0, PI);
    Some(LightKind::Spot {
        position: position(node, map)?,
        direction: direction(node, map)?,
        intensity,
        inner: node.number("beamWidth", beam).clamp(0.0, outer),
        outer,
    })
}

fn directional(node: &VrmlNode, map: &DAffine3, irradiance: Rgb) -> Option<LightKind> {
    Some(LightKind::Directional {
        direction: direction(node, map)?,
        irradiance,
        half_angle: 0.0,
    })
}
