//! The nodes Box, Sphere, Cylinder and Cone: exact, unless they are open, flattened or textured.

use super::appearance::ShapeAppearance;
use super::builder::{ShapeOutcome, VrmlPlacement, VrmlSceneBuilder};
use super::shape::sidedness;
use super::solid::PlacedPrimitive;
use super::tree::VrmlNode;
use crate::ReadError;
use azulejo_scene::{Mesh, TextureId};
use glam::DVec3;

/// The primitive of a node; `None` if it is of another type.
pub(super) fn solid(node: &VrmlNode) -> Option<PlacedPrimitive> {
    let has = |part: &str| node.flag(part, true);
    let height = node.number("height", 2.0);
    Some(match &*node.kind {
        "Box" => PlacedPrimitive::cuboid(node.vector("size", DVec3::splat(2.0))),
        "Sphere" => PlacedPrimitive::sphere(node.number("radius", 1.0)),
        "Cylinder" => {
            let radius = node.number("radius", 1.0);
            PlacedPrimitive::cylinder(radius, height, has("side"), has("bottom"), has("top"))
        }
        "Cone" => {
            let radius = node.number("bottomRadius", 1.0);
            PlacedPrimitive::cone(radius, height, has("side"), has("bottom"))
        }
        _ => return None,
    })
}

/// Adds a primitive as an object.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn place(
    builder: &mut VrmlSceneBuilder,
    node: &VrmlNode,
    solid: &PlacedPrimitive,
    frame: &VrmlPlacement,
    shape_appearance: &ShapeAppearance,
) -> Result<(), ReadError> {
    let mut sizes = ["size", "radius", "bottomRadius", "height"].into_iter();
    if sizes.any(|size| node.numbers(size).iter().any(|x| *x <= 0.0)) {
        builder.report(node, ShapeOutcome::Degenerate);
        return Ok(());
    }
    let textures = &shape_appearance.textures;
    let is_loaded = |t: &TextureId| builder.textures.is_loaded(*t);
    let is_textured =
        shape_appearance.is_pictured() && (textures.is_empty() || textures.iter().any(is_loaded));
    let mut material = shape_appearance.textured(None);
    material.emits_back = material.is_emitter() && !node.flag("solid", true);
    material.sidedness = sidedness(node);
    let material = builder.materials.index(material);
    if solid.is_closed() && !is_textured {
        let map = solid.object_from_unit;
        if builder.place_primitive(frame, None, solid.kind, map, material) == ShapeOutcome::Object {
            return Ok(());
        }
    }
    let Some(mut mesh) = builder.polygons(solid, &vec![material; solid.parts.len()])? else {
        return Ok(());
    };
    map_texture(&mut mesh, shape_appearance, is_textured);
    let placed = builder.place_mesh(frame, None, (&node.source, node.at), mesh);
    builder.report(node, placed);
    Ok(())
}

/// Transforms the texture coordinates of a primitive, or removes them if there is no texture.
fn map_texture(mesh: &mut Mesh, shape_appearance: &ShapeAppearance, is_textured: bool) {
    if !is_textured {
        mesh.uvs = None;
    }
    if let (Some(map), Some(uvs)) = (shape_appearance.texture_from_uv, &mut mesh.uvs) {
        for uv in &mut uvs.values {
            let mapped = map.transform_point2(*uv);
            *uv = if mapped.is_finite() { mapped } else { *uv };
        }
    }
}
