//! The nodes Box, Sphere, Cylinder and Cone: exact, unless they are open, flattened or carry a
//! picture.

use super::look::Look;
use super::solid::Solid;
use super::stage::{Frame, Placed, Stage};
use super::tree::Node;
use super::world::report;
use crate::ReadError;
use azulejo_scene::{MaterialId, Mesh};
use glam::DVec3;

/// The solid of a node; `None` if it is of another type.
pub(super) fn solid(node: &Node) -> Option<Solid> {
    let has = |part: &str| node.flag(part, true);
    let height = node.number("height", 2.0);
    Some(match &*node.kind {
        "Box" => Solid::cuboid(node.vector("size", DVec3::splat(2.0))),
        "Sphere" => Solid::sphere(node.number("radius", 1.0)),
        "Cylinder" => {
            let radius = node.number("radius", 1.0);
            Solid::cylinder(radius, height, has("side"), has("bottom"), has("top"))
        }
        "Cone" => {
            let radius = node.number("bottomRadius", 1.0);
            Solid::cone(radius, height, has("side"), has("bottom"))
        }
        _ => return None,
    })
}

/// Makes an object of a solid.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn place(
    stage: &mut Stage,
    node: &Node,
    solid: &Solid,
    frame: &Frame,
    look: &Look,
) -> Result<(), ReadError> {
    let mut sizes = ["size", "radius", "bottomRadius", "height"].into_iter();
    if sizes.any(|size| node.numbers(size).iter().any(|x| *x <= 0.0)) {
        report(stage, &node.source, node.at, &node.kind, Placed::Nowhere);
        return Ok(());
    }
    let is_textured = look.textures.iter().any(|t| stage.textures.is_loaded(*t));
    let mut material = look.textured(None);
    material.emits_back = material.is_emitter() && !node.flag("solid", true);
    let material = stage.materials.index(material);
    if solid.is_closed() && !is_textured {
        let map = solid.object_from_unit;
        if stage.place_primitive(frame, None, solid.kind, map, material) == Placed::Object {
            return Ok(());
        }
    }
    let mesh = polygons(solid, material, look, is_textured);
    stage.spend(mesh.positions.len() as u64)?;
    let placed = stage.place_mesh(frame, None, mesh);
    report(stage, &node.source, node.at, &node.kind, placed);
    Ok(())
}

fn polygons(solid: &Solid, material: MaterialId, look: &Look, is_textured: bool) -> Mesh {
    let mut mesh = solid.polygons(&vec![material; solid.parts.len()]);
    if !is_textured {
        mesh.uvs = None;
    }
    if let (Some(map), Some(uvs)) = (look.picture_from_uv, &mut mesh.uvs) {
        for uv in &mut uvs.values {
            let mapped = map.transform_point2(*uv);
            *uv = if mapped.is_finite() { mapped } else { *uv };
        }
    }
    mesh
}
