//! `ext skin`: what stood for an exact shape in the first pass, with the light on it.

use super::super::document::{Block, BlockKind, MeshBlock, ObjectNotes};
use super::super::entries::Entries;
use super::super::from_scene::polygons;
use super::super::parse::Ending;
use super::super::parser::{Parsed, Parser};
use super::super::placement::Outer;
use super::super::write::{Out, faces, point, rgb_list, vertices};
use super::SkinBlock;
use azulejo_scene::{Exact, MaterialId, Mesh};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Display;
use std::io::{self, Write};

const EXTENSION: Ending = Ending::required(&["ext"]);

impl Parser<'_, '_, '_> {
    /// `ext skin begin` was read; the exact shape is the block `before`.
    pub fn skin(&mut self, offset: usize, before: Option<&mut Block>) -> Parsed<()> {
        let mut entries = Entries::new("`ext skin`", offset);
        let mesh = self.polygons(&mut entries, &EXTENSION)?;
        let leaves = match entries.has("leaves") {
            true => self.counts(&mut entries, "leaves", (mesh.faces.len(), "face"))?,
            false => Vec::new(),
        };
        self.warn_of_rest(&entries);
        let Some(BlockKind::Exact(exact)) = before.map(|block| &mut block.kind) else {
            return Err(self.fail(
                offset,
                "`ext skin`",
                "the exact shape that it is about right before it",
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
pub(super) fn skin(out: &mut Out<'_>, skin: &SkinBlock) -> io::Result<()> {
    out.write_all(b"ext skin begin\n")?;
    counts(out, "leaves", &skin.leaves)?;
    polygons_without_looks(out, &skin.mesh)?;
    out.write_all(b"end ext\n")
}

/// The keys and lists of a mesh that has no looks.
pub(super) fn polygons_without_looks(out: &mut Out<'_>, mesh: &MeshBlock) -> io::Result<()> {
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

fn counts<T: Display>(out: &mut Out<'_>, key: &str, counts: &[T]) -> io::Result<()> {
    if counts.is_empty() {
        return Ok(());
    }
    write!(out, "{key} =")?;
    counts.iter().try_for_each(|n| write!(out, " {n}"))?;
    out.write_all(b"\n")
}

/// The block of a solved shape's skin, in the space inside of the transforms `outer`.
pub(in crate::grf) fn skin_block(exact: &Exact, outer: Outer) -> Option<Box<SkinBlock>> {
    let mut skin = Mesh::clone(exact.proxy.as_ref()?);
    if let Some(map) = outer {
        skin.transform(&map.inverse());
    }
    let mut first: HashMap<MaterialId, u32> = HashMap::new();
    for (index, leaf) in exact.leaves().iter().enumerate() {
        first.entry(leaf.material()).or_insert(index as u32);
    }
    // A scene promises that each face has the material of a solid.
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

/// The block of a mesh without looks. Normals stay at corners, which need no split vertices here.
pub(super) fn mesh_block(mut mesh: Mesh) -> MeshBlock {
    let normals = mesh.normals.take_if(|n| n.corners.is_some());
    let notes = ObjectNotes {
        normals: normals.map(Box::new),
        ..ObjectNotes::default()
    };
    polygons(Cow::Owned(mesh), notes)
}
