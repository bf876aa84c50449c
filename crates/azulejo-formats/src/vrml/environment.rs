//! Bindable nodes: viewpoints, background, fog and navigation info.

use super::builder::{VrmlPlacement, VrmlSceneBuilder};
use super::tree::VrmlNode;
use super::world::rotation;
use crate::reading::text::shortened;
use azulejo_scene::{Camera, Fog, Rgb};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI};

/// Adds a node of this group to the scene.
pub(super) fn place(builder: &mut VrmlSceneBuilder, node: &VrmlNode, frame: &VrmlPlacement) {
    match &*node.kind {
        "Viewpoint" => viewpoint(builder, node, frame),
        "Fog" => fog(builder, node, frame),
        "NavigationInfo" => navigation(builder, node),
        _ => background(builder, node, frame),
    }
}

fn viewpoint(builder: &mut VrmlSceneBuilder, node: &VrmlNode, frame: &VrmlPlacement) {
    let map = &frame.world_from_object;
    let turn = rotation(node.array("orientation", [0.0, 0.0, 1.0, 0.0]));
    let eye = map.transform_point3(node.vector("position", DVec3::new(0.0, 0.0, 10.0)));
    let forward = map.transform_vector3(turn * DVec3::NEG_Z).try_normalize();
    let up = map.transform_vector3(turn * DVec3::Y).try_normalize();
    let field = node.number("fieldOfView", FRAC_PI_4);
    let sane = field > 0.0 && field < PI;
    let (Some(forward), Some(up)) = (forward, up) else {
        return nowhere(builder, node);
    };
    let camera = Camera {
        name: match node.strings("description").first() {
            Some(description) if !description.is_empty() => shortened(description),
            _ => frame.name(node.name.as_deref()),
        },
        eye,
        target: eye + forward,
        up,
        vertical_fov: if sane { field } else { FRAC_PI_4 },
        size: None,
    };
    let (right, up, forward) = camera.axes();
    if !(eye.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite()) {
        return nowhere(builder, node);
    }
    if !sane {
        let message = "Viewpoint with a fieldOfView outside 0..π: taken as π/4";
        builder.warn(&node.source, node.at, message);
    }
    builder.scene.cameras.push(camera);
}

fn nowhere(builder: &mut VrmlSceneBuilder, node: &VrmlNode) {
    builder.warn(
        &node.source,
        node.at,
        "Viewpoint with a degenerate view: skipped",
    );
}

/// Whether this is the first node of its type, the one that is used.
fn is_first(builder: &mut VrmlSceneBuilder, node: &VrmlNode, is_there: bool) -> bool {
    if is_there {
        let message = format!("{} after the first: skipped", node.kind);
        builder.warn(&node.source, node.at, message);
    }
    !is_there
}

fn background(builder: &mut VrmlSceneBuilder, node: &VrmlNode, frame: &VrmlPlacement) {
    let is_there = builder.scene.background.is_some();
    if !is_first(builder, node, is_there) {
        return;
    }
    super::background::place(builder, node, frame);
}

fn fog(builder: &mut VrmlSceneBuilder, node: &VrmlNode, frame: &VrmlPlacement) {
    let scale = frame.world_from_object.matrix3.determinant().abs().cbrt();
    let visibility = node.number("visibilityRange", 0.0) * scale;
    if !(visibility > 0.0 && visibility.is_finite()) {
        // The standard's way to disable fog.
        return;
    }
    let is_there = builder.scene.fog.is_some();
    if is_first(builder, node, is_there) {
        let kind = node.strings("fogType");
        builder.scene.fog = Some(Fog {
            color: node.color("color", Rgb::WHITE),
            visibility,
            exponential: kind
                .first()
                .is_some_and(|k| k.eq_ignore_ascii_case("EXPONENTIAL")),
        });
    }
}

fn navigation(builder: &mut VrmlSceneBuilder, node: &VrmlNode) {
    if node.flag("headlight", true) {
        let message = "headlight of NavigationInfo: skipped, it is not a light of the scene";
        builder.warn(&node.source, node.at, message);
    }
}
