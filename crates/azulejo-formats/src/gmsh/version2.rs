//! Nodes and elements of versions 2.0 to 2.2: one list of each, with the groups beside each element.

use super::element_types::{MshShape, element_type};
use super::mesh::MshMesh;
use super::source::{MshEncoding, MshSource};
use crate::ReadError;
use glam::DVec3;

/// Reads the content of `$Nodes` or, with coordinates on the geometry, of `$ParametricNodes`.
pub(super) fn nodes(
    source: &mut MshSource,
    mesh: &mut MshMesh,
    are_parametric: bool,
) -> Result<(), ReadError> {
    for _ in 0..source.count_line("a number of nodes")? {
        let number = source.int("the number of a node")?;
        let mut axis = || source.number("a coordinate of a node");
        let position = DVec3::new(axis()?, axis()?, axis()?);
        if are_parametric {
            let dimension = source.int("the dimension of an entity")?;
            source.int("the number of an entity")?;
            source.skip_numbers(match dimension {
                1 => 1,
                2 => 2,
                _ => 0,
            })?;
        }
        mesh.node(number as u64, position);
    }
    Ok(())
}

/// Reads the content of `$Elements`; returns how often an element was repeated for another group.
pub(super) fn elements(source: &mut MshSource, mesh: &mut MshMesh) -> Result<usize, ReadError> {
    let mut reader = ElementReader {
        mesh,
        nodes: Vec::new(),
        last: Vec::new(),
        last_entity: None,
        repeated: 0,
    };
    let count = source.count_line("a number of elements")?;
    let mut done = 0;
    while done < count {
        done += match source.encoding {
            MshEncoding::Text => reader.line(source)?,
            MshEncoding::Binary { .. } => reader.block(source)?,
        };
    }
    Ok(reader.repeated)
}

/// The type of the next element.
pub(super) fn next_type(source: &mut MshSource) -> Result<(MshShape, usize), ReadError> {
    let at = source.next_offset();
    let number = source.int("the type of an element")?;
    element_type(number).ok_or_else(|| {
        let found = format!("element type {number}");
        source.error(
            at,
            found,
            "lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms or pyramids",
        )
    })
}

struct ElementReader<'a> {
    mesh: &'a mut MshMesh,
    /// The nodes of the current element.
    nodes: Vec<u64>,
    /// Those of the last one, and its entity.
    last: Vec<u64>,
    last_entity: Option<i64>,
    repeated: usize,
}

impl ElementReader<'_> {
    /// One element of a text.
    fn line(&mut self, source: &mut MshSource) -> Result<u64, ReadError> {
        let at = source.next_offset();
        source.int("the number of an element")?;
        let kind = next_type(source)?;
        let tags = source.int("a number of tags")?;
        self.element(source, at, kind, tags)?;
        Ok(1)
    }

    /// Elements of one type of a binary file; returns how many.
    fn block(&mut self, source: &mut MshSource) -> Result<u64, ReadError> {
        let kind = next_type(source)?;
        let at = source.next_offset();
        let count = source.int("a number of elements")?;
        let tags = source.int("a number of tags")?;
        let Some(count) = u64::try_from(count).ok().filter(|&c| c > 0) else {
            let found = format!("{count} elements in a block");
            return Err(source.error(at, found, "one or more"));
        };
        for _ in 0..count {
            let at = source.next_offset();
            source.int("the number of an element")?;
            self.element(source, at, kind, tags)?;
        }
        Ok(count)
    }

    /// The tags and nodes of an element.
    fn element(
        &mut self,
        source: &mut MshSource,
        at: usize,
        (shape, count): (MshShape, usize),
        tags: i64,
    ) -> Result<(), ReadError> {
        let (mut physical, mut entity) = (0, 0);
        for k in 0..tags {
            let tag = source.int("a tag of an element")?;
            match k {
                0 => physical = tag,
                1 => entity = tag,
                // Partitions, which are not a matter of geometry.
                _ => {}
            }
        }
        std::mem::swap(&mut self.nodes, &mut self.last);
        self.nodes.clear();
        for _ in 0..count {
            self.nodes.push(source.int("a node of an element")? as u64);
        }
        // An element of several physical groups is written once for each of them.
        let is_repeated = self.nodes == self.last && self.last_entity == Some(entity);
        self.last_entity = Some(entity);
        if is_repeated {
            self.repeated += 1;
            return Ok(());
        }
        let group = match shape {
            MshShape::Line => 0,
            _ => self.mesh.group_of(shape, Some(physical), entity),
        };
        let is_reversed = physical < 0;
        self.mesh
            .element(shape, &self.nodes, (group, is_reversed), (source, at))
    }
}
