//! The content of an OBJ file as flat lists, before it is divided into objects.

use super::free_form::Tessellated;
use azulejo_scene::{Faces, Rgb};
use glam::{DVec2, DVec3};

/// "No such index": a corner without texture coordinate or normal, a face without material.
///
/// No real index reaches it, because the file is less than 4 GiB.
pub(super) const NONE: u32 = u32::MAX;

/// The content of an OBJ file, in its own order, numbered from zero.
#[derive(Debug, Default)]
pub(super) struct ObjLists {
    pub positions: Vec<DVec3>,
    /// Colours of the vertices up to the last that has one.
    pub colors: Vec<Option<Rgb>>,
    /// Weights of the vertices up to the last whose weight is not 1.
    pub weights: Vec<f64>,
    pub uvs: Vec<DVec2>,
    /// Unit length, or zero for unusable ones.
    pub normals: Vec<DVec3>,
    pub faces: Faces,
    /// Texture coordinate of each corner or [`NONE`]; empty when no corner has one.
    pub corner_uvs: Vec<u32>,
    /// Normal of each corner or [`NONE`]; empty when no corner has one.
    pub corner_normals: Vec<u32>,
    /// Index into `material_names`, or [`NONE`].
    pub face_materials: Vec<u32>,
    /// Smoothing group of each face, or [`NONE`] before the first `s`; empty before it.
    pub smoothing: Vec<u32>,
    pub material_names: Vec<String>,
    /// The parts: one for each `o` and each `g`.
    pub parts: Vec<ObjPart>,
    /// Free-form surfaces, in the order of their parts.
    pub surfaces: Vec<Tessellated>,
}

/// The faces from `first_face` to that of the next part.
#[derive(Debug)]
pub(super) struct ObjPart {
    /// `o`, `g`, or `o/g`.
    pub name: String,
    pub first_face: usize,
}
