//! Boxes, spheres, cylinders and cones: exact where they are closed.

use super::look::Look;
use super::shape::{Pool, Surface};
use super::stage::{Frame, Stage};
use super::tree::Node;
use super::world::report;
use crate::ReadError;
use azulejo_scene::PrimitiveKind;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// Sides of a cylinder or cone that is not closed: its chords are within a thousandth of the
/// radius.
pub(super) const SIDES: usize = 72;

/// Makes an object of a closed solid. The polygons of one that is not closed are for the caller.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn place<'n>(
    stage: &mut Stage,
    node: &'n Node,
    frame: &Frame,
    look: &Look,
) -> Result<Option<Surface<'n>>, ReadError> {
    let has = |part: &str| node.flag(part, true);
    let (kind, map) = match &*node.kind {
        "Box" => {
            let size = node.vector("size", DVec3::splat(2.0));
            let map = DAffine3::from_translation(-0.5 * size) * DAffine3::from_scale(size);
            (PrimitiveKind::Cuboid, map)
        }
        "Sphere" => {
            let radius = DVec3::splat(node.number("radius", 1.0));
            (PrimitiveKind::Sphere, DAffine3::from_scale(radius))
        }
        "Cylinder" if has("side") && has("top") && has("bottom") => {
            let radius = node.number("radius", 1.0);
            (PrimitiveKind::Cylinder, upright(radius, height(node)))
        }
        "Cone" if has("side") && has("bottom") => {
            let radius = node.number("bottomRadius", 1.0);
            (
                PrimitiveKind::Cone { top: 0.0 },
                upright(radius, height(node)),
            )
        }
        _ => {
            let message = format!(
                "open {}: {SIDES} sides, within 0.1 % of its radius",
                node.kind
            );
            stage.warn(&node.source, node.at, message);
            return Ok(Some(open(node)));
        }
    };
    if !look.textures.is_empty() {
        let message = format!("picture on an exact {}: not shown", node.kind);
        stage.warn(&node.source, node.at, message);
    }
    let material = stage.materials.index(look.material.clone());
    let placed = stage.place_primitive(frame, None, kind, map, material);
    report(stage, &node.source, node.at, &node.kind, placed);
    Ok(None)
}

fn height(node: &Node) -> f64 {
    node.number("height", 2.0)
}

/// From radius 1 around z, 0 <= z <= 1, to a radius around y, half of the height on each side.
fn upright(radius: f64, height: f64) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(radius * DVec3::Z, radius * DVec3::X, height * DVec3::Y),
        translation: -0.5 * height * DVec3::Y,
    }
}

/// The parts of a cylinder or cone that are there.
fn open(node: &Node) -> Surface<'_> {
    let is_cone = &*node.kind == "Cone";
    let radius = node.number(if is_cone { "bottomRadius" } else { "radius" }, 1.0);
    let mut parts = Parts::new(radius, 0.5 * height(node), is_cone);
    if node.flag("side", true) {
        parts.side();
    }
    if node.flag("bottom", true) {
        parts.cap(-1.0);
    }
    if !is_cone && node.flag("top", true) {
        parts.cap(1.0);
    }
    let uv_index = parts.uv_index.clone();
    let mut surface = Surface::new(node, parts.positions, Cow::Owned(parts.coord_index));
    surface.uvs = Some(Pool {
        index: Some(Cow::Owned(uv_index)),
        ..Pool::per_vertex(parts.uvs)
    });
    // The sides are smooth, the rims are not: no rim is as blunt as a fifth of a turn.
    surface.crease_angle = PI / 5.0;
    surface
}

/// Rings of vertices, each beginning at the back, −z, and turning as seen from above.
struct Parts {
    radius: f64,
    half: f64,
    is_cone: bool,
    positions: Vec<DVec3>,
    coord_index: Vec<i32>,
    uvs: Vec<DVec2>,
    uv_index: Vec<i32>,
}

impl Parts {
    fn new(radius: f64, half: f64, is_cone: bool) -> Parts {
        let mut parts = Parts {
            radius,
            half,
            is_cone,
            positions: Vec::new(),
            coord_index: Vec::new(),
            uvs: Vec::new(),
            uv_index: Vec::new(),
        };
        parts.ring(-half, radius);
        // The upper ring of a cone is its apex, many times: each side has a normal of its own.
        parts.ring(half, if is_cone { 0.0 } else { radius });
        parts
    }

    fn ring(&mut self, y: f64, radius: f64) {
        let at = |k| {
            let (sin, cos) = turn(k);
            DVec3::new(-radius * sin, y, -radius * cos)
        };
        self.positions.extend((0..SIDES).map(at));
    }

    /// Takes a face whose corners are (position, texture coordinates).
    fn face(&mut self, corners: impl IntoIterator<Item = (usize, DVec2)>) {
        for (vertex, uv) in corners {
            self.coord_index.push(vertex as i32);
            self.uv_index.push(self.uvs.len() as i32);
            self.uvs.push(uv);
        }
        self.coord_index.push(-1);
        self.uv_index.push(-1);
    }

    /// The picture goes around from the back, ISO/IEC 14772-1, 6.14 and 6.16.
    fn side(&mut self) {
        for k in 0..SIDES {
            let next = (k + 1) % SIDES;
            let u = |k: usize| k as f64 / SIDES as f64;
            let low = [
                (k, DVec2::new(u(k), 0.0)),
                (next, DVec2::new(u(k + 1), 0.0)),
            ];
            let high = [
                (SIDES + next, DVec2::new(u(k + 1), 1.0)),
                (SIDES + k, DVec2::new(u(k), 1.0)),
            ];
            let high = &high[usize::from(self.is_cone)..];
            self.face(low.into_iter().chain(high.iter().copied()));
        }
    }

    /// The lower cap, or with `up` = 1 the upper one.
    fn cap(&mut self, up: f64) {
        let start = self.positions.len();
        self.ring(up * self.half, self.radius);
        let corner = |k: usize| {
            let (sin, cos) = turn(k);
            (start + k, DVec2::new(0.5 - 0.5 * sin, 0.5 + 0.5 * up * cos))
        };
        match up > 0.0 {
            true => self.face((0..SIDES).map(corner)),
            false => self.face((0..SIDES).rev().map(corner)),
        }
    }
}

fn turn(k: usize) -> (f64, f64) {
    (TAU * k as f64 / SIDES as f64).sin_cos()
}
