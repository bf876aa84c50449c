//! 3D Studio: what the chunks say, and the box as OpenSceneGraph has it, which keeps z up.

use super::Quantity::{Bounds, Faces, Objects, Triangles, Vertices};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["3ds/"],
    compared: &[
        (Objects, &["raw_objects"]),
        (Vertices, &["raw_vertices"]),
        (Faces, &["raw_faces"]),
        (Triangles, &["raw_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[],
    exceptions: &[],
};
