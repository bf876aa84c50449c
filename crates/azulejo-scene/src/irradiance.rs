//! The result of the first pass, which the second pass reads: irradiance on vertices.

use crate::{BackIrradiance, Mesh, Rgb, SurfaceLight};

/// Irradiance of a whole scene, one entry per object in the scene's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// One entry per object.
    pub objects: Vec<ObjectIrradiance>,
}

/// Irradiance of one object.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectIrradiance {
    /// Irradiance on the vertices that the mesh already has.
    Vertices {
        /// W/m², one per vertex.
        irradiance: Vec<Rgb>,
        /// Standard error, one per vertex or empty.
        error: Vec<Rgb>,
        /// Irradiance of the back, if it was requested.
        back: Option<Box<BackIrradiance>>,
        /// The faces, in ascending order, whose back is what the irradiance is for: they are to be
        /// [turned](Mesh::turn_faces).
        turned: Vec<u32>,
    },
    /// The mesh divided into patches, with irradiance on its vertices; for an exact shape, its
    /// proxy mesh.
    Refined(Box<Mesh>),
    /// Irradiance on the surface of an exact primitive.
    Surface(SurfaceLight),
}
