//! Height fields.

use super::builder::VrmlSceneBuilder;
use super::shape::{SurfaceFields, ValuePool};
use super::tree::VrmlNode;
use crate::ReadError;
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// The quadrilaterals of a node `ElevationGrid`; `None` if the grid has no cell.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn surface<'n>(
    builder: &mut VrmlSceneBuilder,
    node: &'n VrmlNode,
) -> Result<Option<SurfaceFields<'n>>, ReadError> {
    let heights = node.numbers("height");
    let size = |name: &str| node.number(name, 0.0).max(0.0) as usize;
    let (columns, stated_rows) = (size("xDimension"), size("zDimension"));
    if columns < 2 || stated_rows < 2 {
        return Ok(None);
    }
    let rows = stated_rows.min(heights.len() / columns);
    let message = "incomplete row of an ElevationGrid: skipped";
    builder.warn_many(&node.source, node.at, message, stated_rows - rows);
    if rows < 2 {
        return Ok(None);
    }
    builder.spend(6 * (columns * rows) as u64)?;
    let spacing = |name: &str| node.number(name, 1.0);
    let (dx, dz) = (spacing("xSpacing"), spacing("zSpacing"));
    let mut lost = 0;
    let mut positions = Vec::with_capacity(columns * rows);
    for (i, &height) in heights[..columns * rows].iter().enumerate() {
        let (column, row) = ((i % columns) as f64, (i / columns) as f64);
        lost += usize::from(!height.is_finite());
        let height = if height.is_finite() { height } else { 0.0 };
        positions.push(DVec3::new(dx * column, height, dz * row));
    }
    let message = "height that is not finite: taken as 0";
    builder.warn_many(&node.source, node.at, message, lost);
    let mut surface = SurfaceFields::new(node, positions, Cow::Owned(quads(columns, rows)));
    builder.attributes(node, &mut surface)?;
    if surface.uvs.is_none() {
        surface.uvs = Some(ValuePool::per_vertex(mapping(columns, rows)));
    }
    Ok(Some(surface))
}

/// Corners of the cells, row by row, counter-clockwise as seen from above.
fn quads(columns: usize, rows: usize) -> Vec<i32> {
    let mut index = Vec::with_capacity(5 * (columns - 1) * (rows - 1));
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let at = |dx: usize, dz: usize| ((row + dz) * columns + column + dx) as i32;
            index.extend([at(0, 0), at(0, 1), at(1, 1), at(1, 0), -1]);
        }
    }
    index
}

/// Texture coordinates that spread the texture over the whole grid: ISO/IEC 14772-1, 6.17.
fn mapping(columns: usize, rows: usize) -> Vec<DVec2> {
    let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    let uv = |i| DVec2::new(share(i % columns, columns), share(i / columns, rows));
    (0..columns * rows).map(uv).collect()
}
