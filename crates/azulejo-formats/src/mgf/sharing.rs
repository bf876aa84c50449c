//! Meshes that arrays and included files repeat: stored once, and placed for each instance.
//!
//! The content of an array is read again for each of its instances, since definitions in it may change
//! what the next one is. Its meshes are built in the coordinates of the content, where all instances are
//! equal to the last bit, and become instances of one mesh where they are.

use super::lines::StatementAddress;
use azulejo_scene::{Mesh, MeshInstance, Shape, SharedMesh};
use glam::DAffine3;
use std::collections::HashMap;

/// Meshes with fewer corners are copied: rays pass them faster, and an instance takes as much memory.
const LEAST_CORNERS: usize = 64;

/// How many different meshes of one statement are remembered, so that finding one takes no longer than
/// reading it.
const MOST_VARIANTS: usize = 4;

/// Coordinates in which meshes are built: the world, and inside it those of the content of each open
/// instance of an array or file.
#[derive(Debug)]
pub(super) struct ContentFrames {
    /// The world, then one frame inside the other.
    frames: Vec<ContentFrame>,
}

/// The coordinates of an array's or file's content, in one instance.
#[derive(Clone, Copy, Debug)]
struct ContentFrame {
    outer_from_frame: DAffine3,
    world_from_frame: DAffine3,
}

/// Index of a frame among [`ContentFrames`].
pub(super) type FrameId = usize;

/// The coordinates of the world.
pub(super) const WORLD: FrameId = 0;

impl ContentFrames {
    /// Only the world.
    pub fn new() -> ContentFrames {
        let world = ContentFrame {
            outer_from_frame: DAffine3::IDENTITY,
            world_from_frame: DAffine3::IDENTITY,
        };
        ContentFrames {
            frames: vec![world],
        }
    }

    /// Begins a frame inside `outer`, and ends those that were there; `None` if no mesh can be placed by
    /// its map, which flattens or overflows.
    pub fn enter(
        &mut self,
        outer: FrameId,
        outer_from_frame: DAffine3,
        world_from_frame: DAffine3,
    ) -> Option<FrameId> {
        let size = world_from_frame.matrix3.determinant();
        let is_usable = size != 0.0 && size.is_finite() && world_from_frame.is_finite();
        if !is_usable || !outer_from_frame.is_finite() {
            return None;
        }
        self.frames.truncate(outer + 1);
        self.frames.push(ContentFrame {
            outer_from_frame,
            world_from_frame,
        });
        Some(self.frames.len() - 1)
    }

    /// The map of a frame to the world.
    pub fn world_from(&self, frame: FrameId) -> DAffine3 {
        self.frames[frame].world_from_frame
    }

    /// The map from a frame to one that it is in.
    pub fn outer_from(&self, outer: FrameId, frame: FrameId) -> DAffine3 {
        let between = self.frames[outer + 1..=frame].iter();
        between.fold(DAffine3::IDENTITY, |map, f| map * f.outer_from_frame)
    }
}

/// Which statement made a mesh that others may be equal to, and the place of this one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RepeatedOrigin {
    pub statement: StatementAddress,
    pub world_from_frame: DAffine3,
}

/// The meshes that statements have made.
#[derive(Debug, Default)]
pub(super) struct RepeatedMeshes {
    by_statement: HashMap<StatementAddress, Vec<SharedMesh>>,
}

impl RepeatedMeshes {
    /// A mesh in the coordinates of its frame, at its place: an instance, if meshes of its size are shared.
    pub fn place(&mut self, mesh: Mesh, origin: &RepeatedOrigin) -> Shape {
        let world_from_frame = &origin.world_from_frame;
        if mesh.faces.corners.len() < LEAST_CORNERS {
            return copied(mesh, world_from_frame);
        }
        let shared = self.equal_to(mesh, origin.statement);
        let placed = shared.placed(*world_from_frame);
        match placed.filter(MeshInstance::is_finite) {
            Some(placed) => Shape::Instance(placed),
            None => copied(Mesh::clone(shared.mesh()), world_from_frame),
        }
    }

    /// The mesh, as one that the same statement made before if there is an equal one.
    fn equal_to(&mut self, mesh: Mesh, statement: StatementAddress) -> &mut SharedMesh {
        let known = self.by_statement.entry(statement).or_default();
        let at = known.iter().position(|shared| **shared.mesh() == mesh);
        let at = at.unwrap_or_else(|| {
            if known.len() == MOST_VARIANTS {
                known.remove(0);
            }
            known.push(SharedMesh::new(mesh));
            known.len() - 1
        });
        &mut known[at]
    }
}

fn copied(mut mesh: Mesh, world_from_frame: &DAffine3) -> Shape {
    mesh.transform(world_from_frame);
    Shape::Mesh(mesh)
}
