//! The data of patches, polygons and triangles.

use super::SffResult;
use super::document::*;
use super::lines::SffLines;
use glam::DVec3;

/// Data behind a record: the lines below it, or the name of a file. The record's line is passed.
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

/// Twelve vertices a patch; then the vertices.
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

/// A count and as many vertices a polygon; then the vertices.
pub(super) fn polygons(lines: &mut SffLines) -> SffResult<PolygonData> {
    let mut largest = 0;
    let mut faces = azulejo_scene::Faces::default();
    let mut corners = Vec::new();
    while !lines.section_ends() {
        let place = lines.place();
        let count = lines.index()?;
        // Each takes a digit and a blank.
        if count < 3 || 2 * (count as usize - 1) > lines.bytes_left() {
            let found = format!("a polygon of {count} vertices");
            return Err(lines.error(place, found, "3 or more, all of them behind the count"));
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

/// The number of a vertex, from 0 on. Raises `largest`, from 1 on.
fn vertex_index(lines: &mut SffLines, largest: &mut u32) -> SffResult<u32> {
    let place = lines.place();
    let index = lines.index()?;
    // Each vertex takes six bytes somewhere below.
    if index == 0 || index as usize > lines.bytes_left() / 6 + 1 {
        let expected = "the number of a vertex of this object, from 1 on";
        return Err(lines.error(place, format!("vertex {index}"), expected));
    }
    *largest = index.max(*largest);
    Ok(index - 1)
}

/// As many vertices as the faces use, and the empty line behind them.
fn vertices(lines: &mut SffLines, count: u32) -> SffResult<Vec<DVec3>> {
    let mut vertices = Vec::new();
    for k in 0..count {
        let place = lines.place();
        if lines.rest_is_blank() {
            let found = format!("{k} vertices");
            return Err(lines.error(place, found, format!("{count}, which the faces use")));
        }
        vertices.push(lines.point()?);
        lines.end_record();
    }
    let place = lines.place();
    if lines.section_ends() {
        return Ok(vertices);
    }
    let expected = format!("an empty line behind the {count} vertices that the faces use");
    Err(lines.error(place, "more vertices or another record", expected))
}

/// Three positions with their normals each, and three surfaces if they are `general`.
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
