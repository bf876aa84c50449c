//! `ext skin`: the proxy mesh of an exact shape in the first pass, with its irradiance.

use super::super::document::{BlockKind, GrfBlock, MeshBlock, ObjectNotes};
use super::super::entries::GrfEntries;
use super::super::from_scene::polygons;
use super::super::parse::BlockEnd;
use super::super::parser::{GrfParser, ParseResult};
use super::super::placement::OuterTransform;
use super::super::write::{GrfOutput, faces, point, rgb_list, vertices};
use super::SkinBlock;
use azulejo_scene::{Exact, MaterialId, Mesh};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Display;
use std::io::{self, Write};

const EXTENSION: BlockEnd = BlockEnd::required(&["ext"]);

impl GrfParser<'_, '_, '_> {
    /// Reads a skin, after `ext skin begin`; the exact shape is the block `before`.
    pub fn skin(&mut self, offset: usize, before: Option<&mut GrfBlock>) -> ParseResult<()> {
        let mut entries = GrfEntries::new("`ext skin`", offset);
        let mesh = self.polygons(&mut entries, &EXTENSION)?;
        let leaves = if entries.has("leaves") {
            self.counts(&mut entries, "leaves", (mesh.faces.len(), "face"))?
        } else {
            Vec::new()
        };
        self.warn_of_rest(&entries);
        let Some(BlockKind::Exact(exact)) = before.map(|block| &mut block.kind) else {
            return Err(self.fail(
                offset,
                "`ext skin`",
                "its exact shape immediately before it",
            ));
        };
        exact.skin = Some(Box::new(SkinBlock {
            mesh: *mesh,
            leaves,
        }));
        Ok(())
    }
}

/// Writes a skin.
pub(in crate::grf) fn skin(out: &mut GrfOutput<'_>, skin: &SkinBlock) -> io::Result<()> {
    out.write_all(b"ext skin begin\n")?;
    counts(out, "leaves", &skin.leaves)?;
    polygons_without_appearance(out, &skin.mesh)?;
    out.write_all(b"end ext\n")
}

/// Writes the keys and lists of a mesh without appearance.
pub(super) fn polygons_without_appearance(
    out: &mut GrfOutput<'_>,
    mesh: &MeshBlock,
) -> io::Result<()> {
    counts(out, "smoothing", &mesh.notes.smoothing)?;
    if !mesh.notes.irradiance_error.is_empty() {
        rgb_list(out, "irad_error", &mesh.notes.irradiance_error)?;
    }
    if let Some(normals) = &mesh.notes.normals
        && !normals.values.is_empty()
    {
        out.write_all(b"normals =\n")?;
        let values = &normals.values;
        values
            .iter()
            .try_for_each(|&n| writeln!(out, "{}", point(n)))?;
        counts(
            out,
            "corners",
            normals.corners.as_deref().unwrap_or_default(),
        )?;
    }
    vertices(out, mesh)?;
    faces(out, mesh)
}

fn counts<T: Display>(out: &mut GrfOutput<'_>, key: &str, counts: &[T]) -> io::Result<()> {
    if counts.is_empty() {
        return Ok(());
    }
    write!(out, "{key} =")?;
    counts.iter().try_for_each(|n| write!(out, " {n}"))?;
    out.write_all(b"\n")
}

/// The block of a solved shape's proxy mesh, in the coordinates inside the transforms `outer`.
pub(in crate::grf) fn skin_block(exact: &Exact, outer: OuterTransform) -> Option<Box<SkinBlock>> {
    let mut skin = Mesh::clone(exact.proxy.as_ref()?);
    if let Some(map) = outer {
        skin.transform(&map.inverse());
    }
    let mut first: HashMap<MaterialId, u32> = HashMap::new();
    for (index, leaf) in exact.leaves().iter().enumerate() {
        first.entry(leaf.material()).or_insert(index as u32);
    }
    // A valid scene gives each face the material of one of the solids.
    let leaf = |m: &MaterialId| first.get(m).copied().unwrap_or(0);
    let mut leaves: Vec<u32> = skin.face_materials.iter().map(leaf).collect();
    if leaves.iter().all(|&leaf| leaf == 0) {
        leaves.clear();
    }
    Some(Box::new(SkinBlock {
        mesh: mesh_block(skin),
        leaves,
    }))
}

/// The block of a mesh without appearance. Normals stay per corner, so no vertices are split.
pub(super) fn mesh_block(mut mesh: Mesh) -> MeshBlock {
    let normals = mesh.normals.take_if(|n| n.corners.is_some());
    let notes = ObjectNotes {
        normals: normals.map(Box::new),
        ..ObjectNotes::default()
    };
    polygons(Cow::Owned(mesh), notes)
}
