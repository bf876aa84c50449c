//! Meshes that a file repeats: stored once, and placed for each repetition.
//!
//! A reader that builds a mesh anew for each place of the same text, in the same coordinates, gets equal
//! meshes, unless something else has changed in between; those that are equal become instances of one.

use azulejo_scene::{Mesh, MeshInstance, Shape, SharedMesh};
use glam::DAffine3;
use std::collections::HashMap;

/// Meshes with fewer corners are copied: rays pass them faster, and an instance takes as much memory.
const LEAST_CORNERS: usize = 64;

/// How many different meshes of one text are remembered, so that finding one takes no longer than
/// building it.
const MOST_VARIANTS: usize = 4;

/// Where the text of a mesh stands in memory: tells the texts of all files apart. Meshes are compared in any
/// case, so that an address that is used again costs time alone.
pub(crate) type TextAddress = *const u8;

/// The meshes that were built, by their texts.
#[derive(Debug, Default)]
pub(crate) struct RepeatedMeshes {
    by_text: HashMap<TextAddress, Vec<SharedMesh>>,
}

impl RepeatedMeshes {
    /// A mesh in coordinates of its own, at its place: an instance, if it is large enough. Where the map
    /// flattens or overflows it is a copy, whose positions need not be finite.
    ///
    /// Once all are placed, [`Scene::unfold_single_instances`](azulejo_scene::Scene::unfold_single_instances)
    /// is for those that were not repeated.
    pub fn place(&mut self, mesh: Mesh, text: TextAddress, world_from_mesh: &DAffine3) -> Shape {
        if mesh.faces.corners.len() < LEAST_CORNERS {
            return copied(mesh, world_from_mesh);
        }
        let shared = self.equal_to(mesh, text);
        let placed = shared.placed(*world_from_mesh);
        match placed.filter(MeshInstance::is_finite) {
            Some(placed) => Shape::Instance(placed),
            None => copied(Mesh::clone(shared.mesh()), world_from_mesh),
        }
    }

    /// The mesh, as one that was built of the same text before if there is an equal one.
    fn equal_to(&mut self, mesh: Mesh, text: TextAddress) -> &mut SharedMesh {
        let known = self.by_text.entry(text).or_default();
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

fn copied(mut mesh: Mesh, world_from_mesh: &DAffine3) -> Shape {
    mesh.transform(world_from_mesh);
    Shape::Mesh(mesh)
}
