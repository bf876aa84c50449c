//! Writes solids as text.

use super::super::document::GrfName;
use super::super::write::{GrfOutput, Quoted, affine_map, object, pair, point, unit_primitive};
use super::bevel::bevel;
use super::skin::{polygons_without_appearance, skin};
use super::{
    CsgBlock, ExactBlock, GlyphBlock, GlyphOrigin, SolidBlock, SolidDefinition, SolidKind,
    TextBlock,
};
use azulejo_scene::Operation;
use std::io::{self, Write};

/// Writes an object: a single solid as an extension of its own, if there is one for it.
pub(in crate::grf) fn exact(out: &mut GrfOutput<'_>, block: &ExactBlock) -> io::Result<()> {
    object(out, &block.notes, None)?;
    let around = block.notes.material.as_ref();
    match &block.solids[..] {
        [alone] if !matches!(alone.kind, SolidKind::Primitive(..) | SolidKind::Mesh(_)) => {
            write!(out, "ext {} begin", word(&alone.kind))?;
            inside(out, alone, alone.material.as_ref().or(around))?;
        }
        solids => {
            out.write_all(b"ext solids begin")?;
            material(out, around)?;
            out.write_all(b"\n")?;
            members(out, solids)?;
        }
    }
    out.write_all(b"end ext\n")?;
    block.skin.iter().try_for_each(|s| skin(out, s))
}

/// Writes a definition.
pub(in crate::grf) fn define(out: &mut GrfOutput<'_>, block: &SolidDefinition) -> io::Result<()> {
    write!(out, "ext define begin name = {}", block.name)?;
    material(out, block.material.as_ref())?;
    out.write_all(b"\n")?;
    members(out, &block.solids)?;
    out.write_all(b"end ext\n")
}

fn members(out: &mut GrfOutput<'_>, solids: &[SolidBlock]) -> io::Result<()> {
    solids.iter().try_for_each(|solid| {
        let word = word(&solid.kind);
        write!(out, "{word} begin")?;
        inside(out, solid, solid.material.as_ref())?;
        writeln!(out, "end {word}")
    })
}

fn word(kind: &SolidKind) -> &'static str {
    match kind {
        SolidKind::Primitive(..) => "primitive",
        SolidKind::Prism(..) => "prism",
        SolidKind::Text(_) => "text",
        SolidKind::Patch(_) => "patch",
        SolidKind::Mesh(_) => "mesh",
        SolidKind::Shell(_) => "shell",
        SolidKind::Csg(_) => "csg",
        SolidKind::Instance(..) => "instance",
    }
}

fn material(out: &mut GrfOutput<'_>, name: Option<&GrfName>) -> io::Result<()> {
    match name {
        Some(name) => write!(out, " material = {name}"),
        None => Ok(()),
    }
}

/// Writes what is between `begin` and `end`; short solids stay on one line.
fn inside(out: &mut GrfOutput<'_>, solid: &SolidBlock, brdf: Option<&GrfName>) -> io::Result<()> {
    // Begin with the entries of this kind, then the material, which every kind may have.
    match &solid.kind {
        SolidKind::Primitive(kind, map) => unit_primitive(out, *kind, map)?,
        SolidKind::Prism(figure, map, edge) => {
            write!(out, " figure = {figure}")?;
            affine_map(out, map)?;
            bevel(out, edge.as_ref())?;
        }
        SolidKind::Instance(of, map) => {
            write!(out, " of = {of}")?;
            map.iter().try_for_each(|map| affine_map(out, map))?;
        }
        SolidKind::Csg(csg) => write!(out, " operation = {}", operation(csg.operation))?,
        SolidKind::Text(text) => text_keys(out, text)?,
        SolidKind::Patch(_) | SolidKind::Mesh(_) | SolidKind::Shell(_) => {}
    }
    material(out, brdf)?;
    // A solid of few entries ends on the same line.
    match &solid.kind {
        SolidKind::Primitive(..) | SolidKind::Prism(..) | SolidKind::Instance(..) => {
            return out.write_all(b" ");
        }
        _ => out.write_all(b"\n")?,
    }
    // Lists of points, faces and members have lines of their own.
    match &solid.kind {
        SolidKind::Csg(csg) => sides(out, csg),
        SolidKind::Text(text) => text.glyphs.iter().try_for_each(|g| glyph(out, g)),
        SolidKind::Shell(pieces) => members(out, pieces),
        SolidKind::Mesh(mesh) => polygons_without_appearance(out, mesh),
        SolidKind::Patch(points) => {
            out.write_all(b"points =\n")?;
            for [a, b, c, d] in points.iter() {
                writeln!(
                    out,
                    "{} {} {} {}",
                    point(*a),
                    point(*b),
                    point(*c),
                    point(*d)
                )?;
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn operation(operation: Operation) -> &'static str {
    match operation {
        Operation::Union => "union",
        Operation::Difference => "difference",
        Operation::Intersection => "intersection",
    }
}

fn sides(out: &mut GrfOutput<'_>, csg: &CsgBlock) -> io::Result<()> {
    for (side, solids) in [("left", &csg.left), ("right", &csg.right)] {
        writeln!(out, "{side} begin")?;
        members(out, solids)?;
        writeln!(out, "end {side}")?;
    }
    Ok(())
}

fn text_keys(out: &mut GrfOutput<'_>, text: &TextBlock) -> io::Result<()> {
    if let Some(string) = &text.string {
        write!(out, " string = {}", Quoted(string))?;
    }
    affine_map(out, &text.map)?;
    bevel(out, text.bevel.as_ref())
}

fn glyph(out: &mut GrfOutput<'_>, glyph: &GlyphBlock) -> io::Result<()> {
    match glyph.pen {
        GlyphOrigin::Along(pen) => writeln!(out, "{} {}", glyph.figure, pair(pen)),
        GlyphOrigin::At(place) => writeln!(out, "{} {}", glyph.figure, point(place)),
    }
}
