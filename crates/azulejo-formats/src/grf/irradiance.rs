//! Stores irradiance in the document from which the scene was read.

use super::document::{BlockKind, GrfBlock, GrfDocument, MeshBlock, VertexColumn};
use super::placement::{OuterTransform, affine, is_mirror, reverse_faces};
use super::solids::{SkinBlock, skin_block};
use azulejo_scene::{Mesh, Object, Scene, Shape, SurfaceLight};
use glam::DAffine3;
use std::borrow::Cow;

impl GrfDocument {
    /// Copies the irradiance of a solved scene to the document that the scene was resolved from, so
    /// that saving keeps the definitions, transforms and comments of the file.
    ///
    /// Included files that contain objects become part of the document, because their irradiance
    /// cannot be written elsewhere. Returns `false`, without any change, if the scene's objects are
    /// no longer those of the document: meshes subdivided into patches, faces turned over, objects added
    /// or removed.
    /// [`GrfDocument::from_scene`] represents such a scene.
    pub fn set_irradiance(&mut self, scene: &Scene) -> bool {
        let mut objects = scene.objects.iter();
        let is_same = all_match(&self.blocks, &mut objects, None) && objects.next().is_none();
        if is_same {
            let mut objects = scene.objects.iter();
            self.blocks = lit(std::mem::take(&mut self.blocks), &mut objects, None);
        }
        is_same
    }
}

type Objects<'s> = std::slice::Iter<'s, Object>;

fn all_match(blocks: &[GrfBlock], objects: &mut Objects<'_>, outer: OuterTransform) -> bool {
    blocks.iter().all(|block| match &block.kind {
        BlockKind::Mesh(mesh) => matches!(
            objects.next().map(|o| &o.shape),
            Some(Shape::Mesh(solved)) if is_same_mesh(mesh, solved, outer)
        ),
        BlockKind::AreaLight(_) | BlockKind::Primitive(_) => {
            matches!(objects.next().map(|o| &o.shape), Some(Shape::Primitive(_)))
        }
        BlockKind::Exact(_) => {
            matches!(objects.next().map(|o| &o.shape), Some(Shape::Exact(_)))
        }
        BlockKind::Transform { steps, blocks } => {
            let map = outer.unwrap_or(DAffine3::IDENTITY) * affine(steps);
            all_match(blocks, objects, Some(map))
        }
        BlockKind::Include { blocks, .. }
        | BlockKind::Definitions {
            blocks: Some(blocks),
            ..
        } => all_match(blocks, objects, outer),
        _ => true,
    })
}

/// Whether the mesh has the block's vertices and faces, none of them turned to the light of its
/// back.
fn is_same_mesh(block: &MeshBlock, mesh: &Mesh, outer: OuterTransform) -> bool {
    let vertices = mesh.positions.len();
    let mut faces = Cow::Borrowed(&block.faces);
    if is_mirror(outer) {
        reverse_faces(faces.to_mut());
    }
    block.vertices.positions.len() == vertices
        && *faces == mesh.faces
        && (mesh.irradiance.is_empty() || mesh.irradiance.len() == vertices)
}

/// The blocks inside the transforms `outer`, with the irradiance of the objects.
fn lit(blocks: Vec<GrfBlock>, objects: &mut Objects<'_>, outer: OuterTransform) -> Vec<GrfBlock> {
    let mut out = Vec::with_capacity(blocks.len());
    for mut block in blocks {
        match &mut block.kind {
            BlockKind::Mesh(mesh) => set_mesh(mesh, objects.next()),
            BlockKind::AreaLight(light) => light.notes.light = surface_light(objects.next()),
            BlockKind::Primitive(p) => p.notes.light = surface_light(objects.next()),
            BlockKind::Exact(exact) => exact.skin = skin(objects.next(), outer),
            BlockKind::Transform { steps, blocks } => {
                let map = outer.unwrap_or(DAffine3::IDENTITY) * affine(steps);
                *blocks = lit(std::mem::take(blocks), objects, Some(map));
            }
            BlockKind::Definitions {
                blocks: Some(blocks),
                ..
            } => *blocks = lit(std::mem::take(blocks), objects, outer),
            BlockKind::Include { blocks, .. } if has_objects(blocks) => {
                // An include is equivalent to its content at the same position.
                out.extend(lit(std::mem::take(blocks), objects, outer));
                continue;
            }
            _ => {}
        }
        out.push(block);
    }
    out
}

fn has_objects(blocks: &[GrfBlock]) -> bool {
    blocks.iter().any(|block| match &block.kind {
        BlockKind::Mesh(_)
        | BlockKind::AreaLight(_)
        | BlockKind::Primitive(_)
        | BlockKind::Exact(_) => true,
        BlockKind::Include { blocks, .. }
        | BlockKind::Transform { blocks, .. }
        | BlockKind::Definitions {
            blocks: Some(blocks),
            ..
        } => has_objects(blocks),
        _ => false,
    })
}

fn set_mesh(block: &mut MeshBlock, object: Option<&Object>) {
    if let Some(Shape::Mesh(mesh)) = object.map(|o| &o.shape) {
        block.vertices.irradiance = VertexColumn::full(mesh.irradiance.clone());
        block
            .notes
            .irradiance_error
            .clone_from(&mesh.irradiance_error);
        block.notes.back.clone_from(&mesh.back);
    }
}

fn skin(object: Option<&Object>, outer: OuterTransform) -> Option<Box<SkinBlock>> {
    match object.map(|o| &o.shape) {
        Some(Shape::Exact(exact)) => skin_block(exact, outer),
        _ => None,
    }
}

fn surface_light(object: Option<&Object>) -> Option<SurfaceLight> {
    match object.map(|o| &o.shape) {
        Some(Shape::Primitive(p)) => p.light.clone(),
        _ => None,
    }
}
