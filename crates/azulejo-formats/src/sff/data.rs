//! The data of patches, polygons and triangles.

use super::SffResult;
use super::document::*;
use super::lines::SffLines;
use glam::DVec3;

/// Reads data after a record: the lines below it, or the name of a file. The record's line is
/// consumed.
pub(super) fn here_or_file<T>(
    lines: &mut SffLines,
    read: impl FnOnce(&mut SffLines) -> SffResult<T>,
) -> SffResult<RecordData<T>> {
    let file = lines.file_name()?;
    lines.end_record();
    Ok(match file {
        Some(name) => RecordData::File(name),
        None => RecordData::Here(read(lines)?),
    })
}

/// Reads twelve vertex numbers per patch, then the vertices.
pub(super) fn patches(lines: &mut SffLines) -> SffResult<PatchData> {
    let mut largest = 0;
    let mut patches = Vec::new();
    while !lines.section_ends() {
        let mut patch = [0; 12];
        for vertex in &mut patch {
            *vertex = vertex_index(lines, &mut largest)?;
        }
        patches.push(patch);
        lines.end_record();
    }
    let vertices = vertices(lines, largest)?;
    Ok(PatchData { patches, vertices })
}

/// Reads a count and as many vertex numbers per polygon, then the vertices.
pub(super) fn polygons(lines: &mut SffLines) -> SffResult<PolygonData> {
    let mut largest = 0;
    let mut faces = azulejo_scene::Faces::default();
    let mut corners = Vec::new();
    while !lines.section_ends() {
        let place = lines.place();
        let count = lines.index()?;
        // Each takes at least a digit and a blank.
        if count < 3 || 2 * (count as usize - 1) > lines.bytes_left() {
            let found = format!("a polygon with {count} vertices");
            return Err(lines.error(place, found, "3 or more, all listed after the count"));
        }
        corners.clear();
        for _ in 0..count {
            corners.push(vertex_index(lines, &mut largest)?);
        }
        faces.push(&corners);
        lines.end_record();
    }
    let vertices = vertices(lines, largest)?;
    Ok(PolygonData { faces, vertices })
}

/// Reads the number of a vertex, returned counting from 0. Updates `largest`, which counts from 1.
fn vertex_index(lines: &mut SffLines, largest: &mut u32) -> SffResult<u32> {
    let place = lines.place();
    let index = lines.index()?;
    // Each vertex takes at least six bytes below.
    if index == 0 || index as usize > lines.bytes_left() / 6 + 1 {
        let expected = "the number of a vertex of this object, counted from 1";
        return Err(lines.error(place, format!("vertex {index}"), expected));
    }
    *largest = index.max(*largest);
    Ok(index - 1)
}

/// Reads as many vertices as the faces use, and the empty line after them.
fn vertices(lines: &mut SffLines, count: u32) -> SffResult<Vec<DVec3>> {
    let mut vertices = Vec::new();
    for k in 0..count {
        let place = lines.place();
        if lines.rest_is_blank() {
            let found = format!("{k} vertices");
            return Err(lines.error(place, found, format!("{count}, as the faces use")));
        }
        vertices.push(lines.point()?);
        lines.end_record();
    }
    let place = lines.place();
    if lines.section_ends() {
        return Ok(vertices);
    }
    let expected = format!("an empty line after the {count} vertices that the faces use");
    Err(lines.error(place, "more vertices or another record", expected))
}

/// Reads triangles: three positions, each with a normal, and three surfaces if they are `general`.
pub(super) fn triangles(lines: &mut SffLines, general: bool) -> SffResult<TriangleData> {
    let mut data = TriangleData::default();
    while !lines.section_ends() {
        let mut corners = [(DVec3::ZERO, DVec3::ZERO); 3];
        for (position, normal) in &mut corners {
            *position = lines.point()?;
            *normal = lines.direction()?;
        }
        data.corners.push(corners);
        if general {
            let surfaces = [lines.index()?, lines.index()?, lines.index()?];
            data.surfaces.push(surfaces);
        }
        lines.end_record();
    }
    Ok(data)
}
