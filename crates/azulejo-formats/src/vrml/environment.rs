//! Bindable nodes: viewpoints, background, fog and navigation info.

use super::builder::{VrmlPlacement, VrmlSceneBuilder};
use super::tree::VrmlNode;
use super::world::rotation;
use crate::reading::text::shortened;
use azulejo_scene::{Camera, Fog, Rgb};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI};

impl VrmlSceneBuilder<'_> {
    /// Adds a node of this group to the scene.
    pub(super) fn place_environment(&mut self, node: &VrmlNode, frame: &VrmlPlacement) {
        match &*node.kind {
            "Viewpoint" => self.viewpoint(node, frame),
            "Fog" => self.fog(node, frame),
            "NavigationInfo" => self.navigation(node),
            _ => self.background(node, frame),
        }
    }

    fn viewpoint(&mut self, node: &VrmlNode, frame: &VrmlPlacement) {
        let map = &frame.world_from_object;
        let turn = rotation(node.array("orientation", [0.0, 0.0, 1.0, 0.0]));
        let eye = map.transform_point3(node.vector("position", DVec3::new(0.0, 0.0, 10.0)));
        let forward = map.transform_vector3(turn * DVec3::NEG_Z).try_normalize();
        let up = map.transform_vector3(turn * DVec3::Y).try_normalize();
        let field = node.number("fieldOfView", FRAC_PI_4);
        let sane = field > 0.0 && field < PI;
        let (Some(forward), Some(up)) = (forward, up) else {
            return self.skip_viewpoint(node);
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
            return self.skip_viewpoint(node);
        }
        if !sane {
            let message = "Viewpoint with a fieldOfView outside 0..π: taken as π/4";
            self.warn_node(node, message);
        }
        self.scene.cameras.push(camera);
    }

    fn skip_viewpoint(&mut self, node: &VrmlNode) {
        self.warn_node(node, "Viewpoint with a degenerate view: skipped");
    }

    /// Whether this is the first node of its type, the one that is used.
    fn is_first(&mut self, node: &VrmlNode, is_there: bool) -> bool {
        if is_there {
            let message = format!("{} after the first: skipped", node.kind);
            self.warn_node(node, message);
        }
        !is_there
    }

    fn background(&mut self, node: &VrmlNode, frame: &VrmlPlacement) {
        let is_there = self.scene.background.is_some();
        if !self.is_first(node, is_there) {
            return;
        }
        super::background::place(self, node, frame);
    }

    fn fog(&mut self, node: &VrmlNode, frame: &VrmlPlacement) {
        let scale = frame.world_from_object.matrix3.determinant().abs().cbrt();
        let visibility = node.number("visibilityRange", 0.0) * scale;
        if !(visibility > 0.0 && visibility.is_finite()) {
            // The standard's way to disable fog.
            return;
        }
        let is_there = self.scene.fog.is_some();
        if self.is_first(node, is_there) {
            let kind = node.strings("fogType");
            self.scene.fog = Some(Fog {
                color: node.color("color", Rgb::WHITE),
                visibility,
                exponential: kind
                    .first()
                    .is_some_and(|k| k.eq_ignore_ascii_case("EXPONENTIAL")),
            });
        }
    }

    fn navigation(&mut self, node: &VrmlNode) {
        if node.flag("headlight", true) {
            let message = "headlight of NavigationInfo: skipped, it is not a light of the scene";
            self.warn_node(node, message);
        }
    }
}
