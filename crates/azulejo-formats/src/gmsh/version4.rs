//! Entities, nodes and elements of version 4.1: blocks, each of one entity.

use super::element_types::MshShape;
use super::mesh::MshMesh;
use super::source::MshSource;
use super::version2::next_type;
use crate::ReadError;
use glam::DVec3;
use std::collections::HashMap;

/// What is known of the entities of a file, by dimension and number.
#[derive(Debug, Default)]
pub(super) struct MshEntities {
    known: HashMap<(i64, i64), MshEntity>,
    /// Surfaces of several physical groups.
    pub shared: usize,
    /// Elements on surfaces between partitions of a volume.
    pub between: usize,
}

#[derive(Clone, Copy, Debug)]
struct MshEntity {
    /// Its first physical group; negative if its elements look to the other side.
    physical: Option<i64>,
    /// Whether it divides an entity of higher dimension.
    is_between: bool,
}

impl MshEntities {
    /// Reads the content of `$Entities`.
    pub fn read(&mut self, source: &mut MshSource) -> Result<(), ReadError> {
        for (dimension, count) in counts(source)? {
            for _ in 0..count {
                let number = source.int("the number of an entity")?;
                self.entity(source, dimension, number, dimension)?;
            }
        }
        Ok(())
    }

    /// Reads the content of `$PartitionedEntities`, to which the elements of a divided mesh belong.
    pub fn read_partitioned(&mut self, source: &mut MshSource) -> Result<(), ReadError> {
        source.size("a number of partitions")?;
        for _ in 0..source.size("a number of ghost entities")? {
            source.int("a ghost entity")?;
            source.int("a partition")?;
        }
        for (dimension, count) in counts(source)? {
            for _ in 0..count {
                let number = source.int("the number of an entity")?;
                let parent = source.int("the dimension of the parent")?;
                source.int("the parent of an entity")?;
                for _ in 0..source.size("a number of partitions")? {
                    source.int("a partition")?;
                }
                self.entity(source, dimension, number, parent)?;
            }
        }
        Ok(())
    }

    /// Reads an entity from its bounding box on.
    fn entity(
        &mut self,
        source: &mut MshSource,
        dimension: i64,
        number: i64,
        parent: i64,
    ) -> Result<(), ReadError> {
        source.skip_numbers(if dimension == 0 { 3 } else { 6 })?;
        let (mut physical, groups) = (None, source.size("a number of physical groups")?);
        for _ in 0..groups {
            let group = source.int("a physical group")?;
            physical = physical.or(Some(group).filter(|&g| g != 0));
        }
        self.shared += usize::from(dimension == 2 && groups > 1);
        if dimension > 0 {
            for _ in 0..source.size("a number of boundaries")? {
                source.int("a boundary of an entity")?;
            }
        }
        let is_between = parent != dimension;
        let entity = MshEntity {
            physical,
            is_between,
        };
        self.known.insert((dimension, number), entity);
        Ok(())
    }
}

/// The numbers of entities of each dimension.
fn counts(source: &mut MshSource) -> Result<[(i64, u64); 4], ReadError> {
    let mut counts = [(0, 0); 4];
    for (dimension, count) in counts.iter_mut().enumerate() {
        *count = (dimension as i64, source.size("a number of entities")?);
    }
    Ok(counts)
}

/// Reads the content of `$Nodes`.
pub(super) fn nodes(source: &mut MshSource, mesh: &mut MshMesh) -> Result<(), ReadError> {
    let blocks = header(source, "nodes")?;
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let dimension = source.int("the dimension of an entity")?;
        source.int("the number of an entity")?;
        let is_parametric = source.int("0 or 1 for coordinates on the entity")? != 0;
        let parameters = if is_parametric {
            dimension.max(0) as u64
        } else {
            0
        };
        numbers.clear();
        for _ in 0..source.size("a number of nodes")? {
            numbers.push(source.size("the number of a node")?);
        }
        for &number in &numbers {
            let mut axis = || source.number("a coordinate of a node");
            let position = DVec3::new(axis()?, axis()?, axis()?);
            source.skip_numbers(parameters)?;
            mesh.node(number, position);
        }
    }
    Ok(())
}

/// Reads the first line of `$Nodes` or `$Elements`; returns the number of blocks.
fn header(source: &mut MshSource, of: &str) -> Result<u64, ReadError> {
    let blocks = source.size("a number of blocks")?;
    source.size(&format!("a number of {of}"))?;
    source.size("the least number")?;
    source.size("the greatest number")?;
    Ok(blocks)
}

/// Reads the content of `$Elements`.
pub(super) fn elements(
    source: &mut MshSource,
    mesh: &mut MshMesh,
    entities: &mut MshEntities,
) -> Result<(), ReadError> {
    let mut nodes = Vec::new();
    for _ in 0..header(source, "elements")? {
        source.int("the dimension of an entity")?;
        let number = source.int("the number of an entity")?;
        let (shape, count) = next_type(source)?;
        let elements = source.size("a number of elements")?;
        let dimension = if matches!(shape, MshShape::Cell(_)) {
            3
        } else {
            2
        };
        let entity = entities.known.get(&(dimension.into(), number)).copied();
        let physical = entity.and_then(|e| e.physical);
        let is_between = entity.is_some_and(|e| e.is_between);
        let reversed = physical.is_some_and(|p| p < 0);
        let group = if shape == MshShape::Line || is_between || elements == 0 {
            0
        } else {
            mesh.group_of(shape, physical, number)
        };
        for _ in 0..elements {
            let at = source.next_offset();
            source.size("the number of an element")?;
            nodes.clear();
            for _ in 0..count {
                nodes.push(source.size("a node of an element")?);
            }
            if is_between && shape != MshShape::Line {
                entities.between += 1;
                continue;
            }
            mesh.element(shape, &nodes, (group, reversed), (source, at))?;
        }
    }
    Ok(())
}
