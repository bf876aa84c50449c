//! Faces and meshes.

use super::materials::FaceAttributes;
use super::opcode;
use super::part::{FltPart, VertexSlot};
use super::vertices::{LocalPool, palette_vertex, palette_vertex_color};
use super::walk::{FltWalker, NodeVisit};
use super::warn::RecordWarnings;
use crate::ReadError;
use azulejo_scene::{MaterialId, Rgb};

/// A vertex of a mesh that has not been added to the part yet.
const NONE: u32 = u32::MAX;

/// A face or mesh in its traversal context.
struct FltSurface<'d> {
    visit: NodeVisit<'d>,
    style: &'d FaceAttributes,
    color: Rgb,
    material: MaterialId,
}

impl FltWalker<'_> {
    /// Adds a face or a mesh, and its sub-faces.
    pub fn surface(&mut self, visit: NodeVisit, part: &mut FltPart) -> Result<(), ReadError> {
        let is_mesh = visit.opcode() == opcode::MESH;
        let style = FaceAttributes::new(visit.record(), is_mesh, visit.source.document);
        if let Some(why) = style.skipped() {
            self.notes(visit).add(why);
            return Ok(());
        }
        let (color, material) = self.color_and_material(visit, &style);
        self.deeper(visit, |walker| {
            walker.each_copy(visit, |walker, visit| {
                part.enter(&visit.place, &mut walker.stamps);
                let surface = FltSurface {
                    visit,
                    style: &style,
                    color,
                    material,
                };
                if is_mesh {
                    walker.mesh(&surface, part)
                } else {
                    walker.face(&surface, part)
                }
            })
        })
    }

    /// The colour of a face and its material, with warnings about both.
    fn color_and_material(
        &mut self,
        visit: NodeVisit,
        style: &FaceAttributes,
    ) -> (Rgb, MaterialId) {
        let source = visit.source;
        let mut notes = RecordWarnings::new(&mut self.warnings, source.document, visit.node);
        let color = style.color(source.palettes, &mut notes);
        let opacity = style.opacity(visit.place.opacity, source.palettes);
        if style.billboard {
            notes.add("billboard face: kept in its original orientation");
        }
        // Vertex colours replace it; it is the default for vertices without one.
        let own = if style.is_gouraud() {
            Rgb::WHITE
        } else {
            color
        };
        let palettes = (source.set, source.palettes);
        let material = self
            .materials
            .material(style, (own, opacity), palettes, &mut notes);
        (color, material)
    }

    fn face(&mut self, face: &FltSurface, part: &mut FltPart) -> Result<(), ReadError> {
        let visit = face.visit;
        let mut has_corners = false;
        for (child, node) in visit.source.document.below(visit.node) {
            self.spend(1)?;
            match node.opcode {
                opcode::VERTEX_LIST => {
                    has_corners = true;
                    self.polygon(face, child, 4, part)?;
                }
                opcode::MORPH_VERTEX_LIST => {
                    has_corners = true;
                    let message = "morph vertex list: its state at 0 % is used";
                    self.notes(visit.with(child)).add(message);
                    self.polygon(face, child, 8, part)?;
                }
                _ => self.below_surface(face, child, part)?,
            }
        }
        if !has_corners {
            self.notes(visit).add("face without corners: skipped");
        }
        Ok(())
    }

    /// Adds the nodes below a face or mesh that are not part of it.
    fn below_surface(
        &mut self,
        surface: &FltSurface,
        child: u32,
        part: &mut FltPart,
    ) -> Result<(), ReadError> {
        let child = surface.visit.with(child);
        match child.opcode() {
            opcode::FACE | opcode::MESH => {
                let message = "sub-face, coplanar with its parent face: both are kept";
                self.notes(child).add(message);
                self.surface(child, part)?;
                part.enter(&child.place, &mut self.stamps);
                Ok(())
            }
            other if opcode::OpcodeRole::of(other) == opcode::OpcodeRole::Node => self.node(child),
            _ => Ok(()),
        }
    }

    /// Adds the polygon of a vertex list, whose entries take `size` bytes and begin with the offset
    /// of a vertex.
    fn polygon(
        &mut self,
        face: &FltSurface,
        list: u32,
        size: usize,
        part: &mut FltPart,
    ) -> Result<(), ReadError> {
        let list = face.visit.with(list);
        let record = list.record();
        let count = (record.0.len() - 4) / size;
        // One corner each, and possibly a new vertex.
        self.spend(2 * count as u64)?;
        let offsets = (0..count).filter_map(|k| record.u32(4 + size * k));
        let mut corners = Vec::with_capacity(count);
        corners.extend(offsets.filter_map(|offset| self.corner(face, offset, part)));
        let lost = count - corners.len();
        let mut notes = self.notes(list);
        notes.add_many(
            "corner that does not refer to a vertex of the palette: skipped",
            lost,
        );
        if corners.len() < 3 {
            notes.add("face with fewer than three corners: skipped");
            return Ok(());
        }
        part.add_face(&mut corners, face.material, &face.visit.place);
        self.note_missing_uvs(face, part);
        Ok(())
    }

    /// The vertex of a part for the vertex of the palette at an offset.
    fn corner(&mut self, face: &FltSurface, offset: u32, part: &mut FltPart) -> Option<u32> {
        let source = face.visit.source;
        let index = source.document.vertices.find(offset)?;
        let color = if face.style.is_gouraud() {
            let own = palette_vertex_color(source.document, source.palettes, index);
            own.unwrap_or(face.color)
        } else {
            Rgb::WHITE
        };
        let slot = &mut self.slots[source.number][index as usize];
        if slot.stamp == part.stamp && part.colors[slot.vertex as usize] == color {
            return Some(slot.vertex);
        }
        let vertex = palette_vertex(source.document, index)?;
        let added = part.add_vertex(&vertex, color, &face.visit.place)?;
        *slot = VertexSlot {
            stamp: part.stamp,
            vertex: added,
        };
        Some(added)
    }

    /// Adds the polygons of a mesh.
    fn mesh(&mut self, mesh: &FltSurface, part: &mut FltPart) -> Result<(), ReadError> {
        let document = mesh.visit.source.document;
        let record = document.ancillary(mesh.visit.node, opcode::LOCAL_VERTEX_POOL);
        let Some(pool) = record.and_then(LocalPool::new) else {
            let message = "mesh without vertex positions: skipped";
            self.notes(mesh.visit).add(message);
            return Ok(());
        };
        if pool.count < pool.promised as usize {
            let (count, promised) = (pool.count, pool.promised);
            let message = format!("mesh that declares {promised} vertices, but has {count}");
            self.notes(mesh.visit).add(message);
        }
        self.spend(pool.count as u64 / 8)?;
        let mut local = vec![NONE; pool.count];
        for (child, node) in document.below(mesh.visit.node) {
            self.spend(1)?;
            match node.opcode {
                opcode::MESH_PRIMITIVE => self.primitive(mesh, &pool, &mut local, child, part)?,
                _ => self.below_surface(mesh, child, part)?,
            }
        }
        Ok(())
    }

    /// Adds the polygons of a mesh primitive. `local` holds the vertices that the part already has.
    fn primitive(
        &mut self,
        mesh: &FltSurface,
        pool: &LocalPool,
        local: &mut [u32],
        node: u32,
        part: &mut FltPart,
    ) -> Result<(), ReadError> {
        let (visit, palettes) = (mesh.visit.with(node), mesh.visit.source.palettes);
        let primitive = MeshPrimitive::new(visit.record());
        if primitive.indices.len() < primitive.promised as usize {
            let message = "mesh primitive with fewer indices than declared";
            self.notes(visit).add(message);
        }
        self.spend(4 * primitive.indices.len() as u64)?;
        let mut vertex = |index: u32| -> Option<u32> {
            let known = local.get_mut(index as usize)?;
            if *known == NONE {
                let own = mesh.style.is_gouraud();
                let color = own.then(|| pool.color(index, palettes));
                let color = color.map_or(Rgb::WHITE, |c| c.unwrap_or(mesh.color));
                *known = part.add_vertex(&pool.vertex(index)?, color, &visit.place)?;
            }
            Some(*known)
        };
        let indices = primitive.indices.iter();
        let corners: Vec<Option<u32>> = indices.map(|i| vertex(*i)).collect();
        let mut lost = 0;
        let is_known = primitive.polygons(|polygon| {
            let vertices: Option<Vec<u32>> = polygon.iter().map(|k| corners[*k]).collect();
            match vertices {
                Some(mut polygon) => part.add_face(&mut polygon, mesh.material, &visit.place),
                None => lost += 1,
            }
        });
        let mut notes = self.notes(visit);
        notes.add_many(
            "polygon of a mesh with a vertex index out of range: skipped",
            lost,
        );
        if !is_known {
            notes.add("mesh primitive of unknown type: skipped");
        }
        self.note_missing_uvs(mesh, part);
        Ok(())
    }

    fn note_missing_uvs(&mut self, surface: &FltSurface, part: &FltPart) {
        if surface.style.has_texture() && !part.has_uvs {
            let message = "face with a texture, but without texture coordinates";
            self.notes(surface.visit).add(message);
        }
    }
}

/// The indices and the type of a mesh primitive.
struct MeshPrimitive {
    kind: i16,
    indices: Vec<u32>,
    promised: u32,
}

impl MeshPrimitive {
    fn new(record: super::fields::RecordFields) -> MeshPrimitive {
        const FIRST: usize = 12;
        let size = usize::from(record.u16(6).unwrap_or_default());
        let promised = record.u32(8).unwrap_or_default();
        let present = record.0.len().saturating_sub(FIRST).checked_div(size);
        let count = present.unwrap_or_default().min(promised as usize);
        let index = |k: usize| match size {
            1 => record.u8(FIRST + k).map(u32::from),
            2 => record.u16(FIRST + 2 * k).map(u32::from),
            4 => record.u32(FIRST + 4 * k),
            _ => None,
        };
        MeshPrimitive {
            kind: record.i16(4).unwrap_or_default(),
            indices: (0..count).map_while(index).collect(),
            promised,
        }
    }

    /// Calls `add` for each polygon with the positions of its corners among the indices; `false` if
    /// the type is unknown.
    fn polygons(&self, mut add: impl FnMut(&[usize])) -> bool {
        let n = self.indices.len();
        match self.kind {
            // Every second triangle of a strip has the opposite orientation.
            1 => (2..n).for_each(|k| match k % 2 {
                0 => add(&[k - 2, k - 1, k]),
                _ => add(&[k - 1, k - 2, k]),
            }),
            2 => (2..n).for_each(|k| add(&[0, k - 1, k])),
            3 => (3..n)
                .step_by(2)
                .for_each(|k| add(&[k - 3, k - 2, k, k - 1])),
            4 if n >= 3 => add(&Vec::from_iter(0..n)),
            4 => {}
            _ => return false,
        }
        true
    }
}
